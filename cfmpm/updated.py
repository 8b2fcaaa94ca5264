"""The updated Lagrangian formulation: a grid that is reset after every load step (paper step 9).

The state of a material point is its displacement gradient H_n when the grid was reset. On the grid
as it is now, dS/dX = F_n^T dS/dx with F_n = I + H_n and x the position in space, so that the sums
of `kernels.finite` over reference volumes hold as they are, with H_n as their base. That is the
paper's eqs 9 to 13 multiplied out.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cfmpm import pieces
from cfmpm.body import Body
from cfmpm.equilibrium import Equilibrium
from cfmpm.errors import SolveError
from cfmpm.fracture import cf
from cfmpm.fracture.release import triangle_quality
from cfmpm.grid import Floats, Grid, Ints
from cfmpm.kernels import assembly, basis, clipping, finite, smoothing, topology
from cfmpm.loading import Loading, hold_nodes
from cfmpm.motion import Motion, interpolate, nearest_filled
from cfmpm.points import MaterialPoints, relocate

# Over the nodes of a grid that is smoothed, at most.
SWEEPS = 10


def begin(body: Body) -> Body:
    """Let the grid of a body just built be reset from now on.

    Parameters
    ----------
    body : Body
        With the points at rest where they were seeded.

    Returns
    -------
    Body
    """
    grid, points = body.grid, body.points
    carrier = np.empty(len(grid.nodes), np.int64)
    carrier[grid.elements] = np.arange(len(grid.elements))[:, None]
    motion = Motion(
        reference=grid,
        loading=body.loading,
        position=points.position,
        element=points.element,
        gradients=basis.basis_gradients(grid.nodes, grid.elements, points.element, points.position),
        displacement=np.zeros_like(grid.nodes),
        carrier=carrier,
        base=np.zeros((len(points), 2, 2)),
        smoothed=np.zeros(len(grid.nodes), bool),
        resets=0,
        fill=1.0,
    )
    return replace(body, motion=motion)


def pull_back(gradients: Floats, base: Floats) -> Floats:
    """Turn basis gradients in space into those by the reference position.

    Parameters
    ----------
    gradients : (q, k, 2) float
        dS/dx [1/mm].
    base : (q, 2, 2) float
        Displacement gradient H_n.

    Returns
    -------
    (q, k, 2) float
        dS/dX_j = dS/dx_i (F_n)_ij [1/mm].
    """
    return gradients + np.einsum("qki,qij->qkj", gradients, base)


def in_reference(body: Body, gradients: Floats, balance: Equilibrium) -> tuple[Any, ...]:
    """Look at a state of balance from the reference configuration.

    Parameters
    ----------
    body : Body
    gradients : (q, k, 2) float
        Of its quadrature points.
    balance : Equilibrium

    Returns
    -------
    body, gradients, balance
        Of the material points on the grid in which they were seeded, with the displacement of the
        tracers; the same where the grid is not reset.
    """
    motion = body.motion
    if motion is None:
        return body, gradients, balance
    points = replace(body.points, position=motion.position, element=motion.element)
    seen = replace(
        body,
        grid=motion.reference,
        points=points,
        quadrature=None,
        integration=points,
        loading=motion.loading,
    )
    displacement = motion.traced(body.grid, _everywhere(body, balance.displacement))
    return seen, motion.gradients, replace(balance, displacement=displacement)


def material_force(body: Body, balance: Equilibrium) -> Floats:
    """Sum the configurational force at the nodes of the reference grid [N/mm], (n, 2).

    CF_I = - sum_p (W I - F^T P) dS_I/dX V_p, whose sum over a plateau of the reference position is
    the domain integral of the material. `finite.configurational_force` has H for F: on the grid
    of the solve that is the same in balance, but here the internal force is not zero.

    Parameters
    ----------
    body : Body
        From `in_reference`.
    balance : Equilibrium
    """
    motion = body.motion
    assert motion is not None
    grid, points = body.grid, body.points
    nodal = cf.finite_nodal_force(grid, points, motion.gradients, body.loading.body_force)
    internal = finite.internal_force(
        grid.elements,
        len(grid.nodes),
        points.element,
        motion.gradients,
        points.volume,
        points.displacement_gradient,
        points.stress,
    )
    external = balance.load_factor * body.loading.force
    return nodal + internal - external


def compare(body: Body, gradients: Floats, balance: Equilibrium) -> dict[str, Floats]:
    """Measure at each tip how far the grid has come apart from the material.

    Parameters
    ----------
    body : Body
        As it was solved.
    gradients : (q, k, 2) float
        Of its quadrature points.
    balance : Equilibrium

    Returns
    -------
    dict of str to (tip,) array
        `cf_norm_grid`, the configurational force over a disc of the present grid, of the same
        radius in space, and `tip_drift`; nothing where the grid is not reset.
    """
    motion = body.motion
    if motion is None:
        return {}
    force = body.loading.body_force
    nodal = cf.finite_nodal_force(body.grid, body.integration, gradients, force)
    traced = motion.reference.nodes + motion.traced(
        body.grid, _everywhere(body, balance.displacement)
    )
    norm, drift = [], []
    for tip, own, domain in zip(
        body.grid.tips, motion.reference.tips, body.tip_domains, strict=True
    ):
        on_grid = cf.domain_force(body.grid, nodal, tip, max(domain.radii))
        norm.append(np.hypot(*on_grid))
        place = body.grid.nodes[tip.node]
        if body.scene.updated.grid == "following":
            place = place + balance.displacement[tip.node]
        drift.append(np.hypot(*(traced[own.node] - place)))
    return {"cf_norm_grid": np.array(norm), "tip_drift": np.array(drift)}


def reset(body: Body, balance: Equilibrium) -> tuple[Body, Equilibrium]:
    """Put the points where they have moved to, and a grid under them (paper step 9).

    Parameters
    ----------
    body : Body
        In balance.
    balance : Equilibrium

    Returns
    -------
    body : Body
    balance : Equilibrium
        That the next load step sets out from: the grid at rest, at the same load factor.

    Raises
    ------
    SolveError
        Where points have left the grid, or it cannot be smoothed.
    """
    motion, old = body.motion, body.grid
    assert motion is not None
    moved = _everywhere(body, balance.displacement)
    traced = motion.traced(old, moved)
    grid, smoothed, changed = _followed(body, traced, moved)
    motion = replace(motion, displacement=traced, smoothed=smoothed, resets=motion.resets + changed)
    scene = body.scene
    by_domains = scene.updated.integration == "domains"
    points, rows = body.points, body.integration
    if by_domains:
        corners = motion.tracers[motion.reference.triangles]
        points = replace(points, position=corners.mean(axis=1))
    else:
        points = rows = _moved(points, old, moved)
    quadrature = body.quadrature
    if by_domains and changed:
        quadrature = _clipped(motion, points, grid)
        rows = _with_state(quadrature, points)
    elif by_domains:
        rows = _moved(rows, old, moved)
        if quadrature is not None:
            quadrature = replace(quadrature, position=rows.position)
        else:
            points = rows
    rows.element = relocate(grid, rows)
    if not by_domains:
        points = rows
    body = replace(body, grid=grid, points=points, quadrature=quadrature, integration=rows)
    body = _filled(body, replace(motion, base=rows.displacement_gradient))
    history = balance.history
    if len(history) != len(rows):
        history = np.zeros((len(rows), 0))
    nothing = np.zeros_like(grid.nodes)
    return body, replace(
        balance,
        displacement=nothing,
        internal_force=nothing,
        contact_force=nothing,
        history=history,
    )


def _everywhere(body: Body, displacement: Floats) -> Floats:
    """Let nodes without material go on as the nearest triangle with material does."""
    grid = body.grid
    filled = _are_filled(grid, body.integration.element)
    if filled.all():
        return displacement
    touched = np.zeros(len(grid.nodes), bool)
    touched[grid.elements[filled]] = True
    floating = np.flatnonzero(~touched)
    of_node = np.empty(len(grid.nodes), np.int64)
    of_node[grid.elements] = np.arange(len(grid.elements))[:, None]
    nearest = nearest_filled(grid, filled)[of_node[floating]]
    displacement = displacement.copy()
    displacement[floating] = interpolate(grid, displacement, nearest, grid.nodes[floating])
    return displacement


def _followed(body: Body, traced: Floats, moved: Floats) -> tuple[Grid, NDArray[np.bool_], bool]:
    """Let the grid follow the material, and smooth its bad triangles.

    Returns
    -------
    grid : Grid
    smoothed : (n,) bool
        Nodes that are not with their tracer.
    changed : bool
        Whether the grid was moved under the points.
    """
    motion, old = body.motion, body.grid
    assert motion is not None
    reference, smoothed = motion.reference, motion.smoothed
    nodes = np.where(smoothed[:, None], old.nodes + moved, reference.nodes + traced)
    triangles = np.ascontiguousarray(old.triangles)
    stars = topology.node_stars(triangles, len(nodes))
    free, least = ~_bound(motion), body.scene.updated.smooth_below
    now = smoothing.smooth(nodes, triangles, *stars, free, least, SWEEPS)
    worst = triangle_quality(nodes, triangles)
    if not worst.min() > 0.0:
        raise SolveError(
            f"{int((~(worst > 0.0)).sum())} triangles of the grid have turned over, and smoothing "
            "did not turn them back; take smaller load_steps, or a finer grid there"
        )
    return replace(old, nodes=nodes), smoothed | now, bool(now.any())


def _bound(motion: Motion) -> NDArray[np.bool_]:
    """Return the nodes that stay with the material: boundary, cracks, borders, supports."""
    grid = motion.reference
    bound = motion.loading.prescribed.any(axis=1)
    element, side = np.nonzero(grid.twins < 0)
    bound[grid.edge_nodes(3 * element + side)] = True
    bound[list(grid.points.values())] = True
    element, side = np.nonzero(grid.twins >= 0)
    across = grid.regions[grid.twins[element, side] // 3]
    border = across != grid.regions[element]
    bound[grid.edge_nodes(3 * element[border] + side[border])] = True
    return bound


def _moved(points: MaterialPoints, grid: Grid, displacement: Floats) -> MaterialPoints:
    """Carry points along with the grid."""
    by = interpolate(grid, displacement, points.element, points.position)
    return replace(points, position=points.position + by)


def _clipped(motion: Motion, points: MaterialPoints, grid: Grid) -> pieces.Quadrature:
    """Cut the domains of the points, as they lie now, along the sides of the grid.

    A domain is the triangle of the three tracers that the point was seeded between, with straight
    sides. The reference volume of a point is shared among its pieces by their area in space.
    Triangles that are still their own domains need no clipping.
    """
    corners = motion.tracers[motion.reference.triangles]
    whole = ~motion.smoothed[grid.triangles].any(axis=1)
    others = np.flatnonzero(~whole)
    domains = pieces.triangular_domains(corners)
    owner, element, position, area = clipping.clip_domains(
        grid.nodes,
        grid.elements,
        others,
        domains.anchors,
        domains.vertices,
        domains.offsets,
        others,
    )
    found = np.bincount(owner, area, len(points))
    volume = points.volume[owner] * area / found[owner]
    kept = np.flatnonzero(whole)
    order = np.argsort(np.concatenate([kept, element]), kind="stable")
    return pieces.Quadrature(
        owner=np.concatenate([kept, owner])[order],
        element=np.concatenate([kept, element])[order],
        position=np.concatenate([points.position[kept], position])[order],
        volume=np.concatenate([points.volume[kept], volume])[order],
        material=points.material[np.concatenate([kept, owner])[order]],
    )


def _with_state(quadrature: pieces.Quadrature, points: MaterialPoints) -> MaterialPoints:
    """Give each piece the state of its point."""
    return MaterialPoints(
        position=quadrature.position,
        volume=quadrature.volume,
        element=quadrature.element,
        material=quadrature.material,
        displacement_gradient=points.displacement_gradient[quadrature.owner],
        stress=points.stress[quadrature.owner],
        energy=points.energy[quadrature.owner],
    )


def _filled(body: Body, motion: Motion) -> Body:
    """Find what of the grid holds material, and put loads and supports on it."""
    grid, rows = body.grid, body.integration
    filled = _are_filled(grid, rows.element)
    touched = np.zeros(len(grid.nodes), bool)
    touched[grid.elements[filled]] = True
    floating = np.flatnonzero(~touched)
    det_F = 1.0 + _trace_and_det(rows.displacement_gradient)
    area = np.bincount(rows.element, rows.volume * det_F, len(grid.elements))
    motion = replace(motion, fill=float((area / grid.areas)[filled].min()))
    loading = motion.loading
    if loading.body_force.any():
        shape = basis.basis_values(grid.nodes, grid.elements, rows.element, rows.position)
        own_weight = assembly.body_force(
            grid.elements, len(grid.nodes), rows.element, shape, rows.volume, loading.body_force
        )
        loading = replace(
            loading, force=loading.force - loading.own_weight + own_weight, own_weight=own_weight
        )
    return replace(
        body,
        motion=motion,
        loading=hold_nodes(loading, floating),
        empty_elements=int((~filled).sum()),
        floating_nodes=len(floating),
    )


def _are_filled(grid: Grid, element: Ints) -> NDArray[np.bool_]:
    filled = np.zeros(len(grid.elements), bool)
    filled[element] = True
    return filled


def _trace_and_det(h: Floats) -> Floats:
    """det(I + H) - 1."""
    trace = h[:, 0, 0] + h[:, 1, 1]
    return trace + h[:, 0, 0] * h[:, 1, 1] - h[:, 0, 1] * h[:, 1, 0]
