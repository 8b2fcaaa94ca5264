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
        From `cf.ring_weight`. The ring lies in one material, and the crack in it is straight.
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
        grid.nodes[tip.node],
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
