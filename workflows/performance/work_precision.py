"""Error of J against run time: cfmpm and scikit-fem on the same grids, in one process."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from scipy.sparse import csr_array
from skfem import solver_direct_scipy

import cfmpm
from cfmpm.grid import Floats
from cfmpm.results import write_dataset
from cfmpm.solvers import SOLVERS, available
from workflows import reference_fem
from workflows.settings import scene_with

PHASES = ("mesh", "solve", "post")
log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Measurement:
    """One program on one grid.

    Attributes
    ----------
    J : float
        [N/mm].
    n_unknowns : int
    seconds : tuple of float
        By `PHASES` [s].
    """

    J: float
    n_unknowns: int
    seconds: tuple[float, float, float]


def measure(
    path: str | Path,
    scene: str | Path,
    *,
    converged: float,
    radius: float,
    repeats: int,
    solvers: Sequence[str],
    series: Mapping[str, Sequence[Mapping[str, Any]]],
) -> None:
    """Measure all grids with all solvers.

    Parameters
    ----------
    path : Path
        Of the netCDF file; dimensions run, phase.
    scene : str
        Scene file.
    converged : float
        J from which the error is counted [N/mm].
    radius : float
        Outer radius of the ring of J [mm].
    repeats : int
    solvers : sequence of str
        What is not installed is left out.
    series : mapping
        Lists of grids, by name.
    """
    solvers = [name for name in solvers if available(name)]
    rows: list[dict[str, Any]] = []
    attributes: dict[str, Any] = {}
    for name, meshes in series.items():
        for solver in solvers:  # loads libraries and touches memory
            cfmpm.run(scene_with(scene, meshes[0], [radius], solver=solver))
        for mesh in meshes:
            grid_seconds = []
            for solver in solvers:
                scenario = scene_with(scene, mesh, [radius], solver=solver)
                runs = []
                for _ in range(repeats):
                    result = cfmpm.run(scenario)
                    runs.append(_of_history(result.history))
                fastest = _fastest(runs)
                grid_seconds.append(fastest.seconds[0])
                rows.append(
                    {"series": name, "program": "cfmpm", "solver": solver, **asdict(fastest)}
                )
            attributes = attributes or result.history.attrs
            for solver, solve in _fem_solvers().items():
                runs = [_run_fem(result, radius, solve, min(grid_seconds)) for _ in range(repeats)]
                fastest = _fastest(runs)
                rows.append(
                    {"series": name, "program": "scikit-fem", "solver": solver, **asdict(fastest)}
                )
            log.info("%s %s: J = %.7f", name, mesh, rows[-1]["J"])
    J = np.array([row["J"] for row in rows])
    dataset = xr.Dataset(
        {
            "J": ("run", J, {"units": "N mm-1", "long_name": "J in a ring"}),
            "error": ("run", np.abs(J / converged - 1.0), {"units": "1", "long_name": "of J"}),
            "n_unknowns": ("run", [row["n_unknowns"] for row in rows], {"units": "1"}),
            "seconds": (
                ("run", "phase"),
                [row["seconds"] for row in rows],
                {"units": "s", "long_name": "wall time, the least of several warm runs"},
            ),
        },
        {
            **{key: ("run", [row[key] for row in rows]) for key in ("series", "program", "solver")},
            "phase": list(PHASES),
        },
        {key: attributes[key] for key in ("Conventions", "source", "references", "versions")},
    )
    dataset.attrs |= {"title": "Error of J against run time", "converged": converged}
    write_dataset(dataset, Path(path))


def _fastest(runs: Sequence[Measurement]) -> Measurement:
    """The least time of each phase: the others were disturbed."""
    mesh, solve, post = np.min([run.seconds for run in runs], axis=0)
    return replace(runs[0], seconds=(float(mesh), float(solve), float(post)))


def _of_history(history: xr.Dataset) -> Measurement:
    step = history.isel(step=0, tip=0)
    seconds = step.wall_time
    mesh, post = float(seconds.sel(phase="grid")), float(seconds.sel(phase="fracture"))
    solve = float(seconds.sum()) - mesh - post
    return Measurement(float(step.J), int(step.n_unknowns), (mesh, solve, post))


def _fem_solvers() -> dict[str, Callable[[Any, Floats], Floats]]:
    """scikit-fem's own choice, and the fastest solver of cfmpm for a fair comparison."""
    found: dict[str, Callable[[Any, Floats], Floats]] = {"its default": solver_direct_scipy()}
    if available("cholmod"):
        found["cholmod"] = lambda K, b: SOLVERS["cholmod"].factor(csr_array(K)).solve(b).x
    return found


def _run_fem(
    result: cfmpm.Result,
    radius: float,
    solve: Callable[[Any, Floats], Floats],
    grid_seconds: float,
) -> Measurement:
    """One run of scikit-fem on the grid of a result, which it takes over as it is."""
    grid, scene = result.grid, result.scene
    tip = grid.nodes[grid.tips[0].node]
    plate = reference_fem.plate_of(scene, grid)
    start = time.perf_counter()
    system = reference_fem.assemble(plate, degree=grid.elements.shape[1] // 3)
    solution = reference_fem.solve(system, solve)
    solved = time.perf_counter()
    J = reference_fem.j_integral(solution, tip, radius)
    done = time.perf_counter()
    n = len(solution.displacement) - len(system.held)
    return Measurement(J, n, (grid_seconds, solved - start, done - solved))
