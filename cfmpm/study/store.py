"""The members of a study on disk: few files for many members, each written once and whole.

A part is an .npz file: the numbers of each member in one row, all else as JSON text. Members are
found in it by their keys, whichever study or run has put them there.
"""

from __future__ import annotations

import hashlib
import json
import math
import time
from collections.abc import Collection, Iterable, Set
from contextlib import suppress
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from cfmpm.results import written_aside
from cfmpm.study.member import Outcome

# In the folder of a study.
DATASET, MEMBERS = "study.nc", "members"
# Seconds between two writes, as for the history of a run.
INTERVAL = 5.0
# As many parts of one run are made into one.
MOST_PARTS = 50
# Of the layout of a part; parts of another one are not read.
FORMAT = 1


class Store:
    """Outcomes by their keys, in the parts of one folder.

    Parameters
    ----------
    folder : Path
        Of the members; it is made when the first part is written.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = Path(folder)
        self._waiting: list[Outcome] = []
        self._own: list[Path] = []
        self._due = time.monotonic() + INTERVAL

    def read(self, keys: Collection[str]) -> dict[str, Outcome]:
        """The outcomes that are there of the members asked for."""
        wanted, found = set(keys), dict[str, Outcome]()
        for path in sorted(self._folder.glob("*.npz")):
            with suppress(FileNotFoundError):  # made into one with others meanwhile
                found |= {one.key: one for one in read_part(path, wanted)}
        return found

    def add(self, outcome: Outcome) -> None:
        """Keep an outcome; it is on disk within `INTERVAL` seconds, if others follow."""
        if outcome.lasting:
            self._waiting.append(outcome)
        if time.monotonic() >= self._due:
            self.flush()

    def flush(self) -> None:
        """Write what is not yet on disk."""
        if self._waiting:
            self._own.append(self._write(self._waiting))
            self._waiting = []
        if len(self._own) >= MOST_PARTS:
            self.gather()
        self._due = time.monotonic() + INTERVAL

    def gather(self) -> None:
        """Write what is not yet on disk, and make one part of all that this store has written."""
        if self._waiting:
            self._own.append(self._write(self._waiting))
            self._waiting = []
        if len(self._own) > 1:
            whole = self._write(one for path in self._own for one in read_part(path))
            for path in self._own:
                path.unlink(missing_ok=True)
            self._own = [whole]

    def discard(self) -> None:
        """Take away what this store has written: it is somewhere else."""
        for path in self._own:
            path.unlink(missing_ok=True)
        self._own = []

    def _write(self, outcomes: Iterable[Outcome]) -> Path:
        outcomes = list(outcomes)
        name = hashlib.sha256(" ".join(one.key for one in outcomes).encode()).hexdigest()[:16]
        path = self._folder / f"part_{name}.npz"
        write_part(outcomes, path)
        return path


def write_part(outcomes: Iterable[Outcome], path: Path) -> None:
    """Write outcomes into one file, aside, and rename it.

    Parameters
    ----------
    outcomes : iterable of Outcome
    path : Path
        An .npz file: arrays as they are, all else as JSON text; no pickle.
    """
    meanings: dict[str, Any] = {}
    layouts: dict[tuple[str, ...], int] = {}
    members: dict[str, Any] = {}
    rows: dict[str, np.ndarray] = {}
    for one in outcomes:
        sizes: dict[str, int] = {}
        for name, (dims, values, attributes) in one.quantities.items():
            meanings.setdefault(name, [dims, values.dtype.str, _plain(attributes)])
            sizes |= dict(zip(dims, values.shape, strict=True))
        members[one.key] = {
            "reason": one.reason,
            "seconds": one.seconds,
            "texts": dict(one.texts),
            "labels": dict(one.labels),
            "sizes": sizes,
            "layout": layouts.setdefault(tuple(one.quantities), len(layouts)),
        }
        flat = [values.ravel().astype(float) for _, values, _ in one.quantities.values()]
        rows[one.key] = np.concatenate(flat) if flat else np.empty(0)
    text = {
        "format": FORMAT,
        "quantities": meanings,
        "layouts": list(layouts),
        "members": members,
    }
    with written_aside(path) as aside, aside.open("wb") as file:
        np.savez(file, allow_pickle=False, text=np.array(json.dumps(text)), **rows)


def read_part(path: Path, keys: Set[str] | None = None) -> list[Outcome]:
    """Read the outcomes that a part holds, or those of some keys.

    Parameters
    ----------
    path : Path
        What is no part of this format holds none.
    keys : set of str, optional
        Default: all.
    """
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
            wanted = [name for name in file.files if keys is None or name in keys]
            if not wanted:
                return []
            text = json.loads(str(file["text"]))
            if text["format"] != FORMAT:
                return []
            wanted = [key for key in wanted if key != "text"]
            return [_outcome(key, text, file[key]) for key in wanted]
    except FileNotFoundError:
        raise
    except (BadZipFile, EOFError, OSError, ValueError, KeyError):
        return []


def _outcome(key: str, text: dict[str, Any], row: np.ndarray) -> Outcome:
    member = text["members"][key]
    quantities, begin = {}, 0
    for name in text["layouts"][member["layout"]]:
        dims, dtype, attributes = text["quantities"][name]
        shape = tuple(member["sizes"][dim] for dim in dims)
        end = begin + math.prod(shape)
        values = row[begin:end].reshape(shape).astype(dtype)
        quantities[name] = (tuple(dims), values, attributes)
        begin = end
    return Outcome(
        key=key,
        reason=member["reason"],
        seconds=member["seconds"],
        texts=member["texts"],
        labels=member["labels"],
        quantities=quantities,
    )


def _plain(attributes: dict[str, Any]) -> dict[str, Any]:
    """Attributes as JSON takes them; arrays of flags become lists."""
    return {
        name: value.tolist() if isinstance(value, np.ndarray) else value
        for name, value in attributes.items()
    }
