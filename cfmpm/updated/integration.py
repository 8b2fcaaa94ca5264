"""Integration over material points on a grid that is reset."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cfmpm.body import particle_domains
from cfmpm.body.grid import Floats, Grid, signed_areas
from cfmpm.body.motion import Motion, interpolate
from cfmpm.body.points import DeformedPoints, MaterialPoints
from cfmpm.errors import SolveError
from cfmpm.kernels import clipping

# Largest fraction of a particle domain that may lie outside the grid, for round-off.
LOST = 1e-6


def moved_points(points: DeformedPoints, grid: Grid, displacement: Floats) -> DeformedPoints:
    """Move points with the displacement of the grid."""
    by = interpolate(grid, displacement, points.element, points.position)
    return replace(points, position=points.position + by)


def clipped(
    motion: Motion, points: MaterialPoints, grid: Grid, *, fixed: bool
) -> particle_domains.Quadrature:
    """Intersect the current particle domains with the triangles of the grid.

    A domain is the straight-sided triangle of the three tracers at the corners of the point's
    initial triangle. The reference volume of a point is distributed over the intersections in
    proportion to their current area. Triangles that still coincide with their domain are not
    clipped.
    """
    domains = particle_domains.triangular_domains(motion.tracers[motion.reference.triangles])
    whole: NDArray[np.bool_] = np.zeros(len(grid.elements), bool)
    owners = np.arange(len(points))
    if not fixed:
        whole = ~np.any(motion.smoothed[grid.triangles], axis=1)
        owners = np.flatnonzero(~whole)
    owner, element, position, area = clipping.clip_domains(
        grid.nodes,
        grid.elements,
        grid.element.points,
        grid.element.weights,
        np.flatnonzero(~whole),
        domains.anchors,
        domains.vertices,
        domains.offsets,
        owners,
    )
    found = np.bincount(owner, area, len(points))
    whole_area = signed_areas(domains.vertices.reshape(-1, 3, 2))
    lost = np.flatnonzero(~(found >= (1.0 - LOST) * whole_area) | ~(whole_area > 0.0))
    lost = np.intersect1d(lost, owners)
    if lost.size:
        x, y = points.position[lost[0]]
        raise SolveError(
            f"{lost.size} particle domains are inverted or have left the grid, the first at "
            f"({x:.6g}, {y:.6g}) mm; increase updated.margin, or use updated.grid: following "
            "(linear triangles only, mesh.element: T3)"
        )
    volume = points.volume[owner] * area / found[owner]
    kept = np.flatnonzero(whole)
    order = np.argsort(np.concatenate([kept, element]), kind="stable")
    return particle_domains.Quadrature(
        owner=np.concatenate([kept, owner])[order],
        element=np.concatenate([kept, element])[order],
        position=np.concatenate([points.position[kept], position])[order],
        volume=np.concatenate([points.volume[kept], volume])[order],
        material=points.material[np.concatenate([kept, owner])[order]],
    )


def with_state(quadrature: particle_domains.Quadrature, points: DeformedPoints) -> DeformedPoints:
    """Give each quadrature point the state of its material point."""
    own = particle_domains.as_points(quadrature)
    owner = quadrature.owner
    return own.deformed(
        points.displacement_gradient[owner],
        points.stress[owner],
        points.energy[owner],
        points.internal_variables[owner],
    )


def volume_ratio(displacement_gradient: Floats) -> Floats:
    """Return det F, (p,)."""
    h = displacement_gradient
    det = h[:, 0, 0] * h[:, 1, 1] - h[:, 0, 1] * h[:, 1, 0]
    return 1.0 + h[:, 0, 0] + h[:, 1, 1] + det
