"""Lagrange basis functions of triangles with straight sides, and their gradients (paper eq 4).

Orders 1 and 2 have closed forms, which give bit by bit the values of the general form in a fifth of
its time.
"""

from __future__ import annotations

import numpy as np

from cfmpm._jit import kernel


@kernel
def area_coordinates(nodes, element, position):
    """Return the area coordinates of a point in a triangle, and their gradients.

    Parameters
    ----------
    nodes : (n, 2) float
        [mm].
    element : (k,) int
        Nodes of the element, the three corners first.
    position : (2,) float
        [mm].

    Returns
    -------
    l0, l1, l2 : float
        Area coordinates; their sum is one.
    g : tuple of six floats
        d l0/dx, d l0/dy, d l1/dx, d l1/dy, d l2/dx, d l2/dy [1/mm].
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
def basis_values(table, factors, nodes, elements, point_element, position):
    """Evaluate the basis functions at points.

    Parameters
    ----------
    table : (k, 3) int
        `Element.nodes` of an element of order p.
    factors : (p + 1, p + 1) float
        `Element.factors`.
    nodes : (n, 2) float
        [mm].
    elements : (m, k) int
        Nodes of each element.
    point_element : (q,) int
        Element of each point.
    position : (q, 2) float
        [mm].

    Returns
    -------
    (q, k) float
        S_I at each point.
    """
    values = np.empty((len(point_element), len(table)))
    if len(factors) == 2:
        for p in range(len(point_element)):
            l0, l1, l2, _ = area_coordinates(nodes, elements[point_element[p]], position[p])
            values[p, 0] = l0
            values[p, 1] = l1
            values[p, 2] = l2
    elif len(factors) == 3:
        for p in range(len(point_element)):
            l0, l1, l2, _ = area_coordinates(nodes, elements[point_element[p]], position[p])
            values[p, 0] = l0 * (2.0 * l0 - 1.0)
            values[p, 1] = l1 * (2.0 * l1 - 1.0)
            values[p, 2] = l2 * (2.0 * l2 - 1.0)
            values[p, 3] = 4.0 * l0 * l1
            values[p, 4] = 4.0 * l1 * l2
            values[p, 5] = 4.0 * l2 * l0
    else:
        lagrange_values(table, factors, nodes, elements, point_element, position, values)
    return values


@kernel
def basis_gradients(table, factors, nodes, elements, point_element, position):
    """Evaluate the gradients of the basis functions at points.

    Parameters
    ----------
    table, factors, nodes, elements, point_element, position
        As in `basis_values`.

    Returns
    -------
    (q, k, 2) float
        dS_I/dX_j [1/mm].
    """
    gradients = np.empty((len(point_element), len(table), 2))
    if len(factors) == 2:
        for p in range(len(point_element)):
            _, _, _, g = area_coordinates(nodes, elements[point_element[p]], position[p])
            out = gradients[p]
            for j in range(2):
                out[0, j] = g[j]
                out[1, j] = g[2 + j]
                out[2, j] = g[4 + j]
    elif len(factors) == 3:
        for p in range(len(point_element)):
            l0, l1, l2, g = area_coordinates(nodes, elements[point_element[p]], position[p])
            out = gradients[p]
            for j in range(2):
                g0, g1, g2 = g[j], g[2 + j], g[4 + j]
                out[0, j] = (4.0 * l0 - 1.0) * g0
                out[1, j] = (4.0 * l1 - 1.0) * g1
                out[2, j] = (4.0 * l2 - 1.0) * g2
                out[3, j] = 4.0 * (l0 * g1 + l1 * g0)
                out[4, j] = 4.0 * (l1 * g2 + l2 * g1)
                out[5, j] = 4.0 * (l2 * g0 + l0 * g2)
    else:
        lagrange_gradients(table, factors, nodes, elements, point_element, position, gradients)
    return gradients


@kernel
def lagrange_values(table, factors, nodes, elements, point_element, position, out):
    """Evaluate the basis functions of any order, as in `basis_values`, into `out` (q, k)."""
    own, slope = np.empty((3, len(factors))), np.empty((3, len(factors)))
    for p in range(len(point_element)):
        l0, l1, l2, _ = area_coordinates(nodes, elements[point_element[p]], position[p])
        evaluate_factors(factors, (l0, l1, l2), own, slope)
        for a in range(len(table)):
            out[p, a] = own[0, table[a, 0]] * own[1, table[a, 1]] * own[2, table[a, 2]]


@kernel
def lagrange_gradients(table, factors, nodes, elements, point_element, position, out):
    """Evaluate the gradients for any order, as in `basis_gradients`, into `out` (q, k, 2)."""
    own, slope = np.empty((3, len(factors))), np.empty((3, len(factors)))
    for p in range(len(point_element)):
        l0, l1, l2, g = area_coordinates(nodes, elements[point_element[p]], position[p])
        evaluate_factors(factors, (l0, l1, l2), own, slope)
        for a in range(len(table)):
            i, j, m = table[a, 0], table[a, 1], table[a, 2]
            d0 = slope[0, i] * own[1, j] * own[2, m]
            d1 = own[0, i] * slope[1, j] * own[2, m]
            d2 = own[0, i] * own[1, j] * slope[2, m]
            out[p, a, 0] = d0 * g[0] + d1 * g[2] + d2 * g[4]
            out[p, a, 1] = d0 * g[1] + d1 * g[3] + d2 * g[5]


@kernel
def evaluate_factors(factors, place, values, slopes):
    """Evaluate the factors P_i of the basis functions and their derivatives by Horner's rule.

    Parameters
    ----------
    factors : (p + 1, p + 1) float
        `Element.factors`.
    place : tuple of three floats
        Area coordinates.
    values, slopes : (3, p + 1) float
        P_i and dP_i/dL for each area coordinate; overwritten.
    """
    for corner in range(3):
        at = place[corner]
        for i in range(len(factors)):
            value = slope = 0.0
            for power in range(i, 0, -1):
                value = value * at + factors[i, power]
                slope = slope * at + power * factors[i, power]
            values[corner, i] = value * at + factors[i, 0]
            slopes[corner, i] = slope
