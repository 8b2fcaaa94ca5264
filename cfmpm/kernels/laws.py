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
def logarithmic(law, mu, yield_stress, hardening, H, y, history, p):
    """Return the part W_mu of `HENCKY` and `J2`: quadratic in the logarithmic strain.

    Parameters
    ----------
    law, mu, yield_stress, hardening, H, history, p
        As in `respond`.
    y : float
        J - 1.

    Returns
    -------
    tau, energy, c, state
        As in `respond`, without the volumetric part.

    Notes
    -----
    b_e = F Cp^-1 F^T is that of the trial state. The return is radial in its logarithmic strain
    eps, with the exponential map for the plastic flow, and von Mises stress q: q - 3 mu dg =
    yield stress + hardening (alpha + dg) (Simo 1992; de Souza Neto, Peric and Owen 2008, section
    14.4 and box 7.3). Stored energy and plastic work together are a potential of the stress
    (Ortiz and Stainier 1999). ln(b_1 / b_2) = ln(1 + x) with x = (b_1 - b_2) / b_2 is exact to
    round-off however near the two are.
    """
    hxx, hxy, hyx, hyy = H
    fxx, fyy = 1.0 + hxx, 1.0 + hyy
    J = 1.0 + y
    # b_e - I = H + H^T + H H^T + F (Cp^-1 - I) F^T
    exx = 2.0 * hxx + hxx * hxx + hxy * hxy
    eyy = 2.0 * hyy + hyx * hyx + hyy * hyy
    exy = hxy + hyx + hxx * hyx + hxy * hyy
    area = J * J
    log_area = math.log1p(y)
    eps_zz = 0.0
    if law == J2:
        gxx, gyy, gxy = history[p, 0], history[p, 1], history[p, 2]
        exx += fxx * fxx * gxx + 2.0 * fxx * hxy * gxy + hxy * hxy * gyy
        eyy += hyx * hyx * gxx + 2.0 * hyx * fyy * gxy + fyy * fyy * gyy
        exy += fxx * hyx * gxx + (fxx * fyy + hxy * hyx) * gxy + hxy * fyy * gyy
        growth = gxx + gyy + (gxx * gyy - gxy * gxy)
        area *= 1.0 + growth
        log_area += 0.5 * math.log1p(growth)
        eps_zz = 0.5 * math.log1p(history[p, 3])
    half = 0.5 * (exx - eyy)
    r = math.hypot(half, exy)
    b1 = 1.0 + 0.5 * (exx + eyy) + r
    b2 = area / b1
    x = 2.0 * r / b2
    log_x = math.log1p(x)
    cos2 = half / r if r > 0.0 else 1.0
    sin2 = exy / r if r > 0.0 else 0.0

    common = mu * log_area  # (beta_1 + beta_2) / 2
    difference = 0.5 * mu * log_x  # (beta_1 - beta_2) / 2
    energy = mu * (0.5 * log_area * log_area + 0.125 * log_x * log_x + eps_zz * eps_zz)
    ratio = mu * (log_x / x if x > 0.0 else 1.0)  # s b_2
    a11 = a22 = 2.0 * mu  # d beta_i / d eps_j
    a12 = 0.0
    state = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if law == J2:
        alpha, work = history[p, 4], history[p, 5]
        state = (gxx, gyy, gxy, history[p, 3], alpha, work)
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
            # Cp^-1 changes by F^-1 (b_e - b_e trial) F^-T.
            db1 = b1 * math.expm1(-2.0 * lost * d1)
            db2 = b2 * math.expm1(-2.0 * lost * d2)
            bm, bd = 0.5 * (db1 + db2), 0.5 * (db1 - db2)
            bxx, byy, bxy = bm + bd * cos2, bm - bd * cos2, bd * sin2
            JJ = J * J
            state = (
                gxx + (fyy * fyy * bxx - 2.0 * fyy * hxy * bxy + hxy * hxy * byy) / JJ,
                gyy + (hyx * hyx * bxx - 2.0 * hyx * fxx * bxy + fxx * fxx * byy) / JJ,
                gxy + ((fxx * fyy + hxy * hyx) * bxy - fyy * hyx * bxx - hxy * fxx * byy) / JJ,
                history[p, 3] + (1.0 + history[p, 3]) * math.expm1(-2.0 * lost * d3),
                alpha + dg,
                work + dg * (yield_stress + hardening * (alpha + 0.5 * dg)),
            )
    beta_1, beta_2 = common + difference, common - difference
    c = turned(a11 - 2.0 * beta_1, a22 - 2.0 * beta_2, a12, ratio - beta_2, cos2, sin2)
    tau = (common + difference * cos2, common - difference * cos2, difference * sin2)
    return tau, energy, c, state


@kernel
def neo_hookean(mu, H, y):
    """Return the part W_mu = mu/2 (tr b - 2 - 2 ln J) of `NEO_HOOKEAN` and `CIARLET`.

    Parameters
    ----------
    mu, H
        As in `respond`.
    y : float
        J - 1.

    Returns
    -------
    tau, energy, c, state
        As in `respond`, without the volumetric part: tau = mu (b - I), of which the tangent is
        that of linear elasticity.
    """
    hxx, hxy, hyx, hyy = H
    # b - I = H + H^T + H H^T
    tau = (
        mu * (2.0 * hxx + hxx * hxx + hxy * hxy),
        mu * (2.0 * hyy + hyx * hyx + hyy * hyy),
        mu * (hxy + hyx + hxx * hyx + hxy * hyy),
    )
    # Sorted so that the terms of first order, which cancel, never appear.
    energy = 0.5 * mu * ((hxx - hyy) ** 2 + (hxy + hyx) ** 2 + 2.0 * log_defect(y))
    c = (2.0 * mu, 2.0 * mu, 0.0, 0.0, 0.0, mu)
    return tau, energy, c, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


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
        New row of the history: Cp^-1 - I xx, yy, xy, zz, accumulated plastic strain, plastic work
        per reference volume [MPa]; zero but for `J2`.

    Notes
    -----
    In principal axes c_iijj = d beta_i / d eps_j - 2 beta_i delta_ij and
    c_1212 = (beta_1 b_2 - beta_2 b_1) / (b_1 - b_2) = s b_2 - beta_2, with beta the principal
    values of tau and s = (beta_1 - beta_2) / (b_1 - b_2) (de Souza Neto, Peric and Owen 2008,
    section 14.5 and appendix A). s is in closed form for each law.
    """
    y = H[0] + H[3] + (H[0] * H[3] - H[1] * H[2])
    if law in (HENCKY, J2):
        tau, energy, c, state = logarithmic(law, mu, yield_stress, hardening, H, y, history, p)
    else:
        tau, energy, c, state = neo_hookean(mu, H, y)
    stored, pressure, bulk = volumetric(law, lam, mean)
    energy += stored + pressure * (y - mean)
    pressure *= 1.0 + y
    both = pressure if patched else pressure + bulk * (1.0 + y) * (1.0 + y)
    return (
        (tau[0] + pressure, tau[1] + pressure, tau[2]),
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
