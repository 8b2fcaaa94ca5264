"""Dense systems, solved with the same bits on any number of threads; LAPACK's are threaded."""

from __future__ import annotations

import math

import numpy as np

from cfmpm._jit import kernel


@kernel
def cholesky_solve(matrix, b):
    """Solve a symmetric positive definite system by its factor U^T U.

    Parameters
    ----------
    matrix : (n, n) float
        Only the entries on and right of the diagonal are read.
    b : (n,) float

    Returns
    -------
    (n,) float
        nan where a pivot is not positive.
    """
    n = len(b)
    u = matrix.copy()
    x = b.copy()
    for i in range(n):
        for j in range(i):
            factor = u[j, i]
            for k in range(i, n):
                u[i, k] -= factor * u[j, k]
        # Below round-off of what was taken from it a pivot is noise.
        if not u[i, i] > 1e-15 * matrix[i, i]:
            return np.full(n, np.nan)
        pivot = math.sqrt(u[i, i])
        for k in range(i, n):
            u[i, k] /= pivot
        x[i] /= pivot
        for k in range(i + 1, n):
            x[k] -= u[i, k] * x[i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            x[i] -= u[i, k] * x[k]
        x[i] /= u[i, i]
    return x
