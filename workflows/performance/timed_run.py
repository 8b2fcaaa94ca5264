"""Times of the phases of a run, and of scikit-fem on its grid, as measures of studies."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr
from scipy.sparse import csr_array
from skfem import solver_direct_scipy

from cfmpm.body.grid import Floats
from cfmpm.linear.solvers import available, select
from cfmpm.state import Result
from workflows.reference import plate_fem

PHASES = ("mesh", "solve", "post")
# Runs of scikit-fem, of which the fastest counts.
REPEATS = 2


def phases(result: Result) -> xr.Dataset:
    """Wall time by `PHASES`, of all steps together."""
    of_phase = result.history.wall_time.sum("step")
    mesh, post = float(of_phase.sel(phase="grid")), float(of_phase.sel(phase="fracture"))
    seconds = [mesh, float(of_phase.sum()) - mesh - post, post]
    return xr.Dataset({"seconds": ("part", seconds)}, {"part": list(PHASES)})


def phases_and_fem(result: Result) -> xr.Dataset:
    """The same, and that of scikit-fem on the same grid by each of its solvers: times and values.

    scikit-fem uses the same grid; the time of meshing is common to both.
    """
    own = phases(result)
    found = [_by_fem(result, solve) for solve in fem_solvers().values()]
    fem = xr.concat(found, xr.Variable("fem_solver", list(fem_solvers())))
    mesh = own.seconds.sel(part="mesh", drop=True)
    fem["fem_cpu"] = fem.fem_cpu + mesh
    fem["fem_seconds"] = fem.fem_seconds + mesh * (own.part == "mesh")
    return own.merge(fem)


def fem_solvers() -> dict[str, Callable[[Any, Floats], Floats]]:
    """scikit-fem's own choice, and the fastest solver of cfmpm for a fair comparison."""
    found: dict[str, Callable[[Any, Floats], Floats]] = {"its default": solver_direct_scipy()}
    if available("cholmod"):
        found["cholmod"] = lambda K, b: select(len(b), "cholmod").factor(csr_array(K)).solve(b).x
    return found


def _by_fem(result: Result, solve: Callable[[Any, Floats], Floats]) -> xr.Dataset:
    """Run scikit-fem on the grid of a result."""
    grid = result.grid
    tip = grid.nodes[grid.tips[0].node]
    radius = float(result.history.domain_radius[0, 0, -1])
    plate = plate_fem.plate_of(result.scene, grid)
    cpu, runs = [], []
    for _ in range(REPEATS):
        begun, start = time.process_time(), time.perf_counter()
        system = plate_fem.assemble(plate, degree=grid.element.order)
        solution = plate_fem.solve(system, solve)
        solved = time.perf_counter()
        J = plate_fem.j_integral(solution, tip, radius)
        K_I, K_II = plate_fem.intensity_factors(solution, tip, radius)
        runs.append([0.0, solved - start, time.perf_counter() - solved])
        cpu.append(time.process_time() - begun)
    return xr.Dataset(
        {
            "fem_cpu": min(cpu),
            "fem_seconds": ("part", np.min(runs, axis=0)),
            "fem_n_unknowns": len(solution.displacement) - len(system.held),
            "fem_G": plate.release_rate(K_I, K_II),
            "fem_J": J,
            "fem_K_I": K_I,
            "fem_K_II": K_II,
        }
    )
