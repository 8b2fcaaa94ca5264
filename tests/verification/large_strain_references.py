"""Closed-form and one-dimensional solutions at large strain, with their sources.

Plane strain, per mm of thickness; energies per reference volume; names as in the package.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc, lambertw


def lame(E, nu):
    """Lame's constants lambda and mu."""
    return E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))


def confined_energy(law, E, nu, stretch):
    """Energy of a body in confined (uniaxial strain) stretch."""
    lam, mu = lame(E, nu)
    log = np.log(stretch)
    if law == "hencky":
        return 0.5 * (lam + 2 * mu) * log**2
    shear = 0.5 * mu * (stretch**2 - 1 - 2 * log)
    if law == "neo_hookean":
        return shear + 0.5 * lam * log**2
    return shear + 0.25 * lam * (stretch**2 - 1 - 2 * log)


def confined_stress(law, E, nu, stretch):
    """Nominal stress dW/dl of the confined stretch."""
    lam, mu = lame(E, nu)
    if law == "hencky":
        return (lam + 2 * mu) * np.log(stretch) / stretch
    shear = mu * (stretch - 1 / stretch)
    if law == "neo_hookean":
        return shear + lam * np.log(stretch) / stretch
    return shear + 0.5 * lam * (stretch - 1 / stretch)


def confined_stretch(law, E, nu, stress):
    """The confined stretch under a nominal stress, on the branch through l = 1."""
    lam, mu = lame(E, nu)
    if law == "hencky":
        # ln(l) / l = p is solved by Lambert's W.
        return np.exp(-lambertw(-stress / (lam + 2 * mu)).real)
    if law == "ciarlet":
        half = 0.5 * stress / (mu + 0.5 * lam)
        return half + np.hypot(half, 1.0)
    return brentq(lambda x: confined_stress(law, E, nu, x) - stress, 0.05, 20.0, xtol=1e-15)


def column_under_weight(law, E, nu, height, weight, y):
    """Displacement at height y of a laterally confined column under its own weight.

    Equilibrium P' = w (weight w per reference volume, downwards; P = 0 on top) with u' = l - 1
    gives du = (l - 1) P'(l) dl / w, whose integral is ((l - 1) P - W) / w.
    """

    def part(at):
        stretch = confined_stretch(law, E, nu, -weight * (height - at))
        stress = confined_stress(law, E, nu, stretch)
        return (stretch - 1) * stress - confined_energy(law, E, nu, stretch)

    return np.array([part(at) - part(0.0) for at in np.atleast_1d(y)]) / weight


def column_energy(law, E, nu, height, weight):
    """Strain energy of that column, per mm of width."""

    def density(at):
        stretch = confined_stretch(law, E, nu, -weight * (height - at))
        return confined_energy(law, E, nu, stretch)

    x, w = np.polynomial.legendre.leggauss(40)
    return (
        0.5
        * height
        * sum(wi * density(0.5 * height * (1 + xi)) for xi, wi in zip(x, w, strict=True))
    )


def hencky_bar_stretch(E, nu, stress):
    """Stretch of a bar of Hencky's law with free sides under a dead nominal stress.

    tau = E' ln l with E' = E / (1 - nu^2), for the lateral stress vanishes at ln(l_lateral) =
    -nu / (1 - nu) ln l; and tau = P l, for tau is J sigma. So ln(l) / l = P / E', whose
    largest value is 1/e, at l = e.
    """
    return float(np.exp(-lambertw(-stress * (1 - nu**2) / E).real))


def hencky_bar_limit(E, nu):
    """The largest dead nominal stress of that bar, E'/e; its stretch there is e."""
    return E / (1 - nu**2) / np.e


def elastica(k):
    """Cantilever with a dead transverse end force: relative deflection and shortening.

    Parameters
    ----------
    k : float
        P L^2 / (E I), with E / (1 - nu^2) for E in plane strain.

    Returns
    -------
    deflection, shortening, slope : float
        Relative to the length, and the slope of the end [rad].

    Notes
    -----
    Bisshopp and Drucker (1945), Quart. Appl. Math. 3, 272: with p^2 = (1 + sin theta_0) / 2 and
    sin phi_1 = 1 / (p sqrt 2), sqrt k = K(p) - F(phi_1), deflection = 1 - 2 (E(p) - E(phi_1)) /
    sqrt k, projected length = sqrt(2 sin(theta_0) / k).
    """

    def length(theta):
        m = 0.5 * (1 + np.sin(theta))
        return ellipk(m) - ellipkinc(np.arcsin(1 / np.sqrt(2 * m)), m)

    slope = brentq(lambda theta: length(theta) - np.sqrt(k), 1e-9, 0.5 * np.pi - 1e-12, xtol=1e-15)
    m = 0.5 * (1 + np.sin(slope))
    rest = ellipe(m) - ellipeinc(np.arcsin(1 / np.sqrt(2 * m)), m)
    return 1 - 2 * rest / np.sqrt(k), 1 - np.sqrt(2 * np.sin(slope) / k), slope


def cylinder_limit_pressure(inner, outer, yield_stress):
    """Limit pressure of a thick cylinder in plane strain, no hardening (von Mises).

    2 sigma_y / sqrt(3) ln(b / a) with the current radii (Hill 1950, ch. V).
    """
    return 2 * yield_stress / np.sqrt(3) * np.log(outer / inner)


def confined_plastic(E, nu, yield_stress, hardening, stretch):
    """Axial and lateral Kirchhoff stress of a confined stretch, J2 with linear hardening.

    The logarithmic strain keeps its direction, so the small strain solution holds for it:
    tau = K ln l + 2/3 q along and K ln l - 1/3 q across, with q = 2 mu ln l at most q_y =
    sigma_y + H eps_p and eps_p = (2 mu ln l - sigma_y) / (3 mu + H).
    """
    lam, mu = lame(E, nu)
    log = np.log(stretch)
    q = 2 * mu * log
    beyond = abs(q) - yield_stress
    if beyond > 0:
        q = np.sign(q) * (yield_stress + hardening * beyond / (3 * mu + hardening))
    mean = (lam + 2 * mu / 3) * log
    return mean + 2 * q / 3, mean - q / 3


def sheared(E, nu, yield_stress, hardening, shear):
    """Cauchy stress (xx, yy, xy) at simple shears from rest, F = [[1, shear], [0, 1]], of J2.

    Elastic: principal stretches exp(+-asinh(shear / 2)) (Hencky), the first at the angle
    arctan(2 / shear) / 2 from x. Plastic: with b_e = R(phi) diag(e^2e, e^-2e) R(phi)^T, the flow
    rule l b_e + b_e l^T - d b_e = 2 gamma n b_e (Simo and Hughes 1998, sec. 9.2) gives, in the
    axes of b_e,

        dphi = (e^-2e cos^2 phi - e^2e sin^2 phi) / (e^2e - e^-2e) d shear,
        de = H / (3 mu + H) sin phi cos phi d shear,

    for 2 sqrt(3) mu e = sigma_y + H eps_p and d eps_p = 2 / sqrt(3) (sin phi cos phi d shear - de).
    """
    mu = lame(E, nu)[1]
    shear = np.asarray(shear, float)
    e_yield = yield_stress / (2 * np.sqrt(3) * mu)
    shear_yield = 2 * np.sinh(e_yield)
    e, phi = np.arcsinh(shear / 2), 0.5 * np.arctan2(2.0, shear)

    def flow(_, state):
        phi, e = state
        one, two = np.exp(2 * e), np.exp(-2 * e)
        turn = (two * np.cos(phi) ** 2 - one * np.sin(phi) ** 2) / (one - two)
        return turn, hardening / (3 * mu + hardening) * np.sin(phi) * np.cos(phi)

    plastic = shear > shear_yield
    if plastic.any():
        start = 0.5 * np.arctan2(2.0, shear_yield), e_yield
        path = solve_ivp(
            flow,
            (shear_yield, shear.max()),
            start,
            t_eval=shear[plastic],
            method="DOP853",
            rtol=1e-12,
            atol=1e-14,
        )
        phi[plastic], e[plastic] = path.y
    tau = 2 * mu * e
    return tau * np.cos(2 * phi), -tau * np.cos(2 * phi), tau * np.sin(2 * phi)
