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
from cfmpm.grid import Floats, Grid, Ints, build_grid
from cfmpm.kernels import assembly, basis, clipping, finite, smoothing, topology
from cfmpm.loading import hold_nodes
from cfmpm.materials import region_materials
from cfmpm.meshing import mesh_size
from cfmpm.meshing.margin import surround
from cfmpm.motion import Motion, interpolate, nearest_filled
from cfmpm.patches import build_patches
from cfmpm.points import MaterialPoints, locate, relocate
from cfmpm.springs import Springs, ghost, join, supports

# Over the nodes of a grid that is smoothed, at most.
SWEEPS = 10
# Of the size of the body: how far it may move besides what supports prescribe.
MARGIN = 0.05
# Stiffness of a support in which the grid moves, over the largest modulus of the material.
STIFFNESS = 1e4
LEFT = "make updated.margin larger, unless points have been torn off (empty_elements)"
# Part of a particle domain that may lie outside the grid: round-off.
LOST = 1e-6
# Part of a triangle that material fills below which it is stabilised (design study).
LITTLE = 0.6


def begin(body: Body) -> Body:
    """Let the grid of a body just built be reset from now on.

    Parameters
    ----------
    body : Body
        With the points at rest where they were seeded.

    Returns
    -------
    Body
        Its triangles keep their numbers; a fixed grid has a margin besides.

    Raises
    ------
    MeshError
        Where no margin can be made.
    """
    grid, points = body.grid, body.points
    motion = Motion(
        reference=grid,
        loading=body.loading,
        position=points.position,
        element=points.element,
        gradients=basis.basis_gradients(grid.nodes, grid.elements, points.element, points.position),
        displacement=np.zeros_like(grid.nodes),
        triangle=_a_triangle_of_each(grid),
        carrier=_a_triangle_of_each(grid),
        base=np.zeros((len(points), 2, 2)),
        smoothed=np.zeros(len(grid.nodes), bool),
        springs=None,
        resets=0,
        fill=1.0,
    )
    if body.scene.updated.grid == "fixed":
        patches, grid = body.patches, _with_margin(body)
        if patches is not None:
            # None across the border of the body, which has those of the reference.
            margin = np.full(len(grid.elements), len(grid.region_names))
            margin[: len(motion.reference.elements)] = motion.reference.regions
            patches = build_patches(replace(grid, regions=margin))
        body = replace(body, grid=grid, patches=patches)
    return _loaded(body, motion)


def _with_margin(body: Body) -> Grid:
    """Put a margin around the grid of a body; tips keep their order."""
    scene, reference = body.scene, body.grid
    size = float(np.ptp(reference.nodes, axis=0).max())
    margin = scene.updated.margin
    if margin is None:
        levels = scene.load_steps if isinstance(scene.load_steps, list) else [1.0]
        reach = np.abs(body.loading.displacement).max() * np.abs(levels).max()
        margin = float(reach) + MARGIN * size
    grid = build_grid(
        surround(body.triangulation, margin, mesh_size(scene) or MARGIN * size),
        scene.mesh.element,
    )
    tips = {(tip.crack, tip.end): tip for tip in grid.tips}
    return replace(grid, tips=tuple(tips[tip.crack, tip.end] for tip in reference.tips))


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


def closed_faces(body: Body, motion: Motion) -> dict[str, Any]:
    """Return what contact of crack faces is found from, as fields of `newton.Problem`.

    The nodes of a following grid are those of the reference. In a fixed grid the two faces of the
    material are not where the doubled nodes are, and contact is left out.
    """
    if _is_fixed(body):
        return {"faces": replace(body.grid, crack_faces={})}
    return {"faces": motion.reference, "carried": motion.displacement}


def in_reference(
    body: Body, gradients: Floats, balance: Equilibrium
) -> tuple[Body, Floats, Equilibrium]:
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
    force = balance.internal_force
    if _is_fixed(body):
        # What moves past the grid is held by springs.
        loading, factor = motion.loading, balance.load_factor
        slip = factor * loading.displacement - displacement
        held = np.where(loading.prescribed, STIFFNESS * _largest_modulus(body) * slip, 0.0)
        force = factor * loading.force + held
    return (
        seen,
        motion.gradients,
        replace(
            balance,
            displacement=displacement,
            internal_force=force,
            contact_force=np.zeros_like(force) if _is_fixed(body) else balance.contact_force,
        ),
    )


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
    density = balance.load_factor * body.loading.body_force
    nodal = cf.finite_nodal_force(grid, points, motion.gradients, density)
    internal = finite.internal_force(
        grid.elements,
        len(grid.nodes),
        points.element,
        motion.gradients,
        points.volume,
        points.displacement_gradient,
        points.stress,
    )
    applied = balance.load_factor * body.loading.force + balance.contact_force
    return nodal + internal - applied


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
    force = balance.load_factor * body.loading.body_force
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
        if not _is_fixed(body):
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
    grid, smoothed, changed = old, motion.smoothed, True
    if not _is_fixed(body):
        grid, smoothed, changed = _followed(body, traced, moved)
    motion = replace(motion, displacement=traced, smoothed=smoothed, resets=motion.resets + changed)
    points, quadrature = body.points, body.quadrature
    rows = _moved(body.integration, old, moved)
    if body.scene.updated.integration == "points":
        points = rows
    else:
        corners = motion.tracers[motion.reference.triangles]
        points = replace(points, position=corners.mean(axis=1))
        if changed:
            quadrature = _clipped(motion, points, grid, fixed=_is_fixed(body))
            rows = _with_state(quadrature, points)
        elif quadrature is None:
            points = rows
        else:
            quadrature = replace(quadrature, position=rows.position)
    rows.element = relocate(grid, rows, LEFT)
    body = replace(body, grid=grid, points=points, quadrature=quadrature, integration=rows)
    motion = replace(motion, base=rows.displacement_gradient)
    history = balance.history
    if len(history) != len(rows):
        history = np.zeros((len(rows), 0))
    nothing = np.zeros_like(grid.nodes)
    return _loaded(body, motion), replace(
        balance,
        displacement=nothing,
        internal_force=nothing,
        contact_force=nothing,
        history=history,
    )


def restore(
    body: Body,
    nodes: Floats,
    points: MaterialPoints,
    quadrature: pieces.Quadrature | None,
    kept: dict[str, Any],
) -> Body:
    """Bring a body just begun to where it had come.

    Parameters
    ----------
    body : Body
        From `begin`.
    nodes : (m, 2) float
        Of the grid when it was reset last [mm].
    points : MaterialPoints
    quadrature : pieces.Quadrature or None
    kept : dict
        Fields of `Motion`: `displacement`, `triangle`, `base`, `smoothed` and `resets`.

    Returns
    -------
    Body
    """
    motion = body.motion
    assert motion is not None
    rows = points if quadrature is None else _with_state(quadrature, points)
    rows.displacement_gradient = kept["base"]
    grid = replace(body.grid, nodes=nodes)
    body = replace(body, grid=grid, points=points, quadrature=quadrature, integration=rows)
    return _loaded(body, replace(motion, **kept))


def _is_fixed(body: Body) -> bool:
    return body.scene.updated.grid == "fixed"


def _largest_modulus(body: Body) -> float:
    return max(m.E for m in region_materials(body.scene, body.grid.region_names))


def _a_triangle_of_each(grid: Grid) -> Ints:
    """Return a triangle of each node."""
    found = np.empty(len(grid.nodes), np.int64)
    found[grid.elements] = np.arange(len(grid.elements))[:, None]
    return found


def _everywhere(body: Body, displacement: Floats) -> Floats:
    """Let nodes without material go on as the nearest triangle with material does."""
    grid = body.grid
    filled = _are_filled(grid, body.integration.element)
    if filled.all() or _is_fixed(body):
        return displacement
    touched = np.zeros(len(grid.nodes), bool)
    touched[grid.elements[filled]] = True
    floating = np.flatnonzero(~touched)
    nearest = nearest_filled(grid, filled)[_a_triangle_of_each(grid)[floating]]
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
    now = smoothing.smooth(nodes, triangles, stars[0], stars[1], free, least, SWEEPS)
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
    bound: NDArray[np.bool_] = np.any(motion.loading.prescribed, axis=1)
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


def _clipped(
    motion: Motion, points: MaterialPoints, grid: Grid, *, fixed: bool
) -> pieces.Quadrature:
    """Cut the domains of the points, as they lie now, along the sides of the grid.

    A domain is the triangle of the three tracers that the point was seeded between, with straight
    sides. The reference volume of a point is shared among its pieces by their area in space.
    Triangles that are still their own domains need no clipping.
    """
    domains = pieces.triangular_domains(motion.tracers[motion.reference.triangles])
    whole: NDArray[np.bool_] = np.zeros(len(grid.elements), bool)
    owners = np.arange(len(points))
    if not fixed:
        whole = ~np.any(motion.smoothed[grid.triangles], axis=1)
        owners = np.flatnonzero(~whole)
    owner, element, position, area = clipping.clip_domains(
        grid.nodes,
        grid.elements,
        np.flatnonzero(~whole),
        domains.anchors,
        domains.vertices,
        domains.offsets,
        owners,
    )
    found = np.bincount(owner, area, len(points))
    ux, uy, vx, vy = domains.vertices.reshape(-1, 3, 2)[:, 1:].reshape(-1, 4).T
    whole_area = 0.5 * (ux * vy - uy * vx)
    lost = np.flatnonzero(~(found >= (1.0 - LOST) * whole_area) | ~(whole_area > 0.0))
    lost = np.intersect1d(lost, owners)
    if lost.size:
        x, y = points.position[lost[0]]
        raise SolveError(
            f"{lost.size} particle domains have turned over or left the grid, the first at "
            f"({x:.6g}, {y:.6g}) mm; make updated.margin larger, or take updated.grid: following, "
            "which needs mesh.element: T3"
        )
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


def _loaded(body: Body, motion: Motion) -> Body:
    """Find what of the grid holds material, and put loads and supports on it."""
    grid, rows = body.grid, body.integration
    filled = _are_filled(grid, rows.element)
    touched = np.zeros(len(grid.nodes), bool)
    touched[grid.elements[filled]] = True
    floating = np.flatnonzero(~touched)
    area = np.bincount(rows.element, rows.volume * _volume_ratio(rows), len(grid.elements))
    fill = area / grid.areas
    loading = motion.loading
    force = loading.force - loading.own_weight
    place = motion.triangle.copy()
    astray = np.flatnonzero(motion.smoothed) if not _is_fixed(body) else np.arange(len(place))
    if motion.resets and astray.size:
        place[astray] = locate(grid, motion.tracers[astray], place[astray])
        if (place < 0).any():
            x, y = motion.tracers[np.argmin(place)]
            raise SolveError(
                f"the body has left the grid at ({x:.6g}, {y:.6g}) mm; make updated.margin larger"
            )
    # Beyond the last triangle with material the field of that goes on.
    motion = replace(motion, triangle=place, carrier=nearest_filled(grid, filled)[place])
    if _is_fixed(body):
        force = _spread(grid, motion, force)
        nothing = np.zeros_like(grid.nodes)
        loading = replace(
            loading,
            prescribed=np.zeros(nothing.shape, bool),
            displacement=nothing,
            boundaries={},
            loose=np.zeros((0, 1, 2)),
            node_area=np.ones((1, 1)),
        )
    motion = replace(motion, springs=_springs(body, motion, fill))
    own_weight = np.zeros_like(force)
    if loading.body_force.any():
        shape = basis.basis_values(grid.nodes, grid.elements, rows.element, rows.position)
        own_weight = assembly.body_force(
            grid.elements, len(grid.nodes), rows.element, shape, rows.volume, loading.body_force
        )
    loading = replace(loading, force=force + own_weight, own_weight=own_weight)
    return replace(
        body,
        motion=replace(motion, fill=_least_fill(grid, fill)),
        loading=hold_nodes(loading, floating),
        empty_elements=_holes(grid, motion, rows.element),
        floating_nodes=len(floating),
    )


def _least_fill(grid: Grid, fill: Floats) -> float:
    """Return the least fill of a triangle with material that has such on all sides."""
    beside = np.where(grid.twins >= 0, fill[grid.twins // 3], 0.0)
    inside = (fill > 0.0) & (beside > 0.0).all(axis=1)
    return float(fill[inside].min(initial=1.0))


def _holes(grid: Grid, motion: Motion, element: Ints) -> int:
    """Count the triangles inside the body with fewer points than were seeded in each.

    One point gives a T3 its stiffness, and three a T6; what is missing is a mechanism.
    """
    seeded = np.bincount(motion.element).max()
    hollow = np.flatnonzero(np.bincount(element, minlength=len(grid.elements)) < seeded)
    middle = grid.nodes[grid.triangles[hollow]].mean(axis=1)
    material = replace(motion.reference, nodes=motion.tracers)
    return int((locate(material, middle) >= 0).sum())


def _spread(grid: Grid, motion: Motion, force: Floats) -> Floats:
    """Put forces on the tracers onto the nodes of the grid around them."""
    loaded = np.flatnonzero(force.any(axis=1))
    carrier, position = motion.carrier[loaded], motion.tracers[loaded]
    shape = basis.basis_values(grid.nodes, grid.elements, carrier, position)
    on_nodes = np.zeros_like(grid.nodes)
    np.add.at(on_nodes, grid.elements[carrier], shape[:, :, None] * force[loaded][:, None])
    return on_nodes


def _springs(body: Body, motion: Motion, fill: Floats) -> Springs | None:
    """Hold the tracers in a fixed grid, and stabilise what holds little material."""
    grid, loading, held = body.grid, motion.loading, None
    modulus = _largest_modulus(body)
    if _is_fixed(body):
        tracer, axis = np.nonzero(loading.prescribed)
        held = supports(
            grid,
            motion.carrier[tracer],
            motion.tracers[tracer],
            axis,
            STIFFNESS * modulus,
            motion.displacement[tracer, axis],
            loading.displacement[tracer, axis],
        )
    weight = body.scene.updated.ghost * modulus
    return join(held, ghost(grid, fill, LITTLE, weight) if weight else None)


def _are_filled(grid: Grid, element: Ints) -> NDArray[np.bool_]:
    filled = np.zeros(len(grid.elements), bool)
    filled[element] = True
    return filled


def _volume_ratio(points: MaterialPoints) -> Floats:
    h = points.displacement_gradient
    det = h[:, 0, 0] * h[:, 1, 1] - h[:, 0, 1] * h[:, 1, 0]
    return 1.0 + h[:, 0, 0] + h[:, 1, 1] + det
