"""The folder of a run: one run at a time writes there, and the files of two never mix."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import xarray as xr
from filelock import FileLock, Timeout

from cfmpm.errors import Problem, SceneError

HISTORY, CHECKPOINT = "history.nc", "checkpoint.npz"
# Fields of the end, and of each step with the table of them.
FIELDS, INDEX = "fields.nc", "fields_index.nc"
# The picture of the scene, which `cfmpm check` draws before there is a run.
SCENE = "scene.png"
# Status of a run whose history is not whole (`ending.RUN_STATUS`).
UNFINISHED = "unfinished"
_LOCK = ".lock"
# Stands there from the start of a new run until it has written its first step.
_STARTED = ".started"
_OF_STEPS = re.compile(r"fields_\d{4,}\.nc")
_ASIDE = re.compile(r"\.(history|checkpoint|fields(_\d{4,}|_index)?)\.np?[cz]\.[0-9a-f]{8}\.part")
# What `cfmpm plot` and `cfmpm export` make of a run.
_PICTURES = ("deformed", "paths", "cf", "factors", "angles", "energy", "load", "cycles")
_PICTURES_OF_TIPS = ("mesh", "cf", "radii", "steps")
_FILM, _EXPORT = "growth.gif", "vtu"
_EXPORTED = re.compile(r"(grid|points|cracks)(_\d{4,}\.vtu|\.pvd)")


@contextmanager
def held(folder: Path) -> Iterator[None]:
    """Keep all other runs out of a folder as long as the ``with`` block lasts.

    Parameters
    ----------
    folder : Path
        Made if needed.

    Raises
    ------
    SceneError
        Where another run holds it.

    Notes
    -----
    The lock is the system's: it ends with the process, however that ends.
    """
    folder.mkdir(parents=True, exist_ok=True)
    lock = FileLock(folder / _LOCK)
    try:
        lock.acquire(blocking=False)
    except Timeout:
        reason = "another run is writing here: wait for its end, or write to another folder"
        raise SceneError([Problem(reason, file=str(folder))]) from None
    try:
        yield
    finally:
        # Still held: who opens the file from now on opens a new one, as FileLock sees to.
        (folder / _LOCK).unlink(missing_ok=True)
        lock.release()


def is_held(folder: Path) -> bool:
    """Whether a run is writing to a folder."""
    if not (folder / _LOCK).exists():
        return False
    try:
        with held(folder):
            return False
    except SceneError:
        return True


@contextmanager
def starting(folder: Path, *, overwrite: bool) -> Iterator[None]:
    """Begin a new run in a folder that is held.

    What an earlier run has left stays until `clear` is called, which the new run does as soon as it
    has something to put in its place.

    Parameters
    ----------
    folder : Path
    overwrite : bool
        Whether a run may be lost that could still go on.

    Raises
    ------
    SceneError
        Where it may not.
    """
    if not overwrite and is_unfinished(folder):
        reason = (
            f"holds a run that was broken off: cfmpm resume {folder} goes on with it; a new run "
            "takes its place with --overwrite (in Python overwrite=True)"
        )
        raise SceneError([Problem(reason, file=str(folder))])
    (folder / _STARTED).touch()
    try:
        yield
    finally:
        (folder / _STARTED).unlink(missing_ok=True)


def is_unfinished(folder: Path) -> bool:
    """Whether a folder holds a run that was broken off after its first step."""
    return (folder / CHECKPOINT).exists() or run_status(folder) == UNFINISHED


def was_killed_at_start(folder: Path) -> bool:
    """Whether the last run in a folder was killed before it had written anything."""
    return (folder / _STARTED).exists()


def run_status(folder: Path) -> str:
    """Return how the run in a folder ended; empty where that cannot be read."""
    history = _history(folder)
    return "" if history is None else str(history.attrs.get("run_status", ""))


def clear(folder: Path, shown: str) -> None:
    """Take away all that an earlier run has left in a folder, and what was drawn or exported.

    Files that cfmpm does not write stay, and so does the picture of the scene that is now run. So
    does the history, which the new one is to be renamed over: until then a kill leaves the earlier
    run, only less complete.

    Parameters
    ----------
    folder : Path
    shown : str
        What the picture of the new run's scene is described by (`description`).
    """
    drawn = {f"{name}.png" for name in _PICTURES} | {_FILM, FIELDS, INDEX}
    if not _describes(folder / SCENE, shown):
        drawn.add(SCENE)
    history = _history(folder)
    if history is not None:
        tips, parts = (history[name].values.tolist() for name in ("tip", "boundary"))
        drawn |= {f"{name}_{tip}.png" for name in _PICTURES_OF_TIPS for tip in tips}
        drawn |= {f"force_{part}_{axis}.png" for part in parts for axis in "xy"}
    # The table before what it lists.
    names = [INDEX, *sorted(drawn - {INDEX})]
    names += [path.name for path in folder.iterdir() if _OF_STEPS.fullmatch(path.name)]
    for name in (*names, CHECKPOINT):
        (folder / name).unlink(missing_ok=True)
    exported = folder / _EXPORT
    if exported.is_dir():
        for path in exported.iterdir():
            if _EXPORTED.fullmatch(path.name):
                path.unlink()
        if not any(exported.iterdir()):
            exported.rmdir()
    (folder / _STARTED).unlink(missing_ok=True)


def remove_leavings(folder: Path) -> None:
    """Take away what a killed run was writing aside, in a folder that is held."""
    for path in list(folder.iterdir()):
        if _ASIDE.fullmatch(path.name):
            path.unlink(missing_ok=True)


def description(config_hash: str) -> str:
    """Return what the picture of a scene says of itself."""
    return f"scene {config_hash}"


def _describes(picture: Path, shown: str) -> bool:
    """Whether a picture says of itself that it shows something."""
    if not picture.exists():
        return False
    from PIL import Image  # only where `cfmpm check` or `cfmpm plot` has been used

    try:
        with Image.open(picture) as image:
            return bool(image.info.get("Description") == shown)
    except OSError:
        return False


def _history(folder: Path) -> xr.Dataset | None:
    """The history in a folder, without its values; None where there is none to be read."""
    try:
        with xr.open_dataset(folder / HISTORY, engine="netcdf4") as history:
            return history[["tip", "boundary"]].load()
    except (OSError, RuntimeError, ValueError, KeyError):
        return None
