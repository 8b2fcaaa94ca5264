"""Plane elastic matrices for tests."""

from __future__ import annotations

import numpy as np


def plane_matrix(lam, mu):
    """Elastic matrices (q, 3, 3), order xx, yy, xy, from Lame constants of q materials [MPa]."""
    lam, mu = np.atleast_1d(lam), np.atleast_1d(mu)
    matrix = mu[:, None, None] * np.diag([2.0, 2.0, 1.0])
    matrix[:, :2, :2] += lam[:, None, None]
    return matrix
