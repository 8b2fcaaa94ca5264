"""Point location: a walk over neighbours, and a bucket grid where there is no start or no way."""

from __future__ import annotations

import numpy as np

from cfmpm._jit import kernel
from cfmpm.kernels.basis import area_coordinates

OUTSIDE = -1
_ROUND_OFF = 16.0 * 2.220446049250313e-16


@kernel
def containment(nodes, element, position):
    """Return the smallest area coordinate of a point, its corner, and its round-off.

    The point is in the triangle where the first is not below minus the last.
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
    """Walk from a triangle to the one that holds a point, never across a crack.

    Parameters
    ----------
    nodes : (n, 2) float
    triangles, twins : (m, 3) int
    start : int
    position : (2,) float

    Returns
    -------
    int
        The triangle, or `OUTSIDE` where the way is blocked by a crack or by the boundary.
    """
    current = start
    came_from = -1
    for _ in range(100 + 10 * int(np.sqrt(triangles.shape[0]))):
        lowest, corner, round_off = containment(nodes, triangles[current], position)
        if lowest >= -round_off:
            return current
        following = twins[current, (corner + 1) % 3]
        if following < 0 or following // 3 == came_from:
            # Blocked across the nearest side: try the other side that has the point behind it.
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
    """Walk to every point from its hint; `OUTSIDE` where blocked. (p,) int."""
    found = np.empty(position.shape[0], np.int64)
    for p in range(position.shape[0]):
        found[p] = walk(nodes, triangles, twins, hints[p], position[p])
    return found


@kernel
def cell_range(low, high, origin, size, count):
    """Return the first and the last cell that an interval touches, clipped to the buckets."""
    first = int(min(max((low - origin) / size, 0.0), count - 1.0))
    last = int(min(max((high - origin) / size, 0.0), count - 1.0))
    return first, last


@kernel
def fill_buckets(nodes, triangles, origin, size, shape):
    """List the triangles whose bounding box touches each cell of a regular grid.

    Parameters
    ----------
    nodes : (n, 2) float
    triangles : (m, 3) int
    origin, size : (2,) float
        Lower left corner and cell size [mm].
    shape : (2,) int
        Number of cells.

    Returns
    -------
    offsets : (cells + 1,) int
    items : (entries,) int
        Triangles of cell (i, j) from ``offsets[i * shape[1] + j]``.
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
    """Find the triangle of every point through its cell.

    Where a point lies on a crack, the face on the side of the hint is taken.

    Parameters
    ----------
    nodes, triangles, twins
        As in `walk`.
    origin, size, shape, offsets, items
        As in `fill_buckets`.
    hints : (p,) int
        A triangle near each point, or -1.
    position : (p, 2) float

    Returns
    -------
    (p,) int
        `OUTSIDE` for points that no triangle holds.
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
            # The middle of the list spares a strongly graded cell most of the way.
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
