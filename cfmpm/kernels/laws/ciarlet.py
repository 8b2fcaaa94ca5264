"""Ciarlet's neo-Hookean law: W = mu/2 (tr b - 2 - 2 ln J) + lambda/4 (J^2 - 1 - 2 ln J).

Source: Ciarlet 1988, section 4.10. The energy is polyconvex, so that ellipticity is never lost.
"""

from __future__ import annotations

from cfmpm._jit import kernel
from cfmpm.kernels.laws.neo_hookean import response
from cfmpm.kernels.laws.tensors import log_defect

__all__ = ["response", "volumetric"]


@kernel
def volumetric(lam, y):
    """Return lambda U, lambda U' and lambda U'' of U = (J^2 - 1 - 2 ln J) / 4 [MPa]."""
    J = 1.0 + y
    energy = 0.25 * (y * y + 2.0 * log_defect(y))
    return lam * energy, 0.5 * lam * y * (2.0 + y) / J, 0.5 * lam * (1.0 + 1.0 / (J * J))
