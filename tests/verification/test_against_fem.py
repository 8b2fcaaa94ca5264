"""On the first step the method is linear FEM: scikit-fem on the same grid agrees."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse.linalg import splu

import cfmpm
from cfmpm.scene.reading import scene_from_dict

skfem = pytest.importorskip("skfem")
from skfem.models.elasticity import lame_parameters, linear_elasticity  # noqa: E402

E, NU = 210e3, 0.3


def edge_cracked_plate(element, loads=None, **more):
    scene = {
        "name": "plate",
        "family": {"kind": "single_edge", "width": 500, "height": 1000, "crack_length": 100},
        "material": {"E": E, "nu": NU},
        "mesh": {"element": element, "size": 60, "grading": {"tip_size": 4, "growth": 0.3}},
        **more,
    }
    if loads is None:
        scene["family"]["traction"] = 10.0
    else:
        scene["loads"] = loads
    return cfmpm.run(scene_from_dict(scene))


def independent_solution(grid, fixed, values, force):
    """Solve by scikit-fem on the nodes of the grid; displacement (n, 2) and strain energy."""
    order = grid.elements.shape[1] // 3
    mesh = skfem.MeshTri(grid.nodes[: grid.n_corners].T, grid.triangles.T, sort_t=False)
    element = skfem.ElementVector(skfem.ElementTriP1() if order == 1 else skfem.ElementTriP2())
    basis = skfem.Basis(mesh, element, intorder=2 * (order - 1))
    stiffness = skfem.asm(linear_elasticity(*lame_parameters(E, NU)), basis)
    # Match the degrees of freedom by element, for crack faces share their coordinates.
    dofs = np.empty((len(grid.nodes), 2), int)
    local = basis.element_dofs
    for k in range(3):
        dofs[grid.elements[:, k]] = local[2 * k : 2 * k + 2].T
    if order == 2:
        # scikit-fem numbers middles by facet: sides 01, 12 and 02 of each triangle.
        for k in range(3):
            dofs[grid.elements[:, 3 + k]] = local[6 + 2 * k : 8 + 2 * k].T
    place = basis.doflocs[:, dofs[:, 0]].T
    np.testing.assert_allclose(place, grid.nodes, atol=1e-9)
    f, u = np.zeros(stiffness.shape[0]), np.zeros(stiffness.shape[0])
    f[dofs] = force
    u[dofs[fixed]] = values[fixed]
    free = np.ones(len(u), bool)
    free[dofs[fixed]] = False
    matrix = stiffness.tocsr()
    u[free] = splu(matrix[free][:, free].tocsc()).solve((f - matrix @ u)[free])
    return u[dofs], 0.5 * u @ (matrix @ u)


@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize(
    "loads",
    [
        None,
        [
            {"edge": "bottom", "displacement": {"x": 0, "y": 0}},
            {"edge": "top", "displacement": {"x": 0.3, "y": 0.5}},
        ],
    ],
    ids=["traction", "displacement"],
)
def test_same_grid_same_answer(element, loads):
    result = edge_cracked_plate(element, loads)
    grid = result.grid
    from cfmpm.loading import apply_loads
    from cfmpm.points import seed

    loading = apply_loads(result.scene, grid, seed(grid))
    u, energy = independent_solution(grid, loading.prescribed, loading.displacement, loading.force)
    scale = np.abs(u).max()
    np.testing.assert_allclose(result.displacement, u, rtol=0, atol=1e-12 * scale)
    assert float(result.history.strain_energy[0]) == pytest.approx(energy, rel=1e-12)
