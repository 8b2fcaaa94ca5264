"""The members of a study on disk: few files for many members, each written once and atomically.

A part is an .npz file: the numbers of each member in one row, all else as JSON text. Members are
found by their keys, independent of the study or run that wrote them.
"""

from __future__ import annotations

import json
import logging
import math
import secrets
import time
from collections.abc import Collection, Iterable, Set
from pathlib import Path
from typing import Any

import numpy as np

from cfmpm.output.arrays import opened_arrays
from cfmpm.output.files import remove_asides, written_aside
from cfmpm.study.member import Outcome

# Names in the folder of a study.
DATASET, MEMBERS = "study.nc", "members"
# Seconds between two writes, as for the history of a run.
INTERVAL = 5.0
# Number of parts of one owner at which they are merged.
MOST_PARTS = 50
# Version of the file layout; parts with another one are not read.
FORMAT = 3
# Errors on reading a file that is not a part, or is damaged.
_DAMAGE = (ValueError, LookupError, TypeError, AttributeError, RecursionError, MemoryError)
# Fields of an outcome that are written as they are.
_PLAIN = ("status", "reason", "seconds", "cpu_seconds", "lasting", "texts", "labels")

log = logging.getLogger(__name__)


class Store:
    """Outcomes by their keys, in the parts of one folder.

    Parameters
    ----------
    folder : Path
        Folder of the members; it is made when the first part is written.
    owner : str, optional
        Prefix of the names of its parts. Only one process at a time writes as this owner; parts of
        other owners are read and never changed.
    """

    def __init__(self, folder: Path, owner: str = "part") -> None:
        self._folder = Path(folder)
        self._owner = owner
        self._waiting: list[Outcome] = []
        self._due = time.monotonic() + INTERVAL

    def read(self, keys: Collection[str]) -> dict[str, Outcome]:
        """The lasting outcomes of the requested members, by any owner."""
        wanted, found = set(keys), dict[str, Outcome]()
        for path in sorted(self._folder.glob("*.npz")):
            found |= {one.key: one for one in read_sound(path, wanted) if one.lasting}
        return found

    def add(self, outcome: Outcome) -> None:
        """Keep an outcome; it is on disk within `INTERVAL` seconds, if others follow."""
        if outcome.lasting:
            self._waiting.append(outcome)
        if time.monotonic() >= self._due:
            self.flush()

    def flush(self) -> None:
        """Write outcomes that are not yet on disk."""
        if self._waiting:
            write_part(self._waiting, self._new())
            self._waiting = []
        if len(self.parts()) >= MOST_PARTS:
            self._gather()
        self._due = time.monotonic() + INTERVAL

    def gather(self) -> None:
        """Write outcomes that are not yet on disk, and merge all parts."""
        self.flush()
        self._gather()

    def tidy(self) -> None:
        """Remove temporary files of a killed process, and merge its parts."""
        remove_asides(self._folder, f"{self._owner}.*")
        self._gather()

    def parts(self) -> list[Path]:
        """The files of this owner."""
        return sorted(self._folder.glob(f"{self._owner}.*.npz"))

    def _gather(self) -> None:
        """Merge all parts that can be read; a file is only removed if its members are merged."""
        found: dict[str, Outcome] = {}
        held: dict[Path, set[str]] = {}
        for path in self.parts():
            part = {one.key: one for one in read_sound(path)}
            if part:
                held[path] = set(part)
                found |= part
        if len(held) < 2:
            return
        whole = self._new()
        write_part(found.values(), whole)
        kept = {one.key for one in read_part(whole)}
        for path, keys in held.items():
            if keys <= kept:
                path.unlink(missing_ok=True)

    def _new(self) -> Path:
        return self._folder / f"{self._owner}.{secrets.token_hex(8)}.npz"


def write_part(outcomes: Iterable[Outcome], path: Path, losses: int = 0) -> None:
    """Write outcomes to one file, atomically.

    Parameters
    ----------
    outcomes : iterable of Outcome
    path : Path
        An .npz file with arrays, and all else as JSON text; no pickle.
    losses : int, optional
        To be read by `read_losses`.
    """
    layouts: dict[str, int] = {}
    members: dict[str, Any] = {}
    rows: dict[str, np.ndarray] = {}
    for one in outcomes:
        sizes: dict[str, int] = {}
        layout = []
        for name, (dims, values, attributes) in one.quantities.items():
            layout.append([name, dims, values.dtype.str, _plain(attributes)])
            sizes |= dict(zip(dims, values.shape, strict=True))
        members[one.key] = {
            **{name: getattr(one, name) for name in _PLAIN},
            "sizes": sizes,
            "layout": layouts.setdefault(json.dumps(layout), len(layouts)),
        }
        flat = [values.ravel().astype(float) for _, values, _ in one.quantities.values()]
        rows[one.key] = np.concatenate(flat) if flat else np.empty(0)
    text = {
        "format": FORMAT,
        "losses": losses,
        "layouts": [json.loads(layout) for layout in layouts],
        "members": members,
    }
    with written_aside(path) as aside, aside.open("wb") as file:
        np.savez(file, allow_pickle=False, text=_coded(text), **rows)


def read_part(path: Path, keys: Set[str] | None = None) -> list[Outcome]:
    """Read the outcomes of a part, all or by key.

    Parameters
    ----------
    path : Path
        A part of another format has none.
    keys : set of str, optional
        Default: all.

    Raises
    ------
    OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError, MemoryError
        If it cannot be read, or is not a part.
    """
    with opened_arrays(path) as file:
        wanted = [name for name in file.names if name != "text" and (keys is None or name in keys)]
        if not wanted:
            return []
        text = json.loads(file["text"].tobytes())
        if text["format"] != FORMAT:
            return []
        return [_outcome(key, text, file[key]) for key in wanted]


def read_sound(path: Path, keys: Set[str] | None = None) -> list[Outcome]:
    """Read a part as `read_part` does; a missing or damaged one has no outcomes."""
    try:
        return read_part(path, keys)
    except FileNotFoundError:  # made into one with others meanwhile
        return []
    except _DAMAGE:
        log.warning("%s is damaged: its members are solved again", path)
        return []


def read_losses(path: Path) -> int:
    """Read the number of jobs that lost members of a part because of the machine; 0 without one.

    Parameters
    ----------
    path : Path
    """
    try:
        with opened_arrays(path) as file:
            return int(json.loads(file["text"].tobytes()).get("losses", 0))
    except (FileNotFoundError, *_DAMAGE):
        return 0


def _outcome(key: str, text: dict[str, Any], row: np.ndarray) -> Outcome:
    member = text["members"][key]
    quantities, begin = {}, 0
    for name, dims, dtype, attributes in text["layouts"][member["layout"]]:
        shape = tuple(member["sizes"][dim] for dim in dims)
        end = begin + math.prod(shape)
        values = row[begin:end].reshape(shape).astype(dtype)
        quantities[name] = (tuple(dims), values, attributes)
        begin = end
    return Outcome(key=key, quantities=quantities, **{name: member[name] for name in _PLAIN})


def _coded(text: dict[str, Any]) -> np.ndarray:
    """JSON as bytes; an array of characters would take four bytes for each."""
    return np.frombuffer(json.dumps(text).encode(), np.uint8)


def _plain(attributes: dict[str, Any]) -> dict[str, Any]:
    """Attributes for JSON; arrays of flags become lists."""
    return {
        name: value.tolist() if isinstance(value, np.ndarray) else value
        for name, value in attributes.items()
    }
