"""Time the linear solvers on an edge-cracked plate (500 mm x 1000 mm, upper half by symmetry).

    python workflows/benchmarks/solvers.py results/benchmarks/solvers.nc 1e4 1e5 --order 1

The mesh is graded towards the tip. Every solver runs in a process of its own. Times are CPU
seconds; memory is by how much the solver raised the peak of its process.
"""

from __future__ import annotations

import argparse
import resource
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import gmsh
import numpy as np
import skfem
import xarray as xr
from numpy.typing import NDArray
from scipy.sparse import csr_array
from skfem.models.elasticity import lame_parameters, linear_elasticity

from cfmpm import solvers

WIDTH, HEIGHT, CRACK = 500.0, 500.0, 100.0  # mm
UNITS = {"unknowns": "1", "setup": "s", "refactor": "s", "solve": "s", "residual": "1"}
UNITS["memory"] = "MB"


def mesh(size: float) -> skfem.MeshTri:
    """Triangles of edge length `size` [mm] far away and 1/20 of it at the tip."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    for source in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
        gmsh.option.setNumber(f"Mesh.MeshSize{source}", 0)
    geo, field = gmsh.model.geo, gmsh.model.mesh.field
    outline = [(0, 0), (CRACK, 0), (WIDTH, 0), (WIDTH, HEIGHT), (0, HEIGHT)]
    points = [geo.addPoint(x, y, 0) for x, y in outline]
    lines = [geo.addLine(a, b) for a, b in zip(points, points[1:] + points[:1], strict=True)]
    geo.addPlaneSurface([geo.addCurveLoop(lines)])
    geo.synchronize()
    graded = f"min({size}, {size / 20} + 0.15 * sqrt((x - {CRACK})^2 + y^2))"
    field.setString(field.add("MathEval", 1), "F", graded)
    field.setAsBackgroundMesh(1)
    gmsh.model.mesh.generate(2)
    tags, x, _ = gmsh.model.mesh.getNodes()
    triangles = gmsh.model.mesh.getElementsByType(2)[1].reshape(-1, 3)
    gmsh.finalize()
    order = np.argsort(tags)
    nodes = np.ascontiguousarray(x.reshape(-1, 3)[order, :2].T)
    corners = np.searchsorted(tags[order], triangles).T.astype(np.int64, order="C")
    return skfem.MeshTri(nodes, corners)


def plate(n: float, order: int) -> tuple[csr_array, NDArray[np.float64], NDArray[np.float64]]:
    """Stiffness, load and rigid body modes with about `n` unknowns."""
    element = skfem.ElementTriP1() if order == 1 else skfem.ElementTriP2()
    size = order * 1.2 * np.sqrt(WIDTH * HEIGHT / (n / 2))
    for _ in range(2):  # the first time to learn what the grading costs
        basis = skfem.Basis(mesh(size), skfem.ElementVector(element))
        size *= np.sqrt(basis.N / n)
    K = csr_array(linear_elasticity(*lame_parameters(210e3, 0.3)).assemble(basis))
    x, y = basis.doflocs
    along_y = np.arange(basis.N) % 2 == 1
    free = ~(along_y & (y == 0.0) & (x >= CRACK))
    free[np.flatnonzero(~along_y & (x == WIDTH) & (y == 0.0))] = False
    load = np.where(along_y & (y == HEIGHT), 1.0, 0.0)
    nodes = basis.doflocs[:, ::2].T
    K = csr_array(K[free][:, free])
    return K, load[free], solvers.rigid_body_modes(nodes, free)


def measure(
    name: str, K: csr_array, b: NDArray[np.float64], modes: NDArray[np.float64]
) -> dict[str, float]:
    """Factor, refactor and solve once."""
    solvers.select(1, name).factor(csr_array(np.eye(1)), np.ones((1, 3)))  # imports
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    times = [time.process_time()]
    factor = solvers.select(len(b), name).factor(K, modes)
    times.append(time.process_time())
    factor.refactor(K)
    times.append(time.process_time())
    solution = factor.solve(b)
    times.append(time.process_time())
    memory = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    setup, refactor, solve = np.diff(times)
    return dict(
        zip(UNITS, (len(b), setup, refactor, solve, solution.residual, memory), strict=True)
    )


def main() -> None:
    """Write a dataset with the dimensions solver and size."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("output", type=Path)
    parser.add_argument("sizes", type=float, nargs="+", help="numbers of unknowns, roughly")
    parser.add_argument("--order", type=int, choices=(1, 2), default=2)
    parser.add_argument("--solvers", nargs="+", default=[*solvers.SOLVERS])
    args = parser.parse_args()
    names = [name for name in args.solvers if solvers.available(name)]
    rows = {}
    for n in args.sizes:
        system = plate(n, args.order)
        for name in names:
            with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as alone:
                rows[name, n] = alone.submit(measure, name, *system).result()
    data = xr.Dataset(
        {
            key: (
                ("solver", "size"),
                [[rows[name, n][key] for n in args.sizes] for name in names],
                {"units": unit},
            )
            for key, unit in UNITS.items()
        },
        coords={"solver": names, "size": args.sizes},
        attrs={"title": "Linear solvers on an edge-cracked plate", "order": args.order},
    )
    args.output.parent.mkdir(parents=True, exist_ok=True)
    data.to_netcdf(args.output)


if __name__ == "__main__":
    main()
