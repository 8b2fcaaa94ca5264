"""Configurational force at a crack tip and over domains around it; energy release rate J."""

from __future__ import annotations

from typing import Any

import numpy as np

from cfmpm.body.grid import CrackTip, Floats, Grid
from cfmpm.body.points import DeformedPoints
from cfmpm.kernels import eshelby, finite

# Change of direction [rad] below which a crack is straight, but for round-off.
STRAIGHT = 1e-9


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
    return _linear_between_corners(grid, q)


def virtual_extension(grid: Grid, tip: CrackTip, radius: float) -> Floats:
    """Virtual extension of a crack along itself: the weight of a ring times the crack's direction.

    Parameters
    ----------
    grid : Grid
    tip : CrackTip
    radius : float
        Outer radius of the ring [mm].

    Returns
    -------
    (n, 2) float
        `ring_weight` times the direction in which the crack runs at the same distance from its tip:
        the tangent at the tip, and along the faces everywhere, so that nothing passes through
        these however the crack bends.
    """
    q = ring_weight(grid, tip, radius)
    away = np.hypot(*(tip.path - tip.path[0]).T)
    # Segments in the ring; those that come back towards the tip are out of its reach.
    leaves = (np.diff(away) > 0.0) & (away[:-1] < radius)
    n = len(leaves) if leaves.all() else int(np.argmin(leaves))
    headings = -np.diff(tip.path[: n + 1], axis=0)
    angles = np.unwrap(np.arctan2(headings[:, 1], headings[:, 0]))
    if np.ptp(angles) <= STRAIGHT:
        return np.outer(q, tip.tangent)
    # At a node of the crack it is the mean of both sides of it.
    at_nodes = np.concatenate([angles[:1], 0.5 * (angles[1:] + angles[:-1]), angles[-1:]])
    turned = np.interp(_distance(grid, tip), away[: n + 1], at_nodes)
    along = np.column_stack([np.cos(turned), np.sin(turned)])
    return _linear_between_corners(grid, q[:, None] * along)


def _linear_between_corners(grid: Grid, values: Floats) -> Floats:
    """Put what is linear between the corners at the other nodes; the array itself is changed."""
    element = grid.element
    for node in range(3, len(element.nodes)):
        corners = np.flatnonzero(element.nodes[node])
        parts = element.nodes[node] / element.order
        values[grid.elements[:, node]] = sum(
            parts[k] * values[grid.elements[:, k]] for k in corners
        )
    return values


def j_integral(nodal: Floats, extension: Floats) -> float:
    """Return J = sum_I v_I . CF_I of a virtual extension v [N/mm] (Li, Shih, Needleman 1985)."""
    return float((extension * nodal).sum())


def angle(force: Floats, tip: CrackTip) -> float:
    """Return the angle of a force from the tangent of the tip, anticlockwise [deg]."""
    t = tip.tangent
    return float(np.degrees(np.arctan2(t[0] * force[1] - t[1] * force[0], t @ force)))


def _distance(grid: Grid, tip: CrackTip) -> Floats:
    return np.hypot(*(grid.nodes - grid.nodes[tip.node]).T)
