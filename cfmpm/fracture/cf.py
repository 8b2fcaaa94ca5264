"""Configurational force at a crack tip and over domains around it; energy release rate J."""

from __future__ import annotations

from typing import Any

import numpy as np

from cfmpm.body.grid import CrackTip, Floats, Grid
from cfmpm.body.points import DeformedPoints
from cfmpm.kernels import eshelby, finite


def nodal_force(
    grid: Grid, points: DeformedPoints, gradients: Floats, body_force: Floats
) -> Floats:
    """Sum the configurational force at every node of the grid.

    Parameters
    ----------
    grid : Grid
    points : DeformedPoints
    gradients : (p, k, 2) float
        Basis gradients at the points [1/mm].
    body_force : (2,) float
        [N/mm^3].

    Returns
    -------
    (n, 2) float
        It points in the direction of crack growth (paper eq 26) [N/mm].
    """
    force = eshelby.configurational_force(*_summed(grid, points, gradients))
    return force + _of_body_force(grid, points, body_force)


def finite_nodal_force(
    grid: Grid, points: DeformedPoints, gradients: Floats, body_force: Floats
) -> Floats:
    """Sum the configurational force of finite deformation at every node of the grid.

    Parameters
    ----------
    grid, points, gradients, body_force
        As in `nodal_force`, per unit of reference length, area and volume.

    Returns
    -------
    (n, 2) float
        In the reference configuration [N/mm].
    """
    force = finite.configurational_force(*_summed(grid, points, gradients))
    return force + _of_body_force(grid, points, body_force)


def _summed(grid: Grid, points: DeformedPoints, gradients: Floats) -> tuple[Any, ...]:
    """Arguments of the kernels that sum over points."""
    state = points.displacement_gradient, points.stress, points.energy
    return grid.elements, len(grid.nodes), points.element, gradients, points.volume, *state


def _of_body_force(grid: Grid, points: DeformedPoints, body_force: Floats) -> Floats:
    """Contribution of a body force to the configurational force."""
    if not body_force.any():
        return np.zeros((len(grid.nodes), 2))
    values = grid.basis_values(points.element, points.position)
    return eshelby.body_configurational_force(
        grid.elements,
        len(grid.nodes),
        points.element,
        values,
        points.volume,
        points.displacement_gradient,
        body_force,
    )


def domain_force(grid: Grid, nodal: Floats, tip: CrackTip, radius: float) -> Floats:
    """Sum the configurational force over the nodes of a disc (paper eq 27).

    Parameters
    ----------
    grid : Grid
    nodal : (n, 2) float
        From `nodal_force`.
    tip : CrackTip
    radius : float
        [mm].

    Returns
    -------
    (2,) float
        [N/mm]. It equals the domain integral with the weight that is one on those nodes.
    """
    return nodal[_distance(grid, tip) <= radius].sum(axis=0)


def ring_weight(grid: Grid, tip: CrackTip, radius: float) -> Floats:
    """Weight q of a ring from half the radius to the radius, linear on each triangle.

    Parameters
    ----------
    grid : Grid
    tip : CrackTip
    radius : float
        Outer radius [mm].

    Returns
    -------
    (n,) float
        1 inside half the radius, 0 from the radius on. Values at other nodes than corners are
        interpolated linearly between the corners: the gradient of q is then constant in a
        triangle, and the points integrate the energy-momentum tensor exactly.
    """
    q = np.clip(2.0 - 2.0 * _distance(grid, tip) / radius, 0.0, 1.0)
    element = grid.element
    for node in range(3, len(element.nodes)):
        corners = np.flatnonzero(element.nodes[node])
        parts = element.nodes[node] / element.order
        q[grid.elements[:, node]] = sum(parts[k] * q[grid.elements[:, k]] for k in corners)
    return q


def j_integral(nodal: Floats, q: Floats, tip: CrackTip) -> float:
    """Return J = sum_I q_I CF_I . t of a ring [N/mm] (Li, Shih and Needleman 1985)."""
    return float(q @ nodal @ tip.tangent)


def angle(force: Floats, tip: CrackTip) -> float:
    """Return the angle of a force from the tangent of the tip, anticlockwise [deg]."""
    t = tip.tangent
    return float(np.degrees(np.arctan2(t[0] * force[1] - t[1] * force[0], t @ force)))


def _distance(grid: Grid, tip: CrackTip) -> Floats:
    return np.hypot(*(grid.nodes - grid.nodes[tip.node]).T)
