"""The fields of a run by step: one file each, since the grid changes, and a table of them."""

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
    """Writes the fields of every so many steps as they come, and keeps none of them.

    Parameters
    ----------
    folder : Path
        The files of an earlier run are taken away.
    every : int or None
        The first step is written, every so many steps on, and the last; None: no step.
    done : int, optional
        Steps of the same run that were solved before it was broken off; their files stay.
    """

    def __init__(self, folder: Path, every: int | None, done: int = 0) -> None:
        self._folder, self._every = Path(folder), every
        self._rows: list[tuple[int, float, float, str]] = []
        self._last: Callable[[], None] | None = None  # writes the last state, if that is due
        if (self._folder / INDEX).exists():
            index = _read_index(self._folder)
            rows = list(zip(*(index[name].values.tolist() for name in _COLUMNS), strict=True))
            self._rows = [row for row in rows if row[0] <= done]
            # First the table: a kill in between leaves none that lists what is not there.
            if self._rows:
                write_dataset(_index(self._rows).assign_attrs(index.attrs), self._folder / INDEX)
            else:
                (self._folder / INDEX).unlink()
            for *_, file in rows[len(self._rows) :]:
                (self._folder / file).unlink(missing_ok=True)

    def observe(self, state: State, record: Record) -> None:
        """Write the fields of a state if it is its turn; an observer of `simulation.run`."""
        if self._every is None:
            return
        step, load_factor = len(record.steps), record.steps[-1].load_factor
        self._last = partial(self._write, state, record.scene, step, load_factor)
        if (step - 1) % self._every == 0:
            self.finish()

    def finish(self) -> None:
        """Write the fields of the last state, if they are not yet."""
        if self._last is not None:
            self._last()
            self._last = None

    def _write(self, state: State, scene: Scene, step: int, load_factor: float) -> None:
        name, attributes = f"fields_{step:04}.nc", provenance(scene)
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
    """Return the files of the fields by step of a run, in their order.

    Parameters
    ----------
    folder : Path

    Raises
    ------
    SceneError
        Where there are none, where they cannot be read, or where they are those of another run than
        the history beside them.
    """
    folder = Path(folder)
    if not (folder / INDEX).exists():
        reason = "no fields by step; a run with output.every makes them"
        raise SceneError([Problem(reason, file=str(folder))])
    index = _read_index(folder)
    require_same_run(folder, index, INDEX)
    files = [folder / str(name) for name in index["file"].values]
    missing = [
        Problem("is listed in the fields by step, and missing", file=str(path))
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
    """Refuse fields of another scene than that of the history in the same folder.

    Parameters
    ----------
    folder : Path
    fields : xarray.Dataset
        Fields, or a table of them.
    name : str
        Of their file.

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


def _read_index(folder: Path) -> xr.Dataset:
    return read_result(folder / INDEX, "file")
