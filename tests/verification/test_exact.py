"""Exact solutions: patch test, rigid motion, symmetry, equilibrium."""

from __future__ import annotations

import numpy as np
import pytest
import round_off
from hypothesis import given, settings
from hypothesis import strategies as st
from posed import driven, elastic, pose, unloaded
from structured import rectangle

from cfmpm.body.grid import build_grid
from cfmpm.body.points import seed
from cfmpm.equilibrium import small_strain
from cfmpm.fracture import cf

LAM, MU = 1.3, 0.9
MATERIALS = elastic(LAM, MU)


def solve_with_boundary_displacement(grid, field, materials=MATERIALS):
    """Prescribe the displacement of the outer boundary, (n, 2), and solve for the inside."""
    boundary = np.unique(np.concatenate([e.ravel() for e in grid.edges.values()]))
    problem = pose(grid, driven(grid, boundary, field[boundary]), materials)
    stiffness = small_strain.assemble_stiffness(problem)
    balance = small_strain.solve_linear(problem, stiffness)
    return balance.points, problem.gradients, balance, stiffness


def check_solution(grid, exact):
    """Solve for a linear field from its boundary; also return the round-off of its stress."""
    points, gradients, balance, stiffness = solve_with_boundary_displacement(grid, exact)
    error = round_off.of_solution(stiffness, exact)
    np.testing.assert_allclose(balance.displacement, exact, rtol=0, atol=error)
    body = round_off.LinearBody(grid, points, gradients, exact, LAM + 2.0 * MU)
    return points, gradients, body.of_stress


@pytest.mark.parametrize("element", ["T3", "T6"])
@settings(max_examples=25)
@given(shake=st.floats(0, 0.45), seed_=st.integers(0, 999))
def test_patch_test_on_any_grid(element, shake, seed_):
    """A linear displacement and its uniform stress are reproduced on any distorted grid."""
    grid = build_grid(rectangle(6, 5, 2.0, 1.0, shake=shake, seed=seed_), element)
    h = np.array([[0.3, -0.2], [0.5, 0.1]])
    exact = grid.nodes @ h.T + 0.7
    points, gradients, error = check_solution(grid, exact)
    lam, mu = LAM, MU
    strain = 0.5 * (h + h.T)
    stress = lam * np.trace(strain) * np.eye(2) + 2 * mu * strain
    expected = [stress[0, 0], stress[1, 1], stress[0, 1]]
    expected = np.tile(expected, (len(points), 1))
    np.testing.assert_allclose(points.stress, expected, rtol=0, atol=error)
    energy = 0.5 * (stress * strain).sum()
    # Its derivative by the stress is a strain, below one.
    np.testing.assert_allclose(points.energy, energy, rtol=0, atol=error)
    # A uniform state drives no node inside.
    nodal = cf.nodal_force(grid, points, gradients, np.zeros(2))
    inner = np.setdiff1d(
        np.arange(len(nodal)), np.concatenate([e.ravel() for e in grid.edges.values()])
    )
    # Over triangles below one in size.
    assert np.abs(nodal[inner]).max() < error


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_quadratic_displacement_is_exact_for_t6_with_body_force(element):
    """T6 contains quadratic fields, and integrates their body force exactly."""
    grid = build_grid(rectangle(4, 4, shake=0.5, seed=3), element)
    problem = pose(grid, unloaded(grid), MATERIALS)
    lam, mu = LAM, MU
    # u = (x^2, 0): div sigma = (2 (lam + 2 mu), 0).
    exact = np.column_stack([grid.nodes[:, 0] ** 2, np.zeros(len(grid.nodes))])
    points = small_strain.deform(problem, exact)
    force = small_strain.internal_force(problem, points)
    from cfmpm.kernels import assembly

    density = np.array([-2 * (lam + 2 * mu), 0.0])
    values = grid.basis_values(points.element, points.position)
    body = assembly.body_force(
        grid.elements, len(grid.nodes), points.element, values, points.volume, density
    )
    inner = np.setdiff1d(
        np.arange(len(body)), np.concatenate([e.ravel() for e in grid.edges.values()])
    )
    error = np.abs((force - body)[inner]).max()
    if element == "T6":
        # A force is the sum of up to eight triangles' stress times size, both below four.
        assert error < round_off.of_sum(np.full(8, 16.0))
    else:
        assert error > 1e-3


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_small_rigid_motion_leaves_a_cracked_body_free_of_stress(element):
    grid = build_grid(rectangle(6, 6, shake=0.3, crack=(3, 0, 3)), element)
    spin = np.array([[0.0, -0.4], [0.4, 0.0]])
    points, gradients, error = check_solution(grid, grid.nodes @ spin.T - 3)
    assert np.abs(points.stress).max() < error
    # Stress times a displacement gradient below one, over triangles below one in size.
    assert np.abs(cf.nodal_force(grid, points, gradients, np.zeros(2))).max() < error


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_configurational_forces_of_a_body_add_up_to_its_boundary(element):
    """The gradients of the basis functions sum to zero, and so do the nodal forces."""
    grid = build_grid(rectangle(6, 6, shake=0.3, crack=(3, 0, 3)), element)
    x, y = grid.nodes.T
    points, gradients, *_ = solve_with_boundary_displacement(
        grid, np.column_stack([0 * x, y**2 + x * y])
    )
    nodal = cf.nodal_force(grid, points, gradients, np.zeros(2))
    assert (np.abs(nodal.sum(axis=0)) < round_off.of_sum(nodal, axis=0)).all()


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_basis_is_a_partition_of_unity_with_the_right_gradients(element):
    grid = build_grid(rectangle(3, 3, shake=0.4), element)
    points = seed(grid)
    values = grid.basis_values(points.element, points.position)
    gradients = grid.basis_gradients(points.element, points.position)
    # Local coordinates come from differences of positions, all below one, over a triangle.
    error = round_off.ROUNDINGS * round_off.EPS / np.sqrt(grid.areas.min())
    np.testing.assert_allclose(values.sum(axis=1), 1.0, rtol=0, atol=error)
    assert (np.abs(gradients.sum(axis=1)) < round_off.of_sum(gradients, axis=1)).all()
    np.testing.assert_allclose(
        np.einsum("pk,pki->pi", values, grid.nodes[grid.elements[points.element]]),
        points.position,
        rtol=0,
        atol=error,
    )
    step = 1e-6
    for axis in range(2):
        shifted = points.position.copy()
        shifted[:, axis] += step
        ahead = grid.basis_values(points.element, shifted)
        np.testing.assert_allclose((ahead - values) / step, gradients[:, :, axis], atol=2e-4)
