"""The fields of a run by step: one file for each step, since the grid changes, and an index."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import xarray as xr

from cfmpm.errors import Problem, SceneError
from cfmpm.output.fields import crack_length, state_fields
from cfmpm.output.files import write_dataset
from cfmpm.output.provenance import provenance
from cfmpm.output.reading import read_result
from cfmpm.output.record import Record
from cfmpm.output.run_folder import HISTORY, INDEX
from cfmpm.scene.model import Scene
from cfmpm.state import State


class FieldsByStep:
    """Writes the fields of every n-th step during a run.

    Parameters
    ----------
    folder : Path
        Files of an earlier run in it are removed.
    every : int or None
        The first step, every n-th step after it, and the last step are written; None: no step.
    done : int, optional
        Number of steps of the same run before it was interrupted; their files are kept.
    """

    def __init__(self, folder: Path, every: int | None, done: int = 0) -> None:
        self._folder, self._every = Path(folder), every
        self._rows: list[tuple[int, float, float, str]] = []
        # Writes the last state, if it is not written yet.
        self._last: Callable[[], None] | None = None
        if (self._folder / INDEX).exists():
            index = read_index(self._folder)
            rows = list(zip(*(index[name].values.tolist() for name in _COLUMNS), strict=True))
            self._rows = [row for row in rows if row[0] <= done]
            # The index first: if the process is killed in between, it lists no missing file.
            if self._rows:
                write_dataset(_index(self._rows).assign_attrs(index.attrs), self._folder / INDEX)
            else:
                (self._folder / INDEX).unlink()
            for *_, file in rows[len(self._rows) :]:
                (self._folder / file).unlink(missing_ok=True)

    def observe(self, state: State, record: Record) -> None:
        """Write the fields of a state if its step is to be written; observes `simulation.run`."""
        if self._every is None:
            return
        step, load_factor = len(record.steps), record.steps[-1].load_factor
        self._last = partial(self._write, state, record.scene, step, load_factor)
        if (step - 1) % self._every == 0:
            self.finish()

    def finish(self) -> None:
        """Write the fields of the last state, if they are not written yet."""
        if self._last is not None:
            self._last()
            self._last = None

    def _write(self, state: State, scene: Scene, step: int, load_factor: float) -> None:
        name, attributes = file_of_step(step), provenance(scene)
        write_dataset(state_fields(state, step, load_factor, attributes), self._folder / name)
        length = crack_length(state.body.triangulation)
        self._rows.append((step, load_factor, length, name))
        write_dataset(_index(self._rows).assign_attrs(attributes), self._folder / INDEX)


_COLUMNS = {
    "step": {"long_name": "load or growth step"},
    "load_factor": {"units": "1", "long_name": "factor on all loads of the scene"},
    "crack_length": {"units": "mm", "long_name": "length of all cracks together"},
    "file": {"long_name": "file of the fields of that step"},
}


def _index(rows: list[tuple[int, float, float, str]]) -> xr.Dataset:
    steps, factors, lengths, files = zip(*rows, strict=True)
    values = [np.array(steps), np.array(factors), np.array(lengths), np.array(files, object)]
    return xr.Dataset(
        {
            name: ("step", column, attributes)
            for (name, attributes), column in zip(_COLUMNS.items(), values, strict=True)
        }
    )


def list_fields(folder: Path) -> list[Path]:
    """Return the files of the fields by step of a run, in the order of the steps.

    Parameters
    ----------
    folder : Path

    Raises
    ------
    SceneError
        If there are none, if they cannot be read, or if they belong to another run than the history
        in the same folder.
    """
    folder = Path(folder)
    if not (folder / INDEX).exists():
        reason = "no fields by step; a run with output.every writes them"
        raise SceneError([Problem(reason, file=str(folder))])
    index = read_index(folder)
    require_same_run(folder, index, INDEX)
    files = [folder / str(name) for name in index["file"].values]
    missing = [
        Problem("is listed in the fields by step, but is missing", file=str(path))
        for path in files
        if not path.exists()
    ]
    if missing:
        raise SceneError(missing)
    return files


def fields_of_last_step(folder: Path, history: xr.Dataset) -> xr.Dataset | None:
    """Return the fields of the last state of balance of a run with fields by step.

    Parameters
    ----------
    folder : Path
    history : xarray.Dataset
        Of the run. Its very last step may be that of cracks alone, which have severed the body.

    Returns
    -------
    Dataset or None
        None where they were not written, as in a run that was broken off.

    Raises
    ------
    SceneError
        As `list_fields`.
    """
    fields = read_result(list_fields(folder)[-1], "face_nodes")
    solved = history["step"].values[np.isfinite(history["n_unknowns"].values)]
    return fields if fields["time"].values[-1] == solved[-1] else None


def require_same_run(folder: Path, fields: xr.Dataset, name: str) -> None:
    """Raise an error for fields of another scene than that of the history in the same folder.

    Parameters
    ----------
    folder : Path
    fields : xarray.Dataset
        Fields, or their index.
    name : str
        Name of their file.

    Raises
    ------
    SceneError
    """
    if not (folder / HISTORY).exists():
        return
    history = read_result(folder / HISTORY, "domain_radius")
    if fields.attrs.get("config_hash") != history.attrs["config_hash"]:
        reason = f"belongs to another run than {HISTORY}: run the scene again"
        raise SceneError([Problem(reason, file=str(folder / name))])


def read_index(folder: Path) -> xr.Dataset:
    """Return the table of the fields by step of a run.

    Parameters
    ----------
    folder : Path

    Raises
    ------
    SceneError
        Where it cannot be read, or names files that are not those of its steps.
    """
    index = read_result(folder / INDEX, "file")
    for step, name in zip(index["step"].values.tolist(), index["file"].values, strict=True):
        if name != file_of_step(step):
            reason = f"is damaged: the fields of step {step} are in {file_of_step(step)}"
            raise SceneError([Problem(reason, file=str(folder / INDEX))])
    return index


def file_of_step(step: int) -> str:
    """Return the name of the file of the fields of a step."""
    return f"fields_{step:04}.nc"
