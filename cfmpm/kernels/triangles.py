"""Quality of the shape of triangles."""

from __future__ import annotations

import math

import numpy as np

from cfmpm._jit import kernel


@kernel
def quality(ax, ay, bx, by, cx, cy):
    """Return 4 sqrt(3) area / (sum of the squared sides) of a triangle.

    Parameters
    ----------
    ax, ay, bx, by, cx, cy : float
        Corners of the triangle.

    Returns
    -------
    float
        1 for an equilateral triangle, 0 for a degenerate one, negative for a clockwise one.
    """
    ux, uy = bx - ax, by - ay
    vx, vy = cx - ax, cy - ay
    wx, wy = cx - bx, cy - by
    squares = (ux * ux + uy * uy) + (wx * wx + wy * wy) + (vx * vx + vy * vy)
    return 2.0 * math.sqrt(3.0) * (ux * vy - uy * vx) / squares


@kernel
def triangle_quality(nodes, triangles):
    """Return the `quality` of each triangle.

    Parameters
    ----------
    nodes : (n, 2) float
        [mm].
    triangles : (m, 3) int
        Corners of each triangle.

    Returns
    -------
    (m,) float
    """
    found = np.empty(len(triangles))
    for t in range(len(triangles)):
        a, b, c = nodes[triangles[t, 0]], nodes[triangles[t, 1]], nodes[triangles[t, 2]]
        found[t] = quality(a[0], a[1], b[0], b[1], c[0], c[1])
    return found
