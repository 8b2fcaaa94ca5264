from __future__ import annotations

import numpy as np
import pytest

from cfmpm.kernels.dense import cholesky_solve


@pytest.mark.parametrize("n", [0, 1, 2, 7, 40])
def test_solves_a_definite_system_from_its_upper_half(n):
    rng = np.random.default_rng(n)
    root = rng.standard_normal((n, 2 * n + 1))
    matrix, x = root @ root.T, rng.standard_normal(n)
    half = np.triu(matrix) + np.tril(np.full((n, n), np.nan), -1)
    before = half.copy()
    np.testing.assert_allclose(cholesky_solve(half, matrix @ x), x, atol=1e-12)
    np.testing.assert_array_equal(half, before)


@pytest.mark.parametrize("matrix", [[[1.0, 2.0], [2.0, 1.0]], [[1.0, 1.0], [1.0, 1.0]], [[-1.0]]])
def test_a_pivot_that_is_not_positive_is_told(matrix):
    matrix = np.array(matrix)
    assert np.isnan(cholesky_solve(matrix, np.ones(len(matrix)))).all()
