"""Plane tensors and logarithms that several laws use."""

from __future__ import annotations

import math

from cfmpm._jit import kernel


@kernel
def log_defect(y):
    """Return y - ln(1 + y) without cancellation.

    Parameters
    ----------
    y : float
        Greater than -1.

    Returns
    -------
    float
        y^2/2 - y^3/3 + ...

    Notes
    -----
    For |y| <= 0.1 the series ln(1 + y) = 2 artanh z with z = y / (2 + y) is used; its first term
    is subtracted from y in closed form, y - 2 z = y z.
    """
    if abs(y) > 0.1:
        return y - math.log1p(y)
    z = y / (2.0 + y)
    zz = z * z
    # Seven terms: at |y| = 0.1 the eighth is below 1e-17 of the sum.
    series = 1.0 / 15.0
    for odd in (13.0, 11.0, 9.0, 7.0, 5.0, 3.0):
        series = 1.0 / odd + zz * series
    return y * z - 2.0 * z * zz * series


@kernel
def principal(exx, eyy, exy, area):
    """Return the in-plane principal values and axes of b.

    Parameters
    ----------
    exx, eyy, exy : float
        In-plane components of b - I.
    area : float
        Determinant of the in-plane part of b.

    Returns
    -------
    b1, b2 : float
        Principal values, b1 >= b2.
    x, log_x : float
        (b1 - b2) / b2 and ln(b1 / b2) = ln(1 + x), exact to round-off even if b1 is nearly b2.
    cos2, sin2 : float
        Cosine and sine of twice the angle from x to the axis of b1.
    """
    half = 0.5 * (exx - eyy)
    r = math.hypot(half, exy)
    b1 = 1.0 + 0.5 * (exx + eyy) + r
    b2 = area / b1
    x = 2.0 * r / b2
    cos2 = half / r if r > 0.0 else 1.0
    sin2 = exy / r if r > 0.0 else 0.0
    return b1, b2, x, math.log1p(x), cos2, sin2


@kernel
def turned(a11, a22, a12, shear, cos2, sin2):
    """Rotate a tangent from principal axes to x, y.

    Parameters
    ----------
    a11, a22, a12, shear : float
        c_1111, c_2222, c_1122 and c_1212 in principal axes [MPa].
    cos2, sin2 : float
        Cosine and sine of twice the angle from x to the first axis.

    Returns
    -------
    tuple of six floats
        c_xxxx, c_yyyy, c_xxyy, c_xxxy, c_yyxy, c_xyxy [MPa].

    Notes
    -----
    In principal axes c_iijj = d beta_i / d eps_j - 2 beta_i delta_ij and
    c_1212 = (beta_1 b_2 - beta_2 b_1) / (b_1 - b_2) = s b_2 - beta_2, with beta the principal
    values of tau, eps the logarithmic strains and s = (beta_1 - beta_2) / (b_1 - b_2) (de Souza
    Neto, Peric and Owen 2008, section 14.5 and appendix A). The laws provide s in closed form,
    without cancellation for equal principal values.
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
