"""The solve of one member of a study, and its outcome."""

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
    """The task for one member.

    Attributes
    ----------
    key : str
        Key of the member.
    scene : Scene
    repeats : int
        Number of runs; times are those of the fastest.
    measure : Measure or None
        Function for further quantities, from the last run.
    """

    key: str
    scene: Scene
    repeats: int = 1
    measure: Measure | None = None


@dataclass(frozen=True)
class Outcome:
    """The outcome of one member.

    Attributes
    ----------
    key : str
        Key of the member.
    status : str
        One of `layout.STATUS`.
    reason : str
        Why it is not done; else empty.
    seconds, cpu_seconds : float
        Wall time and processor time [s].
    lasting : bool
        False if the failure is due to the machine or the program and not to the scene, so that
        another attempt may succeed.
    texts : mapping of str to str
        By the names of `TEXTS`.
    labels : mapping of str to list
        Names of tips and boundaries, nominal radii [mm], and labels of a measure.
    quantities : mapping of str to (dimensions, array, attributes)
        Those of the history and of a measure; for a failed member the history before its failure.
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
    """Solve one member; any error becomes the reason of its failure.

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
        reason, lasting = "not enough memory; use a larger mesh.size, or solver: amg", False
    except Exception as error:  # an error of one member must not end the study
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
        """The smallest times of all completed runs; without one those of the failed run."""
        if not self._runs:
            self.stop()
        wall, cpu = zip(*self._runs, strict=True)
        return min(wall), min(cpu)


def _run(job: Job, clock: _Clock, records: list[Record]) -> Result:
    """Run the scene `repeats` times; return the last result, with the steps so far in `records`."""
    from cfmpm import simulation

    def observe(state: State, record: Record) -> None:
        records[:] = [record]

    for _ in range(job.repeats):
        clock.start()
        result = simulation.run(job.scene, observe=observe)
        clock.stop()
    return result


def _quantities(history: xr.Dataset) -> dict[str, Quantity]:
    """The variables of a history other than text and times."""
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
