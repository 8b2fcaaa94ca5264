"""Writing of the results of a run, during the run and at its end."""

from __future__ import annotations

import copy
import time
from contextlib import ExitStack
from pathlib import Path

from cfmpm.ending import Ending
from cfmpm.mechanics import load_levels
from cfmpm.output import run_folder as folders
from cfmpm.output.checkpoint import Start, write_checkpoint
from cfmpm.output.fields import build_fields
from cfmpm.output.fields_by_step import FieldsByStep, read_index
from cfmpm.output.files import store, written_aside
from cfmpm.output.record import Record
from cfmpm.output.run_folder import CHECKPOINT, FIELDS, HISTORY, INDEX, UNFINISHED
from cfmpm.scene import Scene, config_hash
from cfmpm.state import Result, State

# Largest part of the run time for writing history and checkpoint.
SHARE = 0.05


class RunWriter:
    """Writes the files of a run: fields by step, the history so far, and a checkpoint.

    A run with several steps writes history and checkpoint after its first step, and then whenever
    this takes at most `SHARE` of the time since the last write.

    Parameters
    ----------
    folder : Path
        A locked folder (`run_folder.held`). Results of an earlier run are removed when the first
        new file is complete.
    start : Start or None
        Start of a resumed run in the same folder.
    """

    def __init__(self, folder: Path, start: Start | None = None) -> None:
        self._folder = Path(folder)
        self._record: Record | None = None
        self._start = start
        self._done = 0 if start is None else len(start.record.steps)
        self._new, self._taken = start is None, False
        self._fields: FieldsByStep | None = None
        self._due = 0.0
        folders.require_places(self._folder)
        folders.remove_leavings(self._folder)
        if start is not None and (self._folder / INDEX).exists():
            read_index(self._folder)  # a damaged one is told before anything is solved

    @property
    def steps(self) -> int:
        """Number of steps so far."""
        return 0 if self._record is None else len(self._record.steps)

    def observe(self, state: State, record: Record) -> None:
        """Take a state of equilibrium; an observer of `simulation.run`."""
        # A resumed run solves this stage again, since a checkpoint does not contain the full state.
        before = copy.copy(record)
        before.steps = record.steps[:-1]
        self._start, self._record = Start(state.stage, before), record
        scene = record.scene
        several = scene.growth is not None or len(load_levels(scene)) > 1
        if (several or scene.output.every is not None) and time.monotonic() >= self._due:
            self.write("the run was still in progress")
        if scene.output.every is not None:
            if self._fields is None:
                self._fields = FieldsByStep(self._folder, scene.output.every, self._done)
            self._fields.observe(state, record)

    def write(self, reason: str) -> None:
        """Write history and checkpoint so far, if any, with the reason why they are incomplete."""
        if self._record is None or self._start is None:
            return
        begin = time.monotonic()
        history = self._record.history(Ending(UNFINISHED, f"{UNFINISHED}: {reason}"))
        # Both are whole before anything of an earlier run goes; the checkpoint is renamed first.
        with (
            written_aside(self._folder / HISTORY) as aside,
            written_aside(self._folder / CHECKPOINT) as checkpoint,
        ):
            store(history, aside)
            write_checkpoint(self._start, checkpoint)
            self._take_over(self._record.scene)
        end = time.monotonic()
        self._due = end + (end - begin) * (1.0 / SHARE - 1.0)

    def finish(self, result: Result) -> list[Path]:
        """Write the result of a run that has ended, and remove its checkpoint.

        Parameters
        ----------
        result : Result

        Returns
        -------
        list of Path
            All files of the run; for the fields by step only their index.
        """
        datasets = {HISTORY: result.history}
        if result.scene.output.fields:
            datasets[FIELDS] = build_fields(result)
        with ExitStack() as stack:
            # The history is renamed last: while its status is unfinished, the run can be resumed.
            for name, dataset in datasets.items():
                store(dataset, stack.enter_context(written_aside(self._folder / name)))
            self._take_over(result.scene)
            if self._fields is not None:
                self._fields.finish()
        (self._folder / CHECKPOINT).unlink(missing_ok=True)
        by_step = [INDEX] if self._fields is not None else []
        return [self._folder / name for name in (*datasets, *by_step)]

    def _take_over(self, scene: Scene) -> None:
        """Remove, once, the results of an earlier run, or what shows the run before it went on."""
        if not self._taken:
            clear = folders.clear if self._new else folders.clear_shown
            clear(self._folder, folders.description(config_hash(scene)))
            self._taken = True


def write_result(result: Result, folder: Path, *, overwrite: bool) -> list[Path]:
    """Write a result as the run of a folder; see :meth:`cfmpm.Result.write`."""
    with folders.held(folder), folders.starting(folder, overwrite=overwrite):
        return RunWriter(folder).finish(result)
