"""Neo-Hookean elasticity: W = mu/2 (tr b - 2 - 2 ln J) + lambda/2 (ln J)^2.

Source: Simo and Pister 1984. The energy is not polyconvex in general: (ln J)^2 is not convex in J.
"""

from __future__ import annotations

from cfmpm._jit import kernel
from cfmpm.kernels.laws.hencky import volumetric
from cfmpm.kernels.laws.tensors import log_defect

__all__ = ["response", "volumetric"]


@kernel
def response(mu, H, y):
    """Return Kirchhoff stress, energy and tangent of W_mu = mu/2 (tr b - 2 - 2 ln J) [MPa].

    The stress is mu (b - I); the tangent is constant, that of Hooke's law with lambda = 0.
    """
    hxx, hxy, hyx, hyy = H
    # b - I = H + H^T + H H^T
    tau = (
        mu * (2.0 * hxx + hxx * hxx + hxy * hxy),
        mu * (2.0 * hyy + hyx * hyx + hyy * hyy),
        mu * (hxy + hyx + hxx * hyx + hxy * hyy),
    )
    # Written without the terms of first order, which cancel.
    energy = 0.5 * mu * ((hxx - hyy) ** 2 + (hxy + hyx) ** 2 + 2.0 * log_defect(y))
    return tau, energy, (2.0 * mu, 2.0 * mu, 0.0, 0.0, 0.0, mu)
