"""The grids of the updated formulation: fixed with a margin, or following the material."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.body import Body
from cfmpm.body.grid import Floats, Grid, Ints, build_grid
from cfmpm.body.motion import Motion, interpolate, nearest_filled
from cfmpm.errors import SolveError
from cfmpm.kernels import smoothing, topology
from cfmpm.kernels.triangles import triangle_quality
from cfmpm.meshing import mesh_size
from cfmpm.meshing.margin import surround
from cfmpm.scene import Scene

# Largest number of smoothing sweeps over the nodes.
SWEEPS = 10
# Margin for motion beyond the prescribed displacements, as a fraction of the size of the body.
MARGIN = 0.05


def with_margin(body: Body, scene: Scene) -> Grid:
    """Put a margin around the grid of a body; tips keep their order."""
    reference = body.grid
    size = float(np.ptp(reference.nodes, axis=0).max())
    margin = scene.updated.margin
    if margin is None:
        levels = scene.load_steps if isinstance(scene.load_steps, list) else [1.0]
        reach = np.abs(body.loading.proportional.displacement).max() * np.abs(levels).max()
        margin = float(reach) + MARGIN * size
    grid = build_grid(
        surround(body.triangulation, margin, mesh_size(scene) or MARGIN * size),
        reference.element,
    )
    tips = {(tip.crack, tip.end): tip for tip in grid.tips}
    return replace(grid, tips=tuple(tips[tip.crack, tip.end] for tip in reference.tips))


def a_triangle_of_each(grid: Grid) -> Ints:
    """Return a triangle of each node."""
    found = np.empty(len(grid.nodes), np.int64)
    found[grid.elements] = np.arange(len(grid.elements))[:, None]
    return found


def everywhere(body: Body, displacement: Floats) -> Floats:
    """Extrapolate the displacement to nodes without material from the nearest filled triangle."""
    grid = body.grid
    filled = are_filled(grid, body.integration.element)
    if filled.all() or (body.motion is not None and body.motion.reset.fixed):
        return displacement
    touched = np.zeros(len(grid.nodes), bool)
    touched[grid.elements[filled]] = True
    floating = np.flatnonzero(~touched)
    nearest = nearest_filled(grid, filled)[a_triangle_of_each(grid)[floating]]
    displacement = displacement.copy()
    displacement[floating] = interpolate(grid, displacement, nearest, grid.nodes[floating])
    return displacement


def followed(body: Body, traced: Floats, moved: Floats) -> tuple[Grid, NDArray[np.bool_], bool]:
    """Move the grid with the material, and smooth triangles of low quality.

    Returns
    -------
    grid : Grid
    smoothed : (n,) bool
        Nodes that no longer coincide with their tracers.
    changed : bool
        Whether the grid was moved relative to the points.
    """
    motion, old = body.motion, body.grid
    assert motion is not None
    reference, smoothed = motion.reference, motion.smoothed
    nodes = np.where(smoothed[:, None], old.nodes + moved, reference.nodes + traced)
    triangles = np.ascontiguousarray(old.triangles)
    stars = topology.node_stars(triangles, len(nodes))
    free, least = ~bound(motion), motion.reset.smooth_below
    now = smoothing.smooth(nodes, triangles, stars[0], stars[1], free, least, SWEEPS)
    worst = triangle_quality(nodes, triangles)
    if not worst.min() > 0.0:
        raise SolveError(
            f"{int((~(worst > 0.0)).sum())} triangles of the grid are inverted, and smoothing did "
            "not correct them; use smaller load_steps, or a finer grid there"
        )
    return replace(old, nodes=nodes), smoothed | now, bool(now.any())


def bound(motion: Motion) -> NDArray[np.bool_]:
    """Return the nodes that must move with the material: boundary, cracks, interfaces, supports."""
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


def are_filled(grid: Grid, element: Ints) -> NDArray[np.bool_]:
    filled = np.zeros(len(grid.elements), bool)
    filled[element] = True
    return filled
