"""Constitutive laws at finite strain: from displacement gradient to stress and spatial tangent.

Every law is split as W = W_mu(F) + lambda U(J), so that J may be replaced by a mean over a patch.
All start from H = F - I, so that nothing is lost at small strain: no number near 1 is ever
subtracted from another.
"""

from __future__ import annotations

import math

from cfmpm._jit import kernel

HENCKY = 0
NEO_HOOKEAN = 1
CIARLET = 2
J2 = 3


@kernel
def log_defect(y):
    """Return y - ln(1 + y) without cancellation.

    Parameters
    ----------
    y : float
        Above -1.

    Returns
    -------
    float
        y^2/2 - y^3/3 + ...; below |y| = 0.1 by ln(1 + y) = 2 artanh z with z = y / (2 + y), of
        which the first term is taken away in closed form.
    """
    if abs(y) > 0.1:
        return y - math.log1p(y)
    z = y / (2.0 + y)
    zz = z * z
    # Seven terms: the eighth is below 1e-17 of the sum at |y| = 0.1.
    series = 1.0 / 15.0
    for odd in (13.0, 11.0, 9.0, 7.0, 5.0, 3.0):
        series = 1.0 / odd + zz * series
    return y * z - 2.0 * z * zz * series


@kernel
def volumetric(law, lam, y):
    """Return lambda U(J) and its first and second derivative.

    Parameters
    ----------
    law : int
    lam : float
        Lame's first constant [MPa].
    y : float
        J - 1.

    Returns
    -------
    energy, pressure, bulk : float
        lambda U, lambda U' and lambda U'' [MPa]: U = ln(J)^2 / 2, for `CIARLET`
        (J^2 - 1 - 2 ln J) / 4, which is convex in J (Ciarlet 1988, section 4.10).
    """
    J = 1.0 + y
    if law == CIARLET:
        energy = 0.25 * (y * y + 2.0 * log_defect(y))
        return lam * energy, 0.5 * lam * y * (2.0 + y) / J, 0.5 * lam * (1.0 + 1.0 / (J * J))
    log_J = math.log1p(y)
    return 0.5 * lam * log_J * log_J, lam * log_J / J, lam * (1.0 - log_J) / (J * J)


@kernel
def turned(a11, a22, a12, shear, cos2, sin2):
    """Turn a tangent from its principal axes to x, y.

    Parameters
    ----------
    a11, a22, a12, shear : float
        c_1111, c_2222, c_1122 and c_1212 in principal axes.
    cos2, sin2 : float
        Of twice the angle from x to the first axis.

    Returns
    -------
    tuple of six floats
        c_xxxx, c_yyyy, c_xxyy, c_xxxy, c_yyxy, c_xyxy.
    """
    cc, ss, cs = 0.5 * (1.0 + cos2), 0.5 * (1.0 - cos2), 0.5 * sin2
    double = 4.0 * cs * cs * shear
    mixed = cc * ss
    normal = 2.0 * mixed * a12 + double
    return (
        cc * cc * a11 + ss * ss * a22 + normal,
        ss * ss * a11 + cc * cc * a22 + normal,
        mixed * (a11 + a22) + (cc * cc + ss * ss) * a12 - double,
        cs * (cc * a11 - ss * a22 - cos2 * a12 - 2.0 * cos2 * shear),
        cs * (ss * a11 - cc * a22 + cos2 * a12 + 2.0 * cos2 * shear),
        cs * cs * (a11 + a22 - 2.0 * a12) + cos2 * cos2 * shear,
    )


@kernel
def respond(law, lam, mu, yield_stress, hardening, H, mean, patched, history, p):
    """Return stress, energy, tangent and new state of one point.

    Parameters
    ----------
    law : int
        `HENCKY`, `NEO_HOOKEAN`, `CIARLET` or `J2`.
    lam, mu, yield_stress, hardening : float
        [MPa]; the last two for `J2` only.
    H : tuple of four floats
        xx, xy, yx, yy of the displacement gradient F - I; det F > 0.
    mean : float
        Mean of J - 1 over the point's patch; the point's own without patches.
    patched : bool
        Whether the tangent leaves out lambda U'', which then couples the points of a patch.
    history : (p, 6) float
        State at the start of the step; read for `J2` only.
    p : int
        Row of `history`.

    Returns
    -------
    tau : tuple of three floats
        Kirchhoff stress xx, yy, xy [MPa]; tau_mu + lambda U'(mean) J I.
    energy : float
        Stored energy per reference volume [MPa], W_mu + lambda U; with patches U is continued
        linearly from the mean, which adds up to the same over the patch and makes W I - F^T P
        the exact derivative with respect to the reference position.
    c : tuple of six floats
        Spatial tangent xxxx, yyyy, xxyy, xxxy, yyxy, xyxy [MPa] of the Kirchhoff stress, with
        minor symmetries; the stress term delta_ik tau_jl stands apart: c_ijkl + delta_ik tau_jl
        is J a_ijkl of paper eq 11 with misprints put right.
    state : tuple of six floats
        New row of the history, zero but for `J2`.

    Notes
    -----
    In principal axes c_iijj = d beta_i / d eps_j - 2 beta_i delta_ij and
    c_1212 = (beta_1 b_2 - beta_2 b_1) / (b_1 - b_2) = s b_2 - beta_2, with beta the principal
    values of tau and s = (beta_1 - beta_2) / (b_1 - b_2) (de Souza Neto, Peric and Owen 2008,
    section 14.5 and appendix A). s is in closed form for each law.
    """
    hxx, hxy, hyx, hyy = H
    y = hxx + hyy + (hxx * hyy - hxy * hyx)
    J = 1.0 + y
    # b - I = H + H^T + H H^T
    exx = 2.0 * hxx + hxx * hxx + hxy * hxy
    eyy = 2.0 * hyy + hyx * hyx + hyy * hyy
    exy = hxy + hyx + hxx * hyx + hxy * hyy
    state = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if law == HENCKY:
        half = 0.5 * (exx - eyy)
        r = math.hypot(half, exy)
        b2 = J * J / (1.0 + 0.5 * (exx + eyy) + r)
        x = 2.0 * r / b2
        log_x = math.log1p(x)  # ln(b_1 / b_2)
        log_J = math.log1p(y)
        ratio = mu * (log_x / x if x > 0.0 else 1.0)  # s b_2
        beta = mu * log_J
        difference = 0.5 * mu * log_x
        cos2 = half / r if r > 0.0 else 1.0
        sin2 = exy / r if r > 0.0 else 0.0
        txx = beta + ratio * half / b2
        tyy = beta - ratio * half / b2
        txy = ratio * exy / b2
        energy = 0.5 * mu * (log_J * log_J + 0.25 * log_x * log_x)
        c = turned(
            2.0 * (mu - beta - difference),
            2.0 * (mu - beta + difference),
            0.0,
            ratio - beta + difference,
            cos2,
            sin2,
        )
    else:
        # tr b - 2 - 2 ln J, sorted so that terms of first order never appear.
        excess = (hxx - hyy) ** 2 + (hxy + hyx) ** 2 + 2.0 * log_defect(y)
        txx, tyy, txy = mu * exx, mu * eyy, mu * exy
        energy = 0.5 * mu * excess
        c = (2.0 * mu, 2.0 * mu, 0.0, 0.0, 0.0, mu)
    stored, pressure, bulk = volumetric(law, lam, mean)
    energy += stored + pressure * (y - mean)
    pressure *= J
    both = pressure if patched else pressure + bulk * J * J
    return (
        (txx + pressure, tyy + pressure, txy),
        energy,
        (
            c[0] + both - 2.0 * pressure,
            c[1] + both - 2.0 * pressure,
            c[2] + both,
            c[3],
            c[4],
            c[5] - pressure,
        ),
        state,
    )
