"""Keeping on disk what a run has found while it goes on."""

from __future__ import annotations

import copy
import time
from pathlib import Path

from cfmpm.checkpoint import write_checkpoint
from cfmpm.fracture.growth import Decision
from cfmpm.record import Record
from cfmpm.results import write_dataset
from cfmpm.simulation import Start, State

# Seconds between two writes: a write takes some hundredths of one.
INTERVAL = 5.0
HISTORY, CHECKPOINT = "history.nc", "checkpoint.npz"
# How the ending of a history begins that is not whole.
UNFINISHED = "unfinished"


class Keeper:
    """Writes the history so far, and what is needed to go on, every few seconds.

    Parameters
    ----------
    folder : Path
        A checkpoint of an earlier run is taken away, unless it is gone on from.
    start : Start or None
        Where the run goes on.
    """

    def __init__(self, folder: Path, start: Start | None = None) -> None:
        self._folder = Path(folder)
        self._record: Record | None = None
        self._start = start
        self._decision: Decision | None = None if start is None else start.decision
        self._due = time.monotonic() + INTERVAL
        if start is None:
            (self._folder / CHECKPOINT).unlink(missing_ok=True)

    @property
    def steps(self) -> int:
        """How many steps are known."""
        return 0 if self._record is None else len(self._record.steps)

    def observe(self, state: State, record: Record) -> None:
        """Take note of a state of balance; an observer of `simulation.run`."""
        # The next run solves this body again: a state of balance has more to it than is kept.
        before = copy.copy(record)
        before.steps = record.steps[:-1]
        self._start = Start(state.solved, before, self._decision, state.level, state.before)
        self._record, self._decision = record, state.decision
        if time.monotonic() >= self._due:
            self.write("the run was still going on")
            self._due = time.monotonic() + INTERVAL

    def write(self, reason: str) -> None:
        """Write what there is, if there is anything, with the reason why it is not more."""
        if self._record is not None and self._start is not None:
            write_checkpoint(self._start, self._folder / CHECKPOINT)
            history = self._record.history(f"{UNFINISHED}: {reason}")
            write_dataset(history, self._folder / HISTORY)

    def finish(self) -> None:
        """Take the checkpoint away: nothing is left to be done."""
        (self._folder / CHECKPOINT).unlink(missing_ok=True)
