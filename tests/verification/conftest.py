from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from posed import balanced, driven, pose

from cfmpm.body.grid import Grid, build_grid
from cfmpm.body.materials import Materials
from cfmpm.body.points import DeformedPoints
from cfmpm.build import materials_of
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.fracture import cf
from cfmpm.meshing import triangulate
from cfmpm.scene import expand
from cfmpm.scene.reading import scene_from_dict


@dataclass
class Solved:
    """A solved grid and the data for its evaluation."""

    grid: Grid
    points: DeformedPoints
    gradients: np.ndarray
    materials: Materials
    nodal: np.ndarray
    balance: Equilibrium


@pytest.fixture(scope="session")
def solve_prescribed():
    """Solve a scene's body under a displacement field on its whole outer boundary.

    The field is called as field(x, side): coordinates (k, 2), and the centroid (k, 2) of the
    triangle on whose side of a crack each place lies.
    """

    def solve(body: dict, field) -> Solved:
        scene = expand(scene_from_dict({"name": "prescribed", **body}))
        grid = build_grid(triangulate(scene), scene.mesh.element)
        materials = materials_of(scene, grid.region_names)
        outer = np.unique(np.concatenate([edges.ravel() for edges in grid.edges.values()]))
        side = np.empty_like(grid.nodes)
        side[grid.elements] = grid.nodes[grid.triangles].mean(axis=1)[:, None]
        loading = driven(grid, outer, field(grid.nodes[outer], side[outer]))
        problem = pose(grid, loading, materials)
        found = balanced(problem)
        nodal = cf.nodal_force(grid, found.points, problem.gradients, np.zeros(2))
        return Solved(grid, found.points, problem.gradients, materials, nodal, found)

    return solve
