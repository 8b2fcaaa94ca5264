"""Refinement around a tip by bisection of longest edges."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.grid import Floats, Ints, Triangulation, signed_areas
from cfmpm.fracture.release import split_side
from cfmpm.kernels import topology

# Increase of the element size per distance from the tip, as in a graded grid.
GROWTH = 0.3
EQUILATERAL = 0.25 * np.sqrt(3.0)


def refine(mesh: Triangulation, at: Floats, size: float) -> tuple[Triangulation, Ints]:
    """Bisect triangles until their size is at most size + 0.3 r at distance r from a point.

    Parameters
    ----------
    mesh : Triangulation
    at : (2,) float
        The tip [mm].
    size : float
        Largest element size at the tip: side of the equilateral triangle of equal area [mm].

    Returns
    -------
    Triangulation
        One part of each bisected triangle keeps its number; the others are appended. Existing
        nodes, boundary, cracks and regions are kept; their edges get midpoints.
    changed : (k,) int
        The parts, ascending.

    Notes
    -----
    A triangle is bisected at its longest edge only together with the neighbour whose longest edge
    this is as well; otherwise that neighbour is bisected first (Rivara 1997). The smallest angle
    stays above half of its initial value.
    """
    changed: set[int] = set()
    distance, too_large = _rated(mesh.nodes[mesh.triangles], at, size)
    while too_large.any():
        nearest = int(np.argmin(np.where(too_large, distance, np.inf)))
        stars = topology.node_stars(mesh.triangles, len(mesh.nodes))
        mesh, parts = split_side(mesh, stars, _last_longest_edge(mesh, stars, nearest), 0.5)
        changed |= set(parts.tolist())
        # Only the parts have changed: the others keep their distance and size.
        added = len(mesh.triangles) - len(distance)
        distance = np.append(distance, np.empty(added))
        too_large = np.append(too_large, np.empty(added, bool))
        distance[parts], too_large[parts] = _rated(mesh.nodes[mesh.triangles[parts]], at, size)
    return mesh, np.array(sorted(changed), np.int64)


def _rated(corners: Floats, at: Floats, size: float) -> tuple[Floats, NDArray[np.bool_]]:
    """Distance of triangles from the tip [mm], and whether they are too large for it.

    Parameters
    ----------
    corners : (k, 3, 2) float
        [mm].
    at, size
        As in `refine`.

    Returns
    -------
    distance : (k,) float
    too_large : (k,) bool
    """
    own = np.sqrt(signed_areas(corners) / EQUILATERAL)
    distance = np.hypot(*(corners.mean(axis=1) - at).T)
    return distance, own > size + GROWTH * distance


def _last_longest_edge(
    mesh: Triangulation, stars: tuple[Ints, Ints], triangle: int
) -> tuple[int, int]:
    """Follow longest edges between triangles to an edge that is the longest on both sides."""
    while True:
        corners = mesh.triangles[triangle]
        lengths = np.hypot(*(mesh.nodes[np.roll(corners, -1)] - mesh.nodes[corners]).T)
        side = int(np.argmax(lengths))
        pair = int(corners[side]), int(corners[(side + 1) % 3])
        twin = topology.find_half_edge(mesh.triangles, *stars, pair[1], pair[0])
        if twin < 0:
            return pair
        triangle = int(twin) // 3
        across = mesh.triangles[triangle]
        longest = np.hypot(*(mesh.nodes[np.roll(across, -1)] - mesh.nodes[across]).T).max()
        if longest <= lengths[side] * (1.0 + 1e-12):
            return pair
