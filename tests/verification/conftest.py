from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from cfmpm.body.grid import Grid, build_grid
from cfmpm.body.loads import Loading
from cfmpm.body.materials import Materials
from cfmpm.body.points import MaterialPoints, seed
from cfmpm.build import materials_of
from cfmpm.equilibrium import balance, small_strain
from cfmpm.fracture import cf
from cfmpm.meshing import triangulate
from cfmpm.scene import expand
from cfmpm.scene.reading import scene_from_dict


@dataclass
class Solved:
    """A solved grid and what its evaluation needs."""

    grid: Grid
    points: MaterialPoints
    gradients: np.ndarray
    materials: Materials
    nodal: np.ndarray
    balance: balance.Equilibrium


@pytest.fixture(scope="session")
def solve_prescribed():
    """Solve a scene's body under a displacement field on its whole outer boundary.

    The field is called as field(x, side): coordinates (k, 2), and the centroid (k, 2) of the
    triangle on whose side of a crack each place lies.
    """

    def solve(body: dict, field) -> Solved:
        scene = expand(scene_from_dict({"name": "prescribed", **body}))
        grid = build_grid(triangulate(scene), scene.mesh.element)
        points = seed(grid)
        gradients = grid.basis_gradients(points.element, points.position)
        materials = materials_of(scene, grid.region_names)
        outer = np.unique(np.concatenate([edges.ravel() for edges in grid.edges.values()]))
        prescribed = np.zeros((len(grid.nodes), 2), bool)
        prescribed[outer] = True
        side = np.empty_like(grid.nodes)
        side[grid.elements] = grid.nodes[grid.triangles].mean(axis=1)[:, None]
        values = np.zeros_like(grid.nodes)
        values[outer] = field(grid.nodes[outer], side[outer])
        nothing = np.zeros_like(values)
        loading = Loading(prescribed, values, nothing, nothing, np.zeros(2), {}, 0)
        stiffness = small_strain.assemble_stiffness(grid, points, gradients, materials, loading)
        balance = small_strain.solve_linear(
            stiffness, grid, points, gradients, materials, loading, "superlu"
        )
        nodal = cf.nodal_force(grid, points, gradients, np.zeros(2))
        return Solved(grid, points, gradients, materials, nodal, balance)

    return solve
