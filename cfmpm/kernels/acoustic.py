"""Loss of ellipticity: the smallest eigenvalue of the acoustic tensor over all directions."""

from __future__ import annotations

import math

import numpy as np

from cfmpm._jit import kernel
from cfmpm.kernels.finite import patch_means
from cfmpm.kernels.laws.dispatch import respond


@kernel
def lowest_on_circle(mxx, myy, mxy, wx, wy):
    """Return the unit vector v that minimises v.M v + 2 w.v.

    Parameters
    ----------
    mxx, myy, mxy : float
        Components of the symmetric matrix M.
    wx, wy : float
        Components of w.

    Returns
    -------
    vx, vy : float

    Notes
    -----
    The global minimum satisfies (M + nu I) v = -w with M + nu I positive semi-definite (Moré and
    Sorensen 1983). In the axes of M, t = nu + smallest eigenvalue of M is the root of |v(t)| = 1.
    The function 1 / |v(t)| is concave, so that Newton's method approaches the root from the left
    and does not overshoot.
    """
    half = 0.5 * (mxx - myy)
    r = math.hypot(half, mxy)
    # Axis of M with the smallest eigenvalue.
    angle = 0.5 * math.atan2(-mxy, -half)
    c, s = math.cos(angle), math.sin(angle)
    w1, w2 = c * wx + s * wy, c * wy - s * wx
    gap = 2.0 * r
    t = max(abs(w1), abs(w2) - gap)
    # A negligible w1 is taken as zero: the quotients below would overflow.
    if abs(w1) <= 1e-17 * (gap + abs(w2)) and abs(w2) <= gap:
        v2 = -w2 / gap if gap > 0.0 else 0.0
        v1 = math.sqrt(1.0 - v2 * v2)
    else:
        for _ in range(50):
            v1, v2 = -w1 / t, -w2 / (gap + t)
            norm = math.hypot(v1, v2)
            slope = (v1 * v1 / t + v2 * v2 / (gap + t)) / (norm * norm)
            step = (norm - 1.0) / slope
            t += step
            if not step > 1e-15 * t:
                break
        v1, v2 = -w1 / t, -w2 / (gap + t)
        norm = math.hypot(v1, v2)
        v1 /= norm
        v2 /= norm
    return c * v1 - s * v2, s * v1 + c * v2


@kernel
def lowest_eigenvalue(F, tau, c):
    """Return the smallest eigenvalue of the acoustic tensor of one point over all directions.

    Parameters
    ----------
    F : tuple of four floats
        Deformation gradient xx, xy, yx, yy.
    tau : tuple of three floats
        Kirchhoff stress xx, yy, xy [MPa].
    c : tuple of six floats
        Spatial tangent, as returned by `laws.dispatch.respond` [MPa].

    Returns
    -------
    float
        min over |N| = 1 of the smallest eigenvalue of Q_ik = A_iJkL N_J N_L, A = dP/dF [MPa].

    Notes
    -----
    With v = (cos, sin) of twice the angle of N and u the same for a unit vector m, m.Q m is
    bilinear: a + b.v + c.u + u.D v. Hence the smaller eigenvalue of Q is
    g(v) = a + b.v - |c + D v|, and det(Q - s I) = (a - s + b.v)^2 - |c + D v|^2 is a quadratic
    function of v, whose global minimum on the unit circle is given by `lowest_on_circle`. The
    iteration starts at the direction of the smallest trace; s = g(v) decreases from minimum to
    minimum until det(Q - s I) >= 0 for all directions. This s is the smallest eigenvalue, to
    round-off, without sampling of directions.
    """
    fxx, fxy, fyx, fyy = F
    J = fxx * fyy - fxy * fyx
    trace = np.empty(3)
    normal = np.empty(3)
    shear = np.empty(3)
    for i in range(3):
        # F^-T X F^-1 for X = I, diag(1, -1), offdiag(1, 1); N (x) N is a combination of these.
        if i == 2:
            yxx = -2.0 * fyy * fyx
            yyy = -2.0 * fxx * fxy
            yxy = fxx * fyy + fxy * fyx
        else:
            sign = 1.0 - 2.0 * i
            yxx = fyy * fyy + sign * fyx * fyx
            yyy = fxy * fxy + sign * fxx * fxx
            yxy = -fyy * fxy - sign * fyx * fxx
        yxx, yyy, yxy = yxx / (J * J), yyy / (J * J), yxy / (J * J)
        initial = tau[0] * yxx + tau[1] * yyy + 2.0 * tau[2] * yxy
        qxx = c[0] * yxx + 2.0 * c[3] * yxy + c[5] * yyy + initial
        qyy = c[5] * yxx + 2.0 * c[4] * yxy + c[1] * yyy + initial
        qxy = c[3] * yxx + (c[2] + c[5]) * yxy + c[4] * yyy
        trace[i] = 0.25 * (qxx + qyy)
        normal[i] = 0.25 * (qxx - qyy)
        shear[i] = 0.5 * qxy
    a, bx, by = trace
    c1, d11, d12 = normal
    c2, d21, d22 = shear
    # Quadratic part of the determinant, b (x) b - D^T D.
    mxx = bx * bx - d11 * d11 - d21 * d21
    myy = by * by - d12 * d12 - d22 * d22
    mxy = bx * by - d11 * d12 - d21 * d22
    b = math.hypot(bx, by)
    vx, vy = (-bx / b, -by / b) if b > 0.0 else (1.0, 0.0)
    lowest = math.inf
    while True:
        value = a + bx * vx + by * vy
        value -= math.hypot(c1 + d11 * vx + d12 * vy, c2 + d21 * vx + d22 * vy)
        if not value < lowest:
            return lowest
        lowest = value
        wx = (a - lowest) * bx - (d11 * c1 + d21 * c2)
        wy = (a - lowest) * by - (d12 * c1 + d22 * c2)
        vx, vy = lowest_on_circle(mxx, myy, mxy, wx, wy)


@kernel
def ellipticity(volume, material, law, constants, internal, displacement_gradient, patch):
    """Return the smallest eigenvalue of the acoustic tensor at each point, relative to mu.

    Parameters
    ----------
    volume, material, law, constants, internal, patch
        As in `finite.stiffness`.
    displacement_gradient : (p, 2, 2) float
        H = F - I.

    Returns
    -------
    (p,) float
        Smallest eigenvalue over all directions divided by mu: 1 without strain, zero or negative
        where ellipticity (rank-one convexity) is lost, -inf where det F <= 0. The tangent is the
        consistent tangent of Newton's method, elastoplastic where the point yields in the step.
    """
    n = len(volume)
    result = np.empty(n)
    means = patch_means(volume, displacement_gradient, patch)
    for p in range(n):
        hxx, hxy = displacement_gradient[p, 0, 0], displacement_gradient[p, 0, 1]
        hyx, hyy = displacement_gradient[p, 1, 0], displacement_gradient[p, 1, 1]
        F = (1.0 + hxx, hxy, hyx, 1.0 + hyy)
        if not F[0] * F[3] - F[1] * F[2] > 0.0:
            result[p] = -math.inf
            continue
        m = material[p]
        H = (hxx, hxy, hyx, hyy)
        mean = means[patch[p]] if len(patch) else hxx + hyy + (hxx * hyy - hxy * hyx)
        tau, _, c, _ = respond(law[m], constants, m, H, mean, False, internal, p)
        result[p] = lowest_eigenvalue(F, tau, c) / constants[m, 1]
    return result
