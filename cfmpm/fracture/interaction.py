"""Stress intensity factors and T-stress by interaction integrals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cfmpm.grid import CrackTip, Floats, Grid
from cfmpm.kernels import eshelby
from cfmpm.materials import plane_modulus
from cfmpm.points import MaterialPoints


@dataclass(frozen=True)
class IntensityFactors:
    """Stress intensity factors [MPa sqrt(mm)], T-stress [MPa] and G [N/mm] of a tip."""

    K_I: float
    K_II: float
    T_stress: float
    G: float


def intensity_factors(
    grid: Grid,
    points: MaterialPoints,
    gradients: Floats,
    lame: Floats,
    tip: CrackTip,
    q: Floats,
    body_force: Floats,
) -> IntensityFactors:
    """Evaluate K_I, K_II and T in a ring around a tip.

    Parameters
    ----------
    grid : Grid
    points : MaterialPoints
    gradients : (p, k, 2) float
        Basis gradients at the points [1/mm].
    lame : (2,) float
        Lame's constants of the material in the ring [MPa].
    tip : CrackTip
    q : (n,) float
        From `cf.ring_weight`. The ring lies in one material. The crack in it may be kinked: the
        angle of the auxiliary fields then jumps at the real faces, while what the faces
        themselves add, which vanishes with the ring, is left out.
    body_force : (2,) float
        [N/mm^3].

    Returns
    -------
    IntensityFactors
        K = E' I / 2 (Stern, Becker and Dunham 1976), T = E' I of the unit point force (Kfouri
        1986), G = (K_I^2 + K_II^2) / E' (Irwin 1957).
    """
    modulus = plane_modulus(*lame)
    # Only points with a node inside the ring can add anything.
    inside = np.flatnonzero((q[grid.elements[:, :3]] > 0.0).any(axis=1)[points.element])
    r, theta = polar_coordinates(tip, points.position[inside])
    integrals = eshelby.interaction_integrals(
        grid.nodes,
        grid.elements,
        points.element[inside],
        points.position[inside],
        gradients[inside],
        points.volume[inside],
        points.displacement_gradient[inside],
        points.stress[inside],
        q,
        r,
        theta,
        tip.tangent,
        *lame,
        body_force,
    )
    k_1, k_2 = 0.5 * modulus * integrals[:2]
    return IntensityFactors(
        K_I=float(k_1),
        K_II=float(k_2),
        T_stress=float(modulus * integrals[2]),
        G=float((k_1**2 + k_2**2) / modulus),
    )


def polar_coordinates(tip: CrackTip, x: Floats) -> tuple[Floats, Floats]:
    """Return distance from the tip and angle from its tangent, continuous up to the crack's faces.

    Parameters
    ----------
    tip : CrackTip
    x : (k, 2) float
        [mm].

    Returns
    -------
    r : (k,) float
        [mm].
    theta : (k,) float
        [rad]; beyond +-pi between the faces of a kinked crack and the extension of its end.
    """
    away = x - tip.path[0]
    t = tip.tangent
    theta = np.arctan2(t[0] * away[:, 1] - t[1] * away[:, 0], away @ t)
    starts, ahead = tip.path[1:], tip.path[:-1] - tip.path[1:]
    # Which side of the crack a point is on is that of the segment nearest to it.
    nearest = np.full(len(x), np.inf)
    side = np.zeros(len(x))
    for start, along in zip(starts, ahead, strict=True):
        to = x - start
        part = np.clip(to @ along / (along @ along), 0.0, 1.0)
        gap = np.hypot(*(to - part[:, None] * along).T)
        closer = gap < nearest
        nearest[closer] = gap[closer]
        side[closer] = np.sign(along[0] * to[closer, 1] - along[1] * to[closer, 0])
    behind = np.abs(theta) > 0.5 * np.pi
    theta = theta + 2.0 * np.pi * behind * ((side > 0) & (theta < 0))
    theta = theta - 2.0 * np.pi * behind * ((side < 0) & (theta > 0))
    return np.hypot(*away.T), theta
