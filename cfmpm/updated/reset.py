"""The updated Lagrangian formulation: a grid that is reset after every load step (paper step 9).

The state of a material point is its displacement gradient H_n at the last reset of the grid. On the
current grid dS/dX = F_n^T dS/dx with F_n = I + H_n and the spatial position x, so that the sums of
`kernels.finite` over reference volumes hold unchanged, with H_n as their base. This is equivalent
to the paper's eqs 9 to 13.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from cfmpm.body import particle_domains
from cfmpm.body.body import Body, locate
from cfmpm.body.grid import Floats
from cfmpm.body.motion import Motion, Reset
from cfmpm.body.points import MaterialPoints
from cfmpm.body.volume_patches import build_patches, paired_triangles
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.scene import Scene
from cfmpm.updated.grids import (
    a_triangle_of_each,
    everywhere,
    followed,
    with_margin,
)
from cfmpm.updated.integration import clipped, moved_points, with_state
from cfmpm.updated.loads import (
    load_grid,
)

LEFT = "increase updated.margin, unless points have separated from the body (empty_elements)"


def begin(body: Body, scene: Scene) -> Body:
    """Prepare a new body for resets of its grid.

    Parameters
    ----------
    body : Body
        With undeformed points at their initial positions.
    scene : Scene
        Expanded.

    Returns
    -------
    Body
        Its triangles keep their numbers; a fixed grid has an additional margin.

    Raises
    ------
    MeshError
        If the margin cannot be meshed.
    """
    grid, points = body.grid, body.points
    settings = scene.updated
    how = Reset(
        fixed=settings.grid == "fixed",
        by_domains=settings.integration == "domains",
        smooth_below=settings.smooth_below,
        ghost=settings.ghost,
    )
    motion = Motion(
        reset=how,
        reference=grid,
        loading=body.loading,
        position=points.position,
        element=points.element,
        gradients=grid.basis_gradients(points.element, points.position),
        displacement=np.zeros_like(grid.nodes),
        triangle=a_triangle_of_each(grid),
        carrier=a_triangle_of_each(grid),
        base=np.zeros((len(points), 2, 2)),
        smoothed=np.zeros(len(grid.nodes), bool),
        forces=(),
        resets=0,
        fill=1.0,
    )
    if how.fixed:
        patches, grid = body.patches, with_margin(body, scene)
        if patches is not None:
            # No patch crosses the boundary of the body, so that those of the reference remain.
            margin = np.full(len(grid.elements), len(grid.region_names))
            margin[: len(motion.reference.elements)] = motion.reference.regions
            padded = replace(grid, regions=margin)
            patches = build_patches(padded, paired_triangles(padded, patches.of_triangle))
        body = replace(body, grid=grid, patches=patches)
    return load_grid(body, motion)


def reset(body: Body, balance: Equilibrium) -> tuple[Body, Equilibrium]:
    """Update the positions of the points, and reset the grid (paper step 9).

    Parameters
    ----------
    body : Body
        In equilibrium.
    balance : Equilibrium

    Returns
    -------
    body : Body
    balance : Equilibrium
        Start of the next load step: zero displacement of the grid, at the same load factor.

    Raises
    ------
    SolveError
        If points have left the grid, or the grid cannot be smoothed.
    """
    motion, old = body.motion, body.grid
    assert motion is not None
    moved = everywhere(body, balance.displacement)
    traced = motion.traced(old, moved)
    grid, smoothed, changed = old, motion.smoothed, True
    if not motion.reset.fixed:
        grid, smoothed, changed = followed(body, traced, moved)
    motion = replace(motion, displacement=traced, smoothed=smoothed, resets=motion.resets + changed)
    points, quadrature = body.points, body.quadrature
    rows = moved_points(balance.points, old, moved)
    if not motion.reset.by_domains:
        points = replace(points, position=rows.position)
    else:
        corners = motion.tracers[motion.reference.triangles]
        points = replace(points, position=corners.mean(axis=1))
        if changed:
            carried = particle_domains.means(points, quadrature, balance.points)
            quadrature = clipped(motion, points, grid, fixed=motion.reset.fixed)
            rows = with_state(quadrature, carried)
        elif quadrature is None:
            points = replace(points, position=rows.position)
        else:
            quadrature = replace(quadrature, position=rows.position)
    body = locate(replace(body, grid=grid, points=points, quadrature=quadrature), LEFT)
    motion = replace(motion, base=rows.displacement_gradient)
    nothing = np.zeros_like(grid.nodes)
    return load_grid(body, motion), replace(
        balance,
        points=replace(rows, element=body.integration.element),
        displacement=nothing,
        internal_force=nothing,
        contact_force=nothing,
    )


def restore(
    body: Body,
    nodes: Floats,
    points: MaterialPoints,
    quadrature: particle_domains.Quadrature | None,
    kept: dict[str, Any],
) -> Body:
    """Restore the state of a body at its last reset.

    Parameters
    ----------
    body : Body
        From `begin`.
    nodes : (m, 2) float
        Nodes of the grid after the last reset [mm].
    points : MaterialPoints
    quadrature : particle_domains.Quadrature or None
    kept : dict
        Fields of `Motion`: `displacement`, `triangle`, `base`, `smoothed` and `resets`.

    Returns
    -------
    Body
    """
    motion = body.motion
    assert motion is not None
    grid = replace(body.grid, nodes=nodes)
    body = replace(body, grid=grid, points=points, quadrature=quadrature)
    return load_grid(body, replace(motion, **kept))
