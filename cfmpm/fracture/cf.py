"""Configurational force at a crack tip and over domains around it; energy release rate J."""

from __future__ import annotations

from typing import Any

import numpy as np

from cfmpm.body.crack_faces import FacePairs, Turning, face_pairs
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
    away, angles = _headings(tip, radius)
    if np.ptp(angles) <= STRAIGHT:
        return np.outer(q, tip.tangent)
    turned = np.interp(_distance(grid, tip), away, angles)
    along = np.column_stack([np.cos(turned), np.sin(turned)])
    return _linear_between_corners(grid, q[:, None] * along)


def j_of_sliding(
    grid: Grid,
    tip: CrackTip,
    radius: float,
    contact_force: Floats,
    displacement: Floats,
    turning: Turning | None = None,
) -> float:
    """Part of J from closed faces that slide along a curve, sum_I q_I F_I . n_I,s x [u]_I.

    Parameters
    ----------
    grid : Grid
        The whole one.
    tip : CrackTip
    radius : float
        Outer radius of the ring [mm].
    contact_force : (n, 2) float
        That crack faces exert on each other [N/mm].
    displacement : (n, 2) float
        [mm].
    turning : Turning, optional
        Rotation of the crack, at finite deformation.

    Returns
    -------
    float
        [N/mm]. The traction t of a closed face takes -t . [u],s out of a ring, s along it. It
        is normal to the face, and [u] . n = 0 along the face: the term is t . n ([u] . n,s), with
        n,s the curvature. Of a straight crack it vanishes.
    """
    away, angles = _headings(tip, radius)
    if np.ptp(angles) <= STRAIGHT:
        return 0.0
    pairs = face_pairs(grid, tip.crack, turning)
    segments = np.hypot(*np.diff(tip.path[: len(away)], axis=0).T)
    length = np.concatenate([[0.0], np.cumsum(segments)])
    s = np.interp(_distance(grid, tip)[pairs.left], away, length)
    # Half a segment to both sides: at a corner of the crack the mean of both.
    half = 0.5 * np.diff(length).min()
    turn = np.interp(s + half, length, angles) - np.interp(s - half, length, angles)
    curvature = -turn / (2.0 * half)  # s runs towards the tip
    across = np.column_stack([-pairs.normal[:, 1], pairs.normal[:, 0]])
    jump = displacement[pairs.left] - displacement[pairs.right]
    pressure = _along_normals(pairs, contact_force[pairs.left])
    q = ring_weight(grid, tip, radius)[pairs.left]
    return float((q * pressure * curvature * (jump * across).sum(axis=1)).sum())


def _along_normals(pairs: FacePairs, force: Floats) -> Floats:
    """Divide the force on each pair (k, 2) along its normals: a pair at a corner has two, (k,)."""
    sizes: Floats = (force * pairs.normal).sum(axis=1)
    nodes, times = np.unique(pairs.left, return_counts=True)
    for node in nodes[times == 2]:
        rows = np.flatnonzero(pairs.left == node)
        sizes[rows] = np.linalg.solve(pairs.normal[rows].T, force[rows[0]]).clip(0.0)
    return sizes


def _headings(tip: CrackTip, radius: float) -> tuple[Floats, Floats]:
    """Direction of a crack at the nodes of its line in a ring: distance from the tip, angle."""
    away = np.hypot(*(tip.path - tip.path[0]).T)
    # Segments in the ring; those that come back towards the tip are out of its reach.
    leaves = (np.diff(away) > 0.0) & (away[:-1] < radius)
    n = len(leaves) if leaves.all() else int(np.argmin(leaves))
    headings = -np.diff(tip.path[: n + 1], axis=0)
    angles = np.unwrap(np.arctan2(headings[:, 1], headings[:, 0]))
    # At a node of the crack it is the mean of both sides of it.
    return away[: n + 1], np.concatenate(
        [angles[:1], 0.5 * (angles[1:] + angles[:-1]), angles[-1:]]
    )


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
