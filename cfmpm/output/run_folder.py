"""The folder of a run: lock, start, status and removal of earlier results."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import xarray as xr
from filelock import FileLock, Timeout

from cfmpm.errors import Problem, SceneError
from cfmpm.output.files import in_file_name
from cfmpm.output.netcdf import DamagedError, read_netcdf

HISTORY, CHECKPOINT = "history.nc", "checkpoint.npz"
# Fields of the last state, and the index of the fields by step.
FIELDS, INDEX = "fields.nc", "fields_index.nc"
# Figure of the scene, also of `cfmpm check`.
SCENE = "scene.png"
# Status of a run whose history is incomplete (`ending.RUN_STATUS`).
UNFINISHED = "unfinished"
_LOCK = ".lock"
# Exists from the start of a new run until its first step is written.
_STARTED = ".started"
OF_STEPS = re.compile(r"fields_\d{4,}\.nc")
_ASIDE = re.compile(r"\.(history|checkpoint|fields(_\d{4,}|_index)?)\.np?[cz]\.[0-9a-f]{8}\.part")
_OF_RUN = re.compile(
    r"history\.nc|checkpoint\.npz|fields(_\d{4,}|_index)?\.nc|\.lock|\.started|scene\.png"
)
# Files of `cfmpm plot` and `cfmpm export`.
_PICTURES = ("deformed", "paths", "cf", "factors", "angles", "energy", "load", "cycles")
_PICTURES_OF_TIPS = ("mesh", "cf", "radii", "steps")
_FILM, EXPORT = "growth.gif", "vtu"
_EXPORTED = re.compile(r"(grid|points|cracks)(_\d{4,}\.vtu|\.pvd)")


@contextmanager
def held(folder: Path) -> Iterator[None]:
    """Lock a folder against other runs within the ``with`` block.

    Parameters
    ----------
    folder : Path
        Made if needed.

    Raises
    ------
    SceneError
        If another run has locked it.

    Notes
    -----
    It is a lock of the operating system, which also ends if the process is killed.
    """
    folder.mkdir(parents=True, exist_ok=True)
    _remove_link(folder / _LOCK)
    lock = FileLock(folder / _LOCK)
    try:
        lock.acquire(blocking=False)
    except Timeout:
        reason = "another run is writing here: wait until it has ended, or use another folder"
        raise SceneError([Problem(reason, file=str(folder))]) from None
    try:
        yield
    finally:
        # The lock is still held; FileLock makes a new file for a process that opens it from now on.
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
    """Begin a new run in a locked folder.

    The results of an earlier run are kept until the new run calls `clear`, when it has a result to
    replace them.

    Parameters
    ----------
    folder : Path
    overwrite : bool
        Whether an interrupted run that could be resumed may be replaced.

    Raises
    ------
    SceneError
        If there is such a run and it may not be replaced.
    """
    if not overwrite and is_unfinished(folder):
        reason = (
            f"has a run that was interrupted: cfmpm resume {folder} resumes it; --overwrite (in "
            "Python overwrite=True) replaces it by a new run"
        )
        raise SceneError([Problem(reason, file=str(folder))])
    _remove_link(folder / _STARTED)
    (folder / _STARTED).touch()
    try:
        yield
    finally:
        (folder / _STARTED).unlink(missing_ok=True)


def require_own(folder: Path, name: str) -> Path:
    """Refuse a folder in that of a result which is a link: what it leads to is not the result's.

    Parameters
    ----------
    folder : Path
    name : str
        Of the inner folder.

    Returns
    -------
    Path
        The inner folder, which need not exist.

    Raises
    ------
    SceneError
    """
    inner = folder / name
    if inner.is_symlink():
        reason = "is a link, and nothing is written where it leads; give that folder by --output"
        raise SceneError([Problem(reason, file=str(inner))])
    return inner


def require_places(folder: Path) -> None:
    """Refuse a folder in which a folder stands where a run would write a file.

    Raises
    ------
    SceneError
    """
    for path in sorted(folder.iterdir()):
        if _OF_RUN.fullmatch(path.name) and path.is_dir() and not path.is_symlink():
            reason = "is a folder, and a run writes a file of this name: move it away"
            raise SceneError([Problem(reason, file=str(path))])


def is_unfinished(folder: Path) -> bool:
    """Whether a folder has a run that was interrupted after its first step."""
    return (folder / CHECKPOINT).exists() or run_status(folder) == UNFINISHED


def was_killed_at_start(folder: Path) -> bool:
    """Whether the last run in a folder was killed before it wrote a step."""
    return (folder / _STARTED).exists()


def run_status(folder: Path) -> str:
    """Return the status of the run in a folder; empty if it cannot be read."""
    history = _history(folder)
    return "" if history is None else str(history.attrs.get("run_status", ""))


def clear(folder: Path, shown: str) -> None:
    """Remove the results of an earlier run from a folder, including figures and exports.

    Files that cfmpm does not write are kept, and the figure of the scene if it is that of the new
    run. So is the history, which is replaced by renaming the new one: if the process is killed
    before, the history of the earlier run remains.

    Parameters
    ----------
    folder : Path
    shown : str
        Description of the figure of the new run's scene (`description`).
    """
    # The index before the files in it.
    names = [INDEX, FIELDS, *(p.name for p in folder.iterdir() if OF_STEPS.fullmatch(p.name))]
    for name in (*names, CHECKPOINT):
        _remove(folder / name)
    clear_shown(folder, shown)
    (folder / _STARTED).unlink(missing_ok=True)


def clear_shown(folder: Path, shown: str) -> None:
    """Remove the figures and exports of a result that is about to change.

    Parameters
    ----------
    folder : Path
    shown : str
        Description of the figure of the scene, which is kept if it is of this scene.
    """
    drawn = {f"{name}.png" for name in _PICTURES} | {_FILM}
    if not _describes(folder / SCENE, shown):
        drawn.add(SCENE)
    history = _history(folder)
    if history is not None:
        # Names of a mesh file may be any text; those of a history that is not ours, too.
        tips, parts = (
            [in_file_name(word) for word in history[name].values.ravel().tolist()]
            for name in ("tip", "boundary")
        )
        drawn |= {f"{name}_{tip}.png" for name in _PICTURES_OF_TIPS for tip in tips}
        drawn |= {f"force_{part}_{axis}.png" for part in parts for axis in "xy"}
    for name in sorted(drawn):
        _remove(folder / name)
    exported = folder / EXPORT
    # What is behind a link is not this result's.
    if exported.is_dir() and not exported.is_symlink():
        for path in exported.iterdir():
            if _EXPORTED.fullmatch(path.name):
                _remove(path)
        if not any(exported.iterdir()):
            exported.rmdir()


def remove_leavings(folder: Path) -> None:
    """Remove temporary files of a killed run from a locked folder."""
    for path in list(folder.iterdir()):
        if _ASIDE.fullmatch(path.name):
            _remove(path)


def _remove(path: Path) -> None:
    """Take a file away, or a link, but no folder: cfmpm makes none of that name."""
    if path.is_symlink() or not path.is_dir():
        path.unlink(missing_ok=True)


def _remove_link(path: Path) -> None:
    """Take away a link where a file is to be made: it would be made where the link leads."""
    if path.is_symlink():
        path.unlink()


def description(config_hash: str) -> str:
    """Return the description in the file of the figure of a scene."""
    return f"scene {config_hash}"


def _describes(picture: Path, shown: str) -> bool:
    """Whether a figure has a description in its file."""
    if not picture.exists():
        return False
    from PIL import Image  # only where `cfmpm check` or `cfmpm plot` has been used

    try:
        with Image.open(picture) as image:
            return bool(image.info.get("Description") == shown)
    except (OSError, ValueError, SyntaxError, MemoryError, Image.DecompressionBombError):
        return False


def _history(folder: Path) -> xr.Dataset | None:
    """The history in a folder; None if it cannot be read."""
    try:
        history = read_netcdf(folder / HISTORY)
    except (OSError, DamagedError):
        return None
    return history if {"tip", "boundary"} <= set(history.variables) else None
