"""Conjugate gradients never return a solution of an indefinite matrix."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_array, diags_array

from cfmpm.linear.amg import _conjugate_gradients
from cfmpm.linear.engine import NotPositiveDefiniteError


def solve(diagonal, precondition, tolerance=1e-12):
    K = csr_array(diags_array(np.asarray(diagonal, float)))
    b = np.ones(K.shape[0])
    return _conjugate_gradients(K, b, precondition, tolerance)


def test_a_definite_matrix_is_solved_in_as_many_iterations_as_it_has_eigenvalues():
    x, history = solve([1.0, 2.0, 2.0, 5.0], np.copy)
    np.testing.assert_allclose(x, [1.0, 0.5, 0.5, 0.2], rtol=1e-12)
    assert len(history) == 4


def test_negative_curvature_ends_them():
    """The preconditioner does not see it, and the residual converges to zero nevertheless."""
    with pytest.raises(NotPositiveDefiniteError, match=r"curvature of -1.0e\+00"):
        solve([1.0, 1.0, -3.0], np.copy)
    # Seen only in a later direction.
    with pytest.raises(NotPositiveDefiniteError, match="iteration 2"):
        solve([1.0, 1.0, -0.5], np.copy)


def test_a_preconditioner_that_is_not_definite_ends_them():
    """As for an indefinite matrix, but with positive curvature in all directions."""
    with pytest.raises(NotPositiveDefiniteError, match=r"preconditioned residual of -3.0e\+00"):
        solve([1.0, 1.0, 1.0], np.negative)
    with pytest.raises(NotPositiveDefiniteError, match=r"preconditioned residual of 0.0e\+00"):
        solve([1.0, 2.0, 3.0], lambda r: r * [1.0, -1.0, 0.0])
