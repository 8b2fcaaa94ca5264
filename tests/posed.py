"""Boundary value problems on given grids."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from cfmpm import build, mechanics
from cfmpm.body.grid import Floats, Grid
from cfmpm.body.loads import Loading, NodalLoads
from cfmpm.body.materials import Materials, material_table
from cfmpm.body.points import MaterialPoints, seed
from cfmpm.equilibrium import small_strain
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.equilibrium.problem import BoundaryValueProblem
from cfmpm.scene import Scene


def elastic(lam: float, mu: float) -> Materials:
    """One linear elastic region with given Lame constants."""
    E, nu = mu * (3.0 * lam + 2.0 * mu) / (lam + mu), 0.5 * lam / (lam + mu)
    return material_table([{"E": E, "nu": nu}], "strain")


def pose(
    grid: Grid,
    loading: Loading,
    materials: Materials,
    points: MaterialPoints | None = None,
    **options: Any,
) -> BoundaryValueProblem:
    """The boundary value problem of a body, on new or given points."""
    points = seed(grid) if points is None else points
    gradients = grid.basis_gradients(points.element, points.position)
    options = {"solver": "superlu", **options}
    return BoundaryValueProblem(grid, points, gradients, materials, loading, **options)


def of_scene(scene: Scene) -> BoundaryValueProblem:
    """The problem of a scene at finite deformation, with given loads."""
    problem = mechanics.problem_of(*mechanics.locate(build.build(scene)))
    return replace(problem, solver="superlu")


def unloaded(grid: Grid, prescribed: Any = False) -> Loading:
    """No loads, and some components of displacement prescribed as zero."""
    shape = grid.nodes.shape
    return Loading(np.zeros(shape, bool) | prescribed, NodalLoads.none(len(grid.nodes)), {})


def driven(grid: Grid, nodes: Any, values: Floats) -> Loading:
    """No loads, and displacements of some nodes prescribed, (k, 2)."""
    prescribed = np.zeros(grid.nodes.shape, bool)
    displacement = np.zeros_like(grid.nodes)
    prescribed[nodes], displacement[nodes] = True, values
    nothing = NodalLoads.none(len(grid.nodes))
    return Loading(prescribed, replace(nothing, displacement=displacement), {})


def balanced(problem: BoundaryValueProblem) -> Equilibrium:
    """Solve a problem at small strain."""
    return small_strain.solve_linear(problem, small_strain.assemble_stiffness(problem))
