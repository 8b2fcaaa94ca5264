"""What one member of a study leaves, and how it is found."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cfmpm.errors import MeshError, SceneError, SolveError
from cfmpm.scene import Scene
from cfmpm.study.layout import DIMENSIONS

if TYPE_CHECKING:
    import xarray as xr

    from cfmpm.output.record import Record
    from cfmpm.state import State

TEXTS = ("ending", "warnings", "solver")

Quantity = tuple[tuple[str, ...], NDArray[Any], dict[str, Any]]  # dimensions, values, attributes


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
    seconds : float
        Wall time [s].
    lasting : bool
        False where the machine or the program failed and not the scene: another time it may go
        well.
    texts : mapping of str to str
        By the names of `TEXTS`.
    labels : mapping of str to list
        Names of tips and boundaries, nominal radii [mm].
    quantities : mapping of str to (dimensions, array, attributes)
        Of the history; of a failed member of the steps before its end.
    """

    key: str
    status: str = "done"
    reason: str = ""
    seconds: float = 0.0
    lasting: bool = True
    texts: Mapping[str, str] = field(default_factory=dict)
    labels: Mapping[str, list[Any]] = field(default_factory=dict)
    quantities: Mapping[str, Quantity] = field(default_factory=dict)


def solve(key: str, scene: Scene) -> Outcome:
    """Solve one member; whatever goes wrong becomes the reason of its failure.

    Parameters
    ----------
    key : str
        Of the member.
    scene : Scene
    """
    from cfmpm import simulation
    from cfmpm.ending import LOST, Ending

    begin = time.perf_counter()
    records: list[Record] = []

    def observe(state: State, record: Record) -> None:
        records[:] = [record]

    status, reason, lasting = "failed", "", True
    try:
        history = simulation.run(scene, observe=observe).history
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
            return Outcome(key, status, reason, time.perf_counter() - begin, lasting)
        history = records[0].history(Ending("failed", f"failed: {reason}"))
    return Outcome(
        key=key,
        status=status,
        reason=reason,
        seconds=time.perf_counter() - begin,
        lasting=lasting,
        texts={name: str(history.attrs[name]) for name in TEXTS},
        labels={name: history[name].values.tolist() for name in ("tip", "boundary", "radius")},
        quantities=_quantities(history),
    )


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
