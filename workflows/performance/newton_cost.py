"""Cost of an iteration of Newton's method per material point, by its parts."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from scipy.sparse import csr_array

from cfmpm import build, mechanics
from cfmpm.equilibrium import newton, stepping
from cfmpm.equilibrium.problem import BoundaryValueProblem
from cfmpm.linear import solvers
from cfmpm.output.files import write_dataset
from workflows.configuration.scene_with_grid import scene_with

PARTS = ("points and forces", "stiffness", "factor", "solve")
# Parts of an iteration: sums over the points, and the linear solver.
ASSEMBLY = PARTS[:2]
log = logging.getLogger(__name__)


def measure(
    path: str | Path,
    scene: str | Path,
    *,
    solver: str,
    repeats: int,
    replaced: Mapping[str, Any],
    meshes: Sequence[Mapping[str, Any]],
) -> None:
    """Measure grids of the finite deformation scene, warm.

    Parameters
    ----------
    path : Path
        Of the netCDF file; dimensions grid, part.
    scene : str
        Scene file.
    solver : str
    repeats : int
        The fastest counts.
    replaced : mapping
        Values of the scene, by dotted keys.
    meshes : sequence of mapping

    Notes
    -----
    Time is that of the processor, on one thread: other programs do not count. The whole is that of
    `stepping.advance` over its iterations, with all that a step adds to them: analysis of the
    pattern, factors at the beginning and the end, prediction, ellipticity of all points.
    """
    rows = []
    for mesh in meshes:
        problem = _problem(scene_with(scene, mesh, solver=solver, **replaced))
        rows.append(_row(problem, repeats).assign_coords(element=str(mesh["element"])))
        row = rows[-1]
        log.info(
            "%s: %d points, %.3g us a point for assembly, %.3g for an iteration",
            mesh["element"],
            row.n_points,
            row.microseconds.sel(part=list(ASSEMBLY)).sum(),
            row.microseconds.sum(),
        )
    dataset = xr.concat(rows, "grid", combine_attrs="drop_conflicts")
    for name, long_name in {
        "microseconds": "processor time of a part of an iteration per material point",
        "whole": "processor time of a run per Newton iteration and material point",
    }.items():
        dataset[name].attrs = {"units": "1e-6 s", "long_name": long_name}
    write_dataset(dataset, Path(path))


def _problem(scene: Any) -> BoundaryValueProblem:
    """Build the body of a scene, and pose what Newton's method solves."""
    return mechanics.problem_of(*mechanics.locate(build.build(scene)))


def _row(problem: BoundaryValueProblem, repeats: int) -> xr.Dataset:
    """Time the parts at the state of equilibrium, and a whole run to it."""
    balance, whole = None, np.inf
    for _ in range(repeats + 1):  # the first one fills caches
        fresh = replace(problem)  # without what is kept between iterations
        start = time.process_time()
        balance = stepping.advance(fresh, stepping.at_rest(fresh), 1.0)
        whole = min(whole, time.process_time() - start)
    assert balance is not None
    state = balance.displacement, balance.points.internal_variables

    def update() -> newton.Trial:
        points, _ = newton.deform(problem, *state)
        return newton.Trial(state[0], points, newton.internal_force(problem, points), 0.0)

    trial = update()

    def stiffness() -> csr_array:
        return newton.assemble_stiffness(problem, trial, state[1])

    K = stiffness()
    free = ~problem.loading.prescribed
    chosen = solvers.select(K.shape[0], problem.solver)
    factor = chosen.factor(
        K, None if chosen.direct else solvers.rigid_body_modes(problem.grid.nodes, free)
    )
    force = balance.internal_force[free] + 1.0
    jobs: Sequence[Callable[[], object]] = (
        update,
        stiffness,
        lambda: factor.refactor(K),
        lambda: factor.solve(force),
    )
    seconds = [_fastest(job, repeats) for job in jobs]
    n = len(problem.points)
    return xr.Dataset(
        {
            "microseconds": ("part", 1e6 * np.array(seconds) / n),
            "whole": 1e6 * whole / balance.newton_iterations / n,
            "newton_iterations": balance.newton_iterations,
            "n_points": n,
            "n_unknowns": K.shape[0],
            "solver": chosen.name,
        },
        {"part": list(PARTS)},
    )


def _fastest(job: Callable[[], object], repeats: int) -> float:
    """Shortest processor time of a job [s]."""
    seconds = []
    for _ in range(repeats + 1):
        start = time.process_time()
        job()
        seconds.append(time.process_time() - start)
    return min(seconds)
