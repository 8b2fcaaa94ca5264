"""Hyperelastic laws in the principal stretches of the right Cauchy-Green tensor.

cfmpm has them in closed form in the left one; nothing of it is used here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Below it the quotient of differences is a series.
SERIES_BELOW = 1e-2


@dataclass(frozen=True)
class Law:
    """An isotropic energy w = 2 mu sum_a Gamma(c_a) + U(ln J) of the squared stretches c_a.

    Attributes
    ----------
    shear : callable
        From c - 1 to Gamma, gamma = dGamma/de and dgamma/de, with e = ln(c) / 2.
    shear_slope : callable
        From c_1 - 1 and c_2 - 1 to (gamma_1 - gamma_2) / (c_1 - c_2).
    volume : callable
        From ln J to U, U', U'' for lambda = 1.
    """

    shear: Callable[[Floats], tuple[Floats, Floats, Floats]]
    shear_slope: Callable[[Floats, Floats], Floats]
    volume: Callable[[Floats], tuple[Floats, Floats, Floats]]


def _log_shear(x: Floats) -> tuple[Floats, Floats, Floats]:
    e = 0.5 * np.log1p(x)
    return 0.5 * e * e, e, np.ones_like(e)


def _log_slope(x: Floats, y: Floats) -> Floats:
    """Half of (ln c_1 - ln c_2) / (c_1 - c_2), as artanh(z) / z / (c_1 + c_2)."""
    total = 2.0 + x + y
    z = (x - y) / total
    near = np.abs(z) < SERIES_BELOW
    series = 1.0 + z**2 / 3.0 + z**4 / 5.0 + z**6 / 7.0 + z**8 / 9.0
    far = np.where(near, 0.5, z)
    return np.where(near, series, np.arctanh(far) / far) / total


def _linear_shear(x: Floats) -> tuple[Floats, Floats, Floats]:
    return 0.25 * (x - np.log1p(x)), 0.5 * x, 1.0 + x


def _linear_slope(x: Floats, y: Floats) -> Floats:
    return np.full_like(x, 0.5)


def _log_volume(theta: Floats) -> tuple[Floats, Floats, Floats]:
    return 0.5 * theta**2, theta, np.ones_like(theta)


def _square_volume(theta: Floats) -> tuple[Floats, Floats, Floats]:
    growth = np.expm1(2.0 * theta)
    return 0.25 * (growth - 2.0 * theta), 0.5 * growth, growth + 1.0


LAWS = {
    # mu e:e + lambda/2 tr(e)^2 with e = ln(C) / 2 (Hencky 1928)
    "hencky": Law(_log_shear, _log_slope, _log_volume),
    # mu/2 (I_1 - 2 - 2 ln J) + lambda/2 ln^2 J (Simo and Pister 1984)
    "neo_hookean": Law(_linear_shear, _linear_slope, _log_volume),
    # mu/2 (I_1 - 2 - 2 ln J) + lambda/4 (J^2 - 1 - 2 ln J) (Ciarlet 1988, sec. 4.10)
    "ciarlet": Law(_linear_shear, _linear_slope, _square_volume),
}


@dataclass(frozen=True)
class Response:
    """What a law gives at displacement gradients of any shape (..., 2, 2).

    Attributes
    ----------
    energy : (...) float
        Per reference volume [N mm/mm^3].
    stress : (..., 2, 2) float
        First Piola-Kirchhoff P [MPa].
    tangent : (..., 2, 2, 2, 2) float
        dP_ij/dF_kl [MPa].
    stretch : (...) float
        The larger principal stretch.
    """

    energy: Floats
    stress: Floats
    tangent: Floats
    stretch: Floats


def respond(law: str, lame: tuple[float, float], H: Floats) -> Response:
    """Evaluate a law.

    Parameters
    ----------
    law : {"hencky", "neo_hookean", "ciarlet"}
    lame : tuple of float
        lambda and mu [MPa].
    H : (..., 2, 2) float
        Displacement gradient du_i/dX_j; the determinant of F = 1 + H is positive.

    Returns
    -------
    Response
        S = sum_a S_a n_a n_a in the eigenvectors of C, P = F S, and the derivative of S by that
        of eigenvalues and eigenvectors (Ogden 1984, sec. 6.1.4).
    """
    lam, mu = lame
    rules = LAWS[law]
    Ht = np.swapaxes(H, -1, -2)
    # The eigenvalues of C - 1 keep their digits at small strain.
    x, n = np.linalg.eigh(H + Ht + Ht @ H)
    c = 1.0 + x
    Gamma, gamma, slope = rules.shear(x)
    U, dU, ddU = rules.volume(0.5 * np.log1p(x).sum(axis=-1))
    tau = 2.0 * mu * gamma + lam * dU[..., None]
    S = tau / c
    F = np.eye(2) + H

    # dS_a/dc_b, and (S_1 - S_2) / (c_1 - c_2) without the difference.
    d = 0.5 * lam * ddU[..., None, None] / (c[..., :, None] * c[..., None, :])
    for a in range(2):
        d[..., a, a] += (mu * slope[..., a] - tau[..., a]) / c[..., a] ** 2
    mixed = 2.0 * mu * rules.shear_slope(x[..., 0], x[..., 1])
    g = (mixed * c[..., 1] - tau[..., 1]) / (c[..., 0] * c[..., 1])

    dyads = np.einsum("...ia,...ja->...aij", n, n)
    cross = np.einsum("...i,...j->...ij", n[..., 0], n[..., 1])
    cross = cross + np.swapaxes(cross, -1, -2)
    second = np.einsum("...a,...aij->...ij", S, dyads)
    # F before the dyads: P and A have one leg in space.
    legs = F[..., None, :, :] @ dyads
    cross = F @ cross
    tangent = 2.0 * np.einsum("...ab,...aij,...bkl->...ijkl", d, legs, legs, optimize=True)
    tangent += np.einsum("...,...ij,...kl->...ijkl", g, cross, cross)
    tangent += np.einsum("ik,...jl->...ijkl", np.eye(2), second)
    energy = 2.0 * mu * Gamma.sum(axis=-1) + lam * U
    return Response(energy, F @ second, tangent, np.sqrt(c[..., 1]))


def least_acoustic(law: str, lame: tuple[float, float], H: Floats, directions: int = 180) -> Floats:
    """Return the smallest eigenvalue of the acoustic tensor N_j A_ijkl N_l [MPa], (...).

    Negative where the law is not elliptic. The directions N are evenly spaced, so that the true
    minimum lies lower by a part of second order in their spacing (a degree).
    """
    tangent = respond(law, lame, H).tangent
    least = np.full(H.shape[:-2], np.inf)
    for angle in np.arange(directions) * np.pi / directions:
        N = np.array([np.cos(angle), np.sin(angle)])
        Q = np.einsum("j,...ijkl,l->...ik", N, tangent, N)
        mean, half = 0.5 * (Q[..., 0, 0] + Q[..., 1, 1]), 0.5 * (Q[..., 0, 0] - Q[..., 1, 1])
        np.minimum(least, mean - np.hypot(half, Q[..., 0, 1]), out=least)
    return least
