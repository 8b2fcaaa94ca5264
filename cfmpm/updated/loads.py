"""Loads and supports on a grid that is reset."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from cfmpm.body.body import Body
from cfmpm.body.grid import Floats, Grid, Ints
from cfmpm.body.loads import NodalLoads, hold_nodes
from cfmpm.body.motion import Motion
from cfmpm.body.points import locate
from cfmpm.body.rigid_motions import Holds
from cfmpm.body.springs import Springs, ghost, supports
from cfmpm.errors import SolveError
from cfmpm.kernels import assembly
from cfmpm.updated import tracers
from cfmpm.updated.grids import (
    are_filled,
)
from cfmpm.updated.integration import volume_ratio

# Stiffness of the springs of a support in a fixed grid, over the largest Young's modulus.
STIFFNESS = 1e4
# Filled fraction of a triangle below which it is stabilised (design study).
LITTLE = 0.6


def largest_modulus(body: Body) -> float:
    return float(body.materials.E.max())


def load_grid(body: Body, motion: Motion) -> Body:
    """Find the part of the grid with material, and apply loads and supports to it."""
    grid, rows = body.grid, body.integration
    filled = are_filled(grid, rows.element)
    touched = np.zeros(len(grid.nodes), bool)
    touched[grid.elements[filled]] = True
    floating = np.flatnonzero(~touched)
    area = np.bincount(rows.element, rows.volume * volume_ratio(motion.base), len(grid.elements))
    fill = area / grid.areas
    loading = motion.loading
    if motion.reset.fixed and not loading.is_proportional:
        raise SolveError(
            "fixed loads are not available with updated.grid: fixed; use grid: following"
        )
    place = motion.triangle.copy()
    astray = np.flatnonzero(motion.smoothed) if not motion.reset.fixed else np.arange(len(place))
    if motion.resets and astray.size:
        place[astray] = tracers.placed(grid, motion, astray)
        if (place < 0).any():
            x, y = motion.tracers[np.argmin(place)]
            raise SolveError(
                f"the body has left the grid at ({x:.6g}, {y:.6g}) mm; increase updated.margin"
            )
    # Beyond the triangles with material the field of the nearest one is extrapolated.
    motion = replace(motion, triangle=place)
    motion = replace(motion, carrier=tracers.carriers(grid, motion, filled))
    if motion.reset.fixed:
        loading = replace(
            loading,
            prescribed=np.zeros(grid.nodes.shape, bool),
            boundaries={},
            holds=Holds.none(),
            loose=np.zeros((0, 1, 2)),
            node_area=np.ones((1, 1)),
        )
    motion = replace(motion, forces=tuple(_springs(body, motion, fill)))
    loading = replace(
        loading,
        proportional=_on_grid(body, motion, loading.proportional),
        fixed=None if loading.fixed is None else _on_grid(body, motion, loading.fixed),
    )
    return replace(
        body,
        motion=replace(motion, fill=_least_fill(grid, fill)),
        loading=hold_nodes(loading, floating),
        empty_elements=_holes(grid, motion, rows.element),
        floating_nodes=len(floating),
    )


def _on_grid(body: Body, motion: Motion, loads: NodalLoads) -> NodalLoads:
    """Transfer loads at the nodes of the reference grid to the current grid."""
    grid, rows = body.grid, body.integration
    force, displacement = loads.force - loads.own_weight, loads.displacement
    if motion.reset.fixed:
        # Prescribed displacements are applied by springs.
        force, displacement = _spread(grid, motion, force), np.zeros_like(grid.nodes)
    own_weight = np.zeros_like(force)
    if loads.body_force.any():
        shape = grid.basis_values(rows.element, rows.position)
        own_weight = assembly.body_force(
            grid.elements, len(grid.nodes), rows.element, shape, rows.volume, loads.body_force
        )
    return NodalLoads(force + own_weight, displacement, own_weight, loads.body_force)


def _least_fill(grid: Grid, fill: Floats) -> float:
    """Smallest filled fraction of the triangles whose neighbours all contain material."""
    beside = np.where(grid.twins >= 0, fill[grid.twins // 3], 0.0)
    inside = (fill > 0.0) & (beside > 0.0).all(axis=1)
    return float(fill[inside].min(initial=1.0))


def _holes(grid: Grid, motion: Motion, element: Ints) -> int:
    """Count the triangles inside the body with fewer points than initially.

    T3 needs one point for its stiffness, T6 three; with fewer it is a mechanism.
    """
    seeded = len(grid.element.points)
    hollow = np.flatnonzero(np.bincount(element, minlength=len(grid.elements)) < seeded)
    middle = grid.nodes[grid.triangles[hollow]].mean(axis=1)
    material = replace(motion.reference, nodes=motion.tracers)
    return int((locate(material, middle) >= 0).sum())


def _spread(grid: Grid, motion: Motion, force: Floats) -> Floats:
    """Distribute forces on the tracers to the grid nodes by the basis functions."""
    loaded = np.flatnonzero(force.any(axis=1))
    carrier, position = motion.carrier[loaded], motion.tracers[loaded]
    shape = grid.basis_values(carrier, position)
    on_nodes = np.zeros_like(grid.nodes)
    np.add.at(on_nodes, grid.elements[carrier], shape[:, :, None] * force[loaded][:, None])
    return on_nodes


def _springs(body: Body, motion: Motion, fill: Floats) -> Iterator[Springs]:
    """Springs that hold the tracers in a fixed grid, and those that stabilise small fills."""
    grid, loading = body.grid, motion.loading
    modulus = largest_modulus(body)
    if motion.reset.fixed:
        tracer, axis = np.nonzero(loading.prescribed)
        yield supports(
            grid,
            motion.carrier[tracer],
            motion.tracers[tracer],
            axis,
            STIFFNESS * modulus,
            motion.displacement[tracer, axis],
            loading.proportional.displacement[tracer, axis],
        )
    weight = motion.reset.ghost * modulus
    stabilisation = ghost(grid, fill, LITTLE, weight) if weight else None
    if stabilisation is not None:
        yield stabilisation
