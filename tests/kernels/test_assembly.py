"""Stiffness and forces of linear elasticity for any elastic matrix."""

from __future__ import annotations

import numpy as np
import pytest
import round_off
from scipy.sparse import csr_array
from structured import rectangle

from cfmpm.body.grid import build_grid
from cfmpm.body.points import seed
from cfmpm.kernels import assembly, constitutive


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_stiffness_is_the_derivative_of_the_forces(element):
    """Two materials without any symmetry: K u is the internal force, u K u twice the energy."""
    rng = np.random.default_rng(4)
    root = rng.uniform(-1, 1, (2, 3, 3))
    elastic = np.einsum("qij,qkj->qik", root, root)
    grid = build_grid(rectangle(4, 3, 4.0, 3.0, shake=0.4, seed=1), element)
    points = seed(grid)
    material = points.element % 2
    gradients = grid.basis_gradients(points.element, points.position)
    n = len(grid.nodes)
    u = rng.uniform(-1, 1, (n, 2))
    H, stress, energy = constitutive.linear_elastic(
        grid.elements, points.element, gradients, material, elastic, u
    )
    strain = np.stack([H[:, 0, 0], H[:, 1, 1], H[:, 0, 1] + H[:, 1, 0]], axis=1)
    expected = np.einsum("pij,pj->pi", elastic[material], strain)
    np.testing.assert_allclose(stress, expected, atol=8 * round_off.EPS * abs(expected).max())
    free = np.arange(2 * n).reshape(-1, 2)
    indptr, indices = assembly.sparsity(grid.elements, free)
    data = assembly.stiffness(
        grid.elements, free, indptr, indices, points.element, gradients, points.volume, material,
        elastic,
    )  # fmt: skip
    K = csr_array((data, indices, indptr)).toarray()
    np.testing.assert_array_equal(K, K.T)
    force = assembly.internal_force(
        grid.elements, n, points.element, gradients, points.volume, stress
    )
    # Of sums of some twenty terms.
    near = 32 * round_off.EPS * (abs(K) @ abs(u.ravel())).max()
    np.testing.assert_allclose((K @ u.ravel()).reshape(-1, 2), force, rtol=0, atol=near)
    stored = np.sum(energy * points.volume)
    np.testing.assert_allclose(0.5 * np.sum(force * u), stored, rtol=64 * round_off.EPS)
