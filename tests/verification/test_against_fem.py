"""On the first step the method is linear FEM: scikit-fem on the same grid agrees."""

from __future__ import annotations

import numpy as np
import pytest
import round_off
from scipy.sparse.linalg import splu

import cfmpm
from cfmpm.scene.reading import scene_from_dict

pytest.importorskip("skfem")
from workflows.reference.plate_fem import Plate, assemble

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


def independent_system(grid, traction):
    """The system of equations by scikit-fem on the same grid, and the unknowns of each node."""
    order = grid.elements.shape[1] // 3
    plate = Plate(
        grid.nodes[: grid.n_corners], grid.triangles, E, NU, (0.0, traction), (0.0, -traction)
    )
    system = assemble(plate, order)
    # Match the degrees of freedom by element, for crack faces share their coordinates.
    dofs = np.empty((len(grid.nodes), 2), int)
    local = system.basis.element_dofs
    for k in range(3):
        dofs[grid.elements[:, k]] = local[2 * k : 2 * k + 2].T
    if order == 2:
        # scikit-fem numbers middles by facet: sides 01, 12 and 02 of each triangle.
        for k in range(3):
            dofs[grid.elements[:, 3 + k]] = local[6 + 2 * k : 8 + 2 * k].T
    place = system.basis.doflocs[:, dofs[:, 0]].T
    np.testing.assert_allclose(place, grid.nodes, rtol=0, atol=1e-11)
    return system, dofs


def independent_solution(system, dofs, fixed, values):
    """Displacement (n, 2) and strain energy."""
    matrix = system.stiffness.tocsr()
    u = np.zeros(matrix.shape[0])
    u[dofs[fixed]] = values[fixed]
    free = np.ones(len(u), bool)
    free[dofs[fixed]] = False
    u[free] = splu(matrix[free][:, free].tocsc()).solve((system.load - matrix @ u)[free])
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
    system, dofs = independent_system(grid, 10.0 if loads is None else 0.0)
    loading = result.loading
    # A force is the traction on two sides, whose lengths are differences of coordinates.
    error = round_off.of_sum(np.full(2, 10.0 * np.abs(grid.nodes).max()))
    np.testing.assert_allclose(loading.proportional.force, system.load[dofs], rtol=0, atol=error)
    u, energy = independent_solution(
        system, dofs, loading.prescribed, loading.proportional.displacement
    )
    free = dofs[~loading.prescribed]
    u = loading.at_rest(u)  # both hold what no support holds, at the same nodes
    error = round_off.of_solution(system.stiffness.tocsr()[free][:, free], u)
    np.testing.assert_allclose(result.displacement, u, rtol=0, atol=error)
    error = round_off.LinearBody.of(result, round_off.stiffest(E, NU)).of_energy
    assert float(result.history.strain_energy[0]) == pytest.approx(energy, rel=0, abs=error)
