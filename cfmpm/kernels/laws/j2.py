"""Hencky elasticity with von Mises yield stress and linear isotropic hardening.

The trial state is b_e = F Cp^-1 F^T. The return mapping is radial in its logarithmic strain eps,
with the exponential map for plastic flow: the plastic multiplier dg solves
q - 3 mu dg = yield stress + hardening (alpha + dg) with the trial von Mises stress q (Simo 1992;
de Souza Neto, Peric and Owen 2008, section 14.4 and box 7.3). The sum of stored energy and plastic
work is a potential of the stress (Ortiz and Stainier 1999).
"""

from __future__ import annotations

import math

from cfmpm._jit import kernel
from cfmpm.kernels.laws.hencky import volumetric
from cfmpm.kernels.laws.tensors import principal, turned

__all__ = ["INTERNAL_VARIABLES", "across", "response", "volumetric"]

# Components of Cp^-1 - I; accumulated plastic strain alpha; plastic work per reference volume
# [N mm/mm^3].
INTERNAL_VARIABLES = ("cp_xx", "cp_yy", "cp_xy", "cp_zz", "plastic_strain", "plastic_work")


@kernel
def across(mu, y, tau):
    """Return tau_zz of W_mu [MPa], from tr tau = 2 mu ln J: plastic flow preserves volume."""
    return 2.0 * mu * math.log1p(y) - tau[0] - tau[1]


@kernel
def trial(H, y, internal, p):
    """Return b_e of the trial state.

    Parameters
    ----------
    H, y, internal, p
        As in `response`.

    Returns
    -------
    exx, eyy, exy : float
        In-plane components of b_e - I.
    area, log_area : float
        Determinant of the in-plane part of b_e, and half its logarithm.
    eps_zz : float
        Out-of-plane logarithmic strain.
    """
    hxx, hxy, hyx, hyy = H
    fxx, fyy = 1.0 + hxx, 1.0 + hyy
    J = 1.0 + y
    gxx, gyy, gxy = internal[p, 0], internal[p, 1], internal[p, 2]
    # b_e - I = H + H^T + H H^T + F (Cp^-1 - I) F^T
    exx = 2.0 * hxx + hxx * hxx + hxy * hxy
    eyy = 2.0 * hyy + hyx * hyx + hyy * hyy
    exy = hxy + hyx + hxx * hyx + hxy * hyy
    exx += fxx * fxx * gxx + 2.0 * fxx * hxy * gxy + hxy * hxy * gyy
    eyy += hyx * hyx * gxx + 2.0 * hyx * fyy * gxy + fyy * fyy * gyy
    exy += fxx * hyx * gxx + (fxx * fyy + hxy * hyx) * gxy + hxy * fyy * gyy
    growth = gxx + gyy + (gxx * gyy - gxy * gxy)
    area = J * J * (1.0 + growth)
    log_area = math.log1p(y) + 0.5 * math.log1p(growth)
    return exx, eyy, exy, area, log_area, 0.5 * math.log1p(internal[p, 3])


@kernel
def flowed(H, y, internal, p, change, dg, work):
    """Return the internal variables after plastic flow.

    Parameters
    ----------
    H, y, internal, p
        As in `response`.
    change : tuple of four floats
        b_e less b_e of the trial state xx, yy, xy, and the relative change of Cp^-1 zz.
    dg : float
        Increment of the accumulated plastic strain.
    work : float
        Increment of the plastic work [N mm/mm^3].

    Returns
    -------
    tuple of six floats
        In the order of `INTERNAL_VARIABLES`.
    """
    hxx, hxy, hyx, hyy = H
    fxx, fyy = 1.0 + hxx, 1.0 + hyy
    bxx, byy, bxy, zz = change
    JJ = (1.0 + y) * (1.0 + y)
    # Cp^-1 changes by F^-1 (b_e - b_e trial) F^-T.
    return (
        internal[p, 0] + (fyy * fyy * bxx - 2.0 * fyy * hxy * bxy + hxy * hxy * byy) / JJ,
        internal[p, 1] + (hyx * hyx * bxx - 2.0 * hyx * fxx * bxy + fxx * fxx * byy) / JJ,
        internal[p, 2] + ((fxx * fyy + hxy * hyx) * bxy - fyy * hyx * bxx - hxy * fxx * byy) / JJ,
        internal[p, 3] + (1.0 + internal[p, 3]) * zz,
        internal[p, 4] + dg,
        internal[p, 5] + work,
    )


@kernel
def response(mu, yield_stress, hardening, H, y, internal, p):
    """Return Kirchhoff stress, energy and tangent of W_mu, and the new internal variables.

    W_mu = mu eps : eps of the elastic logarithmic strain.

    Parameters
    ----------
    mu, yield_stress, hardening : float
        [MPa].
    H : tuple of four floats
        xx, xy, yx, yy of F - I.
    y : float
        J - 1.
    internal : (n, h) float
        Internal variables of all points at the start of the step.
    p : int
        Row of the point.

    Returns
    -------
    tau, energy, c
        As in `dispatch.respond`, without the volumetric part.
    state : tuple of six floats
        In the order of `INTERNAL_VARIABLES`.
    """
    exx, eyy, exy, area, log_area, eps_zz = trial(H, y, internal, p)
    b1, b2, x, log_x, cos2, sin2 = principal(exx, eyy, exy, area)
    common = mu * log_area  # (beta_1 + beta_2) / 2
    difference = 0.5 * mu * log_x  # (beta_1 - beta_2) / 2
    energy = mu * (0.5 * log_area * log_area + 0.125 * log_x * log_x + eps_zz * eps_zz)
    ratio = mu * (log_x / x if x > 0.0 else 1.0)  # s b_2
    a11 = a22 = 2.0 * mu  # d beta_i / d eps_j
    a12 = 0.0
    alpha = internal[p, 4]
    state = (internal[p, 0], internal[p, 1], internal[p, 2], internal[p, 3], alpha, internal[p, 5])
    mean = (log_area + eps_zz) / 3.0
    d1 = 0.5 * log_area + 0.25 * log_x - mean
    d2 = 0.5 * log_area - 0.25 * log_x - mean
    d3 = eps_zz - mean
    square = d1 * d1 + d2 * d2 + d3 * d3
    q = 2.0 * mu * math.sqrt(1.5 * square)
    excess = q - yield_stress - hardening * alpha
    if excess > 0.0:
        dg = excess / (3.0 * mu + hardening)
        lost = 3.0 * mu * dg / q
        kept = 1.0 - lost
        common = mu * (2.0 * mean + kept * (d1 + d2))
        difference *= kept
        ratio *= kept
        energy = mu * (3.0 * mean * mean + kept * kept * square)
        # Consistent tangent 2 mu kept I_d + 6 mu^2 (dg / q - 1 / (3 mu + H)) N N.
        along = 6.0 * mu * mu * (dg / q - 1.0 / (3.0 * mu + hardening)) / square
        both = 2.0 / 3.0 * mu * lost
        a11 = 2.0 * mu * kept + both + along * d1 * d1
        a22 = 2.0 * mu * kept + both + along * d2 * d2
        a12 = both + along * d1 * d2
        db1 = b1 * math.expm1(-2.0 * lost * d1)
        db2 = b2 * math.expm1(-2.0 * lost * d2)
        bm, bd = 0.5 * (db1 + db2), 0.5 * (db1 - db2)
        change = (bm + bd * cos2, bm - bd * cos2, bd * sin2, math.expm1(-2.0 * lost * d3))
        work = dg * (yield_stress + hardening * (alpha + 0.5 * dg))
        state = flowed(H, y, internal, p, change, dg, work)
    beta_1, beta_2 = common + difference, common - difference
    c = turned(a11 - 2.0 * beta_1, a22 - 2.0 * beta_2, a12, ratio - beta_2, cos2, sin2)
    tau = (common + difference * cos2, common - difference * cos2, difference * sin2)
    return tau, energy, c, state
