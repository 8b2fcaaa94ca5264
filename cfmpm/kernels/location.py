"""Location of points in the grid: walk over adjacent triangles, and search in a bucket grid.

The search is used for points without a known triangle nearby, and where a crack or the boundary
blocks the walk. Both replace the search over all triangles of the paper (section 2.3).
"""

from __future__ import annotations

import numpy as np

from cfmpm._jit import kernel
from cfmpm.kernels.basis import area_coordinates

OUTSIDE = -1
_ROUND_OFF = 16.0 * 2.220446049250313e-16


@kernel
def containment(nodes, element, position):
    """Return the smallest area coordinate of a point in a triangle, with its round-off.

    Parameters
    ----------
    nodes : (n, 2) float
        [mm].
    element : (k,) int
        Nodes of the triangle, the three corners first.
    position : (2,) float
        [mm].

    Returns
    -------
    lowest : float
        Smallest area coordinate; the point is in the triangle if lowest >= -round_off.
    corner : int
        Corner (0, 1, 2) to which it belongs.
    round_off : float
        Bound on its round-off.
    """
    l0, l1, l2, g = area_coordinates(nodes, element, position)
    lowest, corner = l0, 0
    if l1 < lowest:
        lowest, corner = l1, 1
    if l2 < lowest:
        lowest, corner = l2, 2
    reach = abs(position[0]) + abs(position[1])
    steepest = 0.0
    for value in g:
        steepest = max(steepest, abs(value))
    return lowest, corner, _ROUND_OFF * (1.0 + reach * steepest)


@kernel
def walk(nodes, triangles, twins, start, position):
    """Walk from a triangle to the one that contains a point, never across a crack.

    Parameters
    ----------
    nodes : (n, 2) float
        [mm].
    triangles : (m, 3) int
        Corners of each triangle.
    twins : (m, 3) int
        Half-edge across each side, from `topology.find_twins`; -1 at boundaries and crack faces.
    start : int
        Triangle at which the walk starts.
    position : (2,) float
        [mm].

    Returns
    -------
    int
        The triangle; `OUTSIDE` if a crack or the boundary blocks the walk.
    """
    current = start
    came_from = -1
    for _ in range(100 + 10 * int(np.sqrt(triangles.shape[0]))):
        lowest, corner, round_off = containment(nodes, triangles[current], position)
        if lowest >= -round_off:
            return current
        following = twins[current, (corner + 1) % 3]
        if following < 0 or following // 3 == came_from:
            # This side is blocked: take another side that separates the triangle from the point.
            l0, l1, l2, _ = area_coordinates(nodes, triangles[current], position)
            following = -1
            for side, value in ((1, l0), (2, l1), (0, l2)):
                if side != (corner + 1) % 3 and value < -round_off:
                    following = twins[current, side]
            if following < 0 or following // 3 == came_from:
                return OUTSIDE
        came_from = current
        current = following // 3
    return OUTSIDE


@kernel
def walk_from_hints(nodes, triangles, twins, hints, position):
    """Locate every point by a walk from its hint.

    Parameters
    ----------
    nodes, triangles, twins
        As in `walk`.
    hints : (p,) int
        Triangle at which each walk starts.
    position : (p, 2) float
        [mm].

    Returns
    -------
    (p,) int
        The triangle of each point; `OUTSIDE` where the walk is blocked.
    """
    found = np.empty(position.shape[0], np.int64)
    for p in range(position.shape[0]):
        found[p] = walk(nodes, triangles, twins, hints[p], position[p])
    return found


@kernel
def cell_range(low, high, origin, size, count):
    """Return the first and the last cell that overlap the interval, clipped to 0 ... count - 1."""
    first = int(min(max((low - origin) / size, 0.0), count - 1.0))
    last = int(min(max((high - origin) / size, 0.0), count - 1.0))
    return first, last


@kernel
def fill_buckets(nodes, triangles, origin, size, shape):
    """List the triangles whose bounding box overlaps each cell of a bucket grid.

    Parameters
    ----------
    nodes : (n, 2) float
        [mm].
    triangles : (m, 3) int
        Corners of each triangle.
    origin, size : (2,) float
        Lower left corner and cell size of the bucket grid [mm].
    shape : (2,) int
        Number of cells in x and y.

    Returns
    -------
    offsets : (cells + 1,) int
    items : (entries,) int
        The triangles of cell c = i * shape[1] + j are ``items[offsets[c]:offsets[c + 1]]``.
    """
    offsets = np.zeros(shape[0] * shape[1] + 1, np.int64)
    items = np.empty(0, np.int64)
    fill = offsets[:-1].copy()
    for counting in (True, False):
        for t in range(triangles.shape[0]):
            a, b, c = nodes[triangles[t, 0]], nodes[triangles[t, 1]], nodes[triangles[t, 2]]
            i0, i1 = cell_range(
                min(a[0], b[0], c[0]), max(a[0], b[0], c[0]), origin[0], size[0], shape[0]
            )
            j0, j1 = cell_range(
                min(a[1], b[1], c[1]), max(a[1], b[1], c[1]), origin[1], size[1], shape[1]
            )
            for i in range(i0, i1 + 1):
                for j in range(j0, j1 + 1):
                    cell = i * shape[1] + j
                    if counting:
                        offsets[cell + 1] += 1
                    else:
                        items[fill[cell]] = t
                        fill[cell] += 1
        if counting:
            for cell in range(len(offsets) - 1):
                offsets[cell + 1] += offsets[cell]
            fill = offsets[:-1].copy()
            items = np.empty(offsets[-1], np.int64)
    return offsets, items


@kernel
def search_buckets(nodes, triangles, twins, origin, size, shape, offsets, items, hints, position):
    """Locate every point among the triangles of its cell.

    A point on a crack is located on the same side of the crack as its hint.

    Parameters
    ----------
    nodes, triangles, twins
        As in `walk`.
    origin, size, shape, offsets, items
        As in `fill_buckets`.
    hints : (p,) int
        A triangle near each point; -1 for none.
    position : (p, 2) float
        [mm].

    Returns
    -------
    (p,) int
        The triangle of each point; `OUTSIDE` for points that no triangle contains.
    """
    found = np.full(position.shape[0], OUTSIDE, np.int64)
    for p in range(position.shape[0]):
        x = position[p]
        if not (np.isfinite(x[0]) and np.isfinite(x[1])):
            continue
        i, _ = cell_range(x[0], x[0], origin[0], size[0], shape[0])
        j, _ = cell_range(x[1], x[1], origin[1], size[1], shape[1])
        cell = i * shape[1] + j
        first, last = offsets[cell], offsets[cell + 1]
        if hints[p] < 0:
            if first == last:
                continue
            # A walk is faster than the list where a cell holds many triangles of a graded grid.
            found[p] = walk(nodes, triangles, twins, items[(first + last) // 2], x)
            if found[p] >= 0:
                continue
        towards = x.copy()
        if hints[p] >= 0:
            for corner in triangles[hints[p]]:
                towards += 1e-6 / 3.0 * (nodes[corner] - x)
        best = -np.inf
        for n in range(first, last):
            lowest, _, round_off = containment(nodes, triangles[items[n]], x)
            if lowest < -round_off:
                continue
            preference = lowest
            if hints[p] >= 0:
                preference, _, _ = containment(nodes, triangles[items[n]], towards)
            if preference > best:
                best = preference
                found[p] = items[n]
    return found
