"""Keeping the history of a run on disk while the run goes on."""

from __future__ import annotations

import time
from pathlib import Path

from cfmpm.record import Record
from cfmpm.results import write_dataset
from cfmpm.simulation import State

# Seconds between two writes: a write takes some hundredths of one.
INTERVAL = 5.0


class Keeper:
    """Writes the history so far every few seconds.

    Parameters
    ----------
    path : Path
        Where to; written aside and renamed.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._record: Record | None = None
        self._due = time.monotonic() + INTERVAL

    def observe(self, state: State, record: Record) -> None:
        """Take note of a state of balance; an observer of `simulation.run`."""
        self._record = record
        if time.monotonic() >= self._due:
            self.write("unfinished: the run was still going on")
            self._due = time.monotonic() + INTERVAL

    def write(self, ending: str) -> None:
        """Write what there is, if there is anything, with the reason why it is not more."""
        if self._record is not None:
            write_dataset(self._record.history(ending), self._path)
