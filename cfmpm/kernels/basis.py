"""Basis functions of straight-sided T3 and T6 triangles and their gradients at points."""

from __future__ import annotations

import numpy as np

from cfmpm._jit import kernel


@kernel
def area_coordinates(nodes, element, position):
    """Return the area coordinates of a point in a triangle and their gradients.

    Parameters
    ----------
    nodes : (n, 2) float
    element : (3 or more,) int
        Corner nodes first.
    position : (2,) float

    Returns
    -------
    l0, l1, l2 : float
    g : tuple of six floats
        d l0/dx, d l0/dy, d l1/dx ... [1/mm].
    """
    ax, ay = nodes[element[0], 0], nodes[element[0], 1]
    bx, by = nodes[element[1], 0] - ax, nodes[element[1], 1] - ay
    cx, cy = nodes[element[2], 0] - ax, nodes[element[2], 1] - ay
    px, py = position[0] - ax, position[1] - ay
    scale = 1.0 / (bx * cy - by * cx)
    g1x, g1y = cy * scale, -cx * scale
    g2x, g2y = -by * scale, bx * scale
    l1 = g1x * px + g1y * py
    l2 = g2x * px + g2y * py
    return 1.0 - l1 - l2, l1, l2, (-g1x - g2x, -g1y - g2y, g1x, g1y, g2x, g2y)


@kernel
def basis_values(nodes, elements, point_element, position):
    """Evaluate the basis functions at points.

    Parameters
    ----------
    nodes : (n, 2) float
    elements : (m, k) int
        k = 3 or 6.
    point_element : (p,) int
    position : (p, 2) float

    Returns
    -------
    (p, k) float
    """
    k = elements.shape[1]
    values = np.empty((len(point_element), k))
    for p in range(len(point_element)):
        l0, l1, l2, _ = area_coordinates(nodes, elements[point_element[p]], position[p])
        if k == 3:
            values[p, 0] = l0
            values[p, 1] = l1
            values[p, 2] = l2
        else:
            values[p, 0] = l0 * (2.0 * l0 - 1.0)
            values[p, 1] = l1 * (2.0 * l1 - 1.0)
            values[p, 2] = l2 * (2.0 * l2 - 1.0)
            values[p, 3] = 4.0 * l0 * l1
            values[p, 4] = 4.0 * l1 * l2
            values[p, 5] = 4.0 * l2 * l0
    return values


@kernel
def basis_gradients(nodes, elements, point_element, position):
    """Evaluate the gradients of the basis functions at points.

    Parameters
    ----------
    nodes : (n, 2) float
    elements : (m, k) int
        k = 3 or 6.
    point_element : (p,) int
    position : (p, 2) float

    Returns
    -------
    (p, k, 2) float
        dS_I/dX_j [1/mm].
    """
    k = elements.shape[1]
    gradients = np.empty((len(point_element), k, 2))
    for p in range(len(point_element)):
        l0, l1, l2, g = area_coordinates(nodes, elements[point_element[p]], position[p])
        out = gradients[p]
        if k == 3:
            for j in range(2):
                out[0, j] = g[j]
                out[1, j] = g[2 + j]
                out[2, j] = g[4 + j]
        else:
            for j in range(2):
                g0, g1, g2 = g[j], g[2 + j], g[4 + j]
                out[0, j] = (4.0 * l0 - 1.0) * g0
                out[1, j] = (4.0 * l1 - 1.0) * g1
                out[2, j] = (4.0 * l2 - 1.0) * g2
                out[3, j] = 4.0 * (l0 * g1 + l1 * g0)
                out[4, j] = 4.0 * (l1 * g2 + l2 * g1)
                out[5, j] = 4.0 * (l2 * g0 + l0 * g2)
    return gradients
