"""Hencky elasticity: W = lambda/2 (tr eps)^2 + mu eps : eps with eps = ln(b) / 2 (paper eq 2).

The tangent is that of paper eqs 11 and 12, misprints corrected. The law loses ellipticity at
stretches of 2 to 3.
"""

from __future__ import annotations

import math

from cfmpm._jit import kernel
from cfmpm.kernels.laws.tensors import principal, turned


@kernel
def volumetric(lam, y):
    """Return lambda U, lambda U' and lambda U'' of U = (ln J)^2 / 2 [MPa]."""
    J = 1.0 + y
    log_J = math.log1p(y)
    return 0.5 * lam * log_J * log_J, lam * log_J / J, lam * (1.0 - log_J) / (J * J)


@kernel
def response(mu, H, y):
    """Return Kirchhoff stress, energy and tangent of W_mu = mu eps : eps [MPa]."""
    hxx, hxy, hyx, hyy = H
    J = 1.0 + y
    log_J = math.log1p(y)
    # b - I = H + H^T + H H^T
    _, _, x, log_x, cos2, sin2 = principal(
        2.0 * hxx + hxx * hxx + hxy * hxy,
        2.0 * hyy + hyx * hyx + hyy * hyy,
        hxy + hyx + hxx * hyx + hxy * hyy,
        J * J,
    )
    common = mu * log_J  # (beta_1 + beta_2) / 2
    difference = 0.5 * mu * log_x  # (beta_1 - beta_2) / 2
    energy = mu * (0.5 * log_J * log_J + 0.125 * log_x * log_x)
    ratio = mu * (log_x / x if x > 0.0 else 1.0)  # s b_2
    beta_1, beta_2 = common + difference, common - difference
    c = turned(2.0 * (mu - beta_1), 2.0 * (mu - beta_2), 0.0, ratio - beta_2, cos2, sin2)
    return (common + difference * cos2, common - difference * cos2, difference * sin2), energy, c
