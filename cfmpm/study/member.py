"""What one member of a study leaves, and how it is found."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from cfmpm.errors import MeshError, SceneError, SolveError
from cfmpm.scene import Scene
from cfmpm.study.layout import DIMENSIONS
from cfmpm.study.measuring import Measure, Quantity, measured

if TYPE_CHECKING:
    import xarray as xr

    from cfmpm.output.record import Record
    from cfmpm.state import Result, State

TEXTS = ("ending", "warnings", "solver")


@dataclass(frozen=True)
class Job:
    """What is done for one member.

    Attributes
    ----------
    key : str
        Of the member.
    scene : Scene
    repeats : int
        Runs, of which the fastest counts for the times.
    measure : Measure or None
        Of further quantities, from the last run.
    """

    key: str
    scene: Scene
    repeats: int = 1
    measure: Measure | None = None


@dataclass(frozen=True)
class Outcome:
    """What one member leaves.

    Attributes
    ----------
    key : str
        Of the member.
    status : str
        One of `layout.STATUS`.
    reason : str
        Why it is not done; else empty.
    seconds, cpu_seconds : float
        Wall time and time of the processor [s].
    lasting : bool
        False where the machine or the program failed and not the scene: another time it may go
        well.
    texts : mapping of str to str
        By the names of `TEXTS`.
    labels : mapping of str to list
        Names of tips and boundaries, nominal radii [mm], and what a measure labels.
    quantities : mapping of str to (dimensions, array, attributes)
        Of the history, and what is measured besides; of a failed member the history of the steps
        before its end.
    """

    key: str
    status: str = "done"
    reason: str = ""
    seconds: float = 0.0
    cpu_seconds: float = 0.0
    lasting: bool = True
    texts: Mapping[str, str] = field(default_factory=dict)
    labels: Mapping[str, list[Any]] = field(default_factory=dict)
    quantities: Mapping[str, Quantity] = field(default_factory=dict)


def solve(job: Job) -> Outcome:
    """Solve one member; whatever goes wrong becomes the reason of its failure.

    Parameters
    ----------
    job : Job
    """
    from cfmpm.ending import LOST, Ending

    clock = _Clock()
    records: list[Record] = []
    further: Mapping[str, Quantity] = {}
    labels: Mapping[str, list[Any]] = {}
    status, reason, lasting = "failed", "", True
    try:
        result = _run(job, clock, records)
        history = result.history
        if job.measure is not None:
            further, labels = measured(job.measure, result)
    except (SceneError, MeshError, SolveError) as error:
        reason = str(error)
    except MemoryError:
        reason, lasting = "not enough memory; take a larger mesh.size, or solver: amg", False
    except Exception as error:  # no member that shows up a fault is the end of a study
        reason, lasting = f"{type(error).__name__}: {error}", False
    else:
        if history.attrs["run_status"] in LOST:
            status, reason = "unstable", str(history.attrs["ending"])
        else:
            status = "done"
    if status == "failed":
        if not records:
            return Outcome(job.key, status, reason, *clock.least(), lasting=lasting)
        history = records[0].history(Ending("failed", f"failed: {reason}"))
    seconds, cpu_seconds = clock.least()
    return Outcome(
        key=job.key,
        status=status,
        reason=reason,
        seconds=seconds,
        cpu_seconds=cpu_seconds,
        lasting=lasting,
        texts={name: str(history.attrs[name]) for name in TEXTS},
        labels={name: history[name].values.tolist() for name in ("tip", "boundary", "radius")}
        | dict(labels),
        quantities=_quantities(history) | dict(further),
    )


class _Clock:
    """Wall time and processor time of runs, each from `start` to the next or to the end."""

    def __init__(self) -> None:
        self._runs: list[tuple[float, float]] = []
        self.start()

    def start(self) -> None:
        self._begin = time.perf_counter(), time.process_time()

    def stop(self) -> None:
        wall, cpu = self._begin
        self._runs.append((time.perf_counter() - wall, time.process_time() - cpu))

    def least(self) -> tuple[float, float]:
        """Of each the least of all runs that came to their ends; else of the one that did not."""
        if not self._runs:
            self.stop()
        wall, cpu = zip(*self._runs, strict=True)
        return min(wall), min(cpu)


def _run(job: Job, clock: _Clock, records: list[Record]) -> Result:
    """Run the scene as often as asked; the last result, and in `records` the steps so far."""
    from cfmpm import simulation

    def observe(state: State, record: Record) -> None:
        records[:] = [record]

    for _ in range(job.repeats):
        clock.start()
        result = simulation.run(job.scene, observe=observe)
        clock.stop()
    return result


def _quantities(history: xr.Dataset) -> dict[str, Quantity]:
    """All of a history that is no text and no time."""
    names = [name for name in history.variables if name not in history.dims]
    return {
        str(name): (
            tuple(map(str, history.variables[name].dims)),
            np.asarray(history.variables[name].values),
            history.variables[name].attrs,
        )
        for name in names
        if set(history.variables[name].dims) <= set(DIMENSIONS)
    }
