"""Stress intensity factors in a body that has turned much and is strained little."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cfmpm.body.grid import CrackTip, Floats, Grid
from cfmpm.body.materials import Materials
from cfmpm.body.points import DeformedPoints
from cfmpm.fracture.interaction import IntensityFactors, intensity_factors

# Largest relative difference of G from K_I and K_II and J at which strain around a tip is small: as
# large as what the grid alone makes of it on the grids that the default grading gives.
SMALL = 0.02


def corotated_factors(
    grid: Grid,
    points: DeformedPoints,
    gradients: Floats,
    material: Materials,
    tip: CrackTip,
    q: Floats,
    body_force: Floats,
    j: float,
) -> IntensityFactors | None:
    """Evaluate K_I, K_II and T at finite deformation, in axes that turn with the ring.

    Parameters
    ----------
    grid, points, gradients, material, tip, q, body_force
        As of `intensity_factors`, at finite deformation: stress is Cauchy's, all else refers to the
        reference configuration.
    j : float
        J of the ring [N/mm].

    Returns
    -------
    IntensityFactors or None
        None where strain in the ring is not small: G of the factors is then not J.

    Notes
    -----
    With the mean rotation R of the ring, R^T F - 1 is the displacement gradient and R^T sigma R the
    stress of small strain (corotational formulation: Belytschko and Hsieh 1973), up to terms of
    second order in the strain and in the rotation of points against the mean.
    """
    inside = np.any(q[grid.elements[:, :3]] > 0.0, axis=1)[points.element]
    F = np.eye(2) + points.displacement_gradient
    mean = np.average(F[inside], axis=0, weights=points.volume[inside])
    angle = np.arctan2(mean[1, 0] - mean[0, 1], mean[0, 0] + mean[1, 1])
    R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    sigma = R.T @ points.stress[:, [[0, 2], [2, 1]]] @ R
    turned_back = replace(
        points,
        displacement_gradient=R.T @ F - np.eye(2),
        stress=np.ascontiguousarray(sigma.reshape(-1, 4)[:, [0, 3, 1]]),
    )
    found = intensity_factors(grid, turned_back, gradients, material, tip, q, R.T @ body_force)
    return found if abs(found.G - j) <= SMALL * abs(j) else None
