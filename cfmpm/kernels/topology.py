"""Adjacency of triangles, and doubling of nodes along cracks.

Half-edge ``3 * triangle + k`` is the side from corner k to corner k + 1. Triangles are
anticlockwise, so that the triangle is to the left of its half-edges. An interior edge consists of
two half-edges in opposite directions, which are twins.
"""

from __future__ import annotations

import numpy as np

from cfmpm._jit import kernel


@kernel
def node_stars(triangles, n_nodes):
    """List the half-edges that start at each node.

    Parameters
    ----------
    triangles : (m, 3) int
        Corners of each triangle.
    n_nodes : int

    Returns
    -------
    offsets : (n_nodes + 1,) int
    half_edges : (3 m,) int
        Those of node i are ``half_edges[offsets[i]:offsets[i + 1]]``, in ascending order.
    """
    offsets = np.zeros(n_nodes + 1, np.int64)
    for t in range(triangles.shape[0]):
        for k in range(3):
            offsets[triangles[t, k] + 1] += 1
    for i in range(n_nodes):
        offsets[i + 1] += offsets[i]
    fill = offsets[:-1].copy()
    half_edges = np.empty(3 * triangles.shape[0], np.int64)
    for t in range(triangles.shape[0]):
        for k in range(3):
            node = triangles[t, k]
            half_edges[fill[node]] = 3 * t + k
            fill[node] += 1
    return offsets, half_edges


@kernel
def find_half_edge(triangles, offsets, half_edges, a, b):
    """Return the half-edge from node a to node b; -1 if there is none."""
    for j in range(offsets[a], offsets[a + 1]):
        half_edge = half_edges[j]
        if triangles[half_edge // 3, (half_edge + 1) % 3] == b:
            return half_edge
    return -1


@kernel
def find_half_edges(triangles, offsets, half_edges, pairs):
    """Return the half-edges between pairs of nodes.

    Parameters
    ----------
    triangles : (m, 3) int
        Corners of each triangle.
    offsets, half_edges
        From `node_stars`.
    pairs : (k, 2) int
        Start and end node of each half-edge.

    Returns
    -------
    (k,) int
        -1 for pairs that are not the ends of a half-edge.
    """
    found = np.empty(pairs.shape[0], np.int64)
    for i in range(pairs.shape[0]):
        found[i] = find_half_edge(triangles, offsets, half_edges, pairs[i, 0], pairs[i, 1])
    return found


@kernel
def find_twins(triangles, offsets, half_edges):
    """Return the twin of each half-edge.

    Parameters
    ----------
    triangles : (m, 3) int
        Corners of each triangle.
    offsets, half_edges
        From `node_stars`.

    Returns
    -------
    (m, 3) int
        -1 on the boundary and on crack faces.
    """
    twins = np.empty(triangles.shape, np.int64)
    for t in range(triangles.shape[0]):
        for k in range(3):
            twins[t, k] = find_half_edge(
                triangles, offsets, half_edges, triangles[t, (k + 1) % 3], triangles[t, k]
            )
    return twins


@kernel
def connected_parts(twins):
    """Number the connected parts of a grid, in the order of their first triangles.

    Parameters
    ----------
    twins : (m, 3) int
        From `find_twins`, -1 on the boundary and along crack lines.

    Returns
    -------
    (m,) int
        The part of each triangle.
    """
    part = np.full(twins.shape[0], -1, np.int64)
    waiting = np.empty(twins.shape[0], np.int64)
    count = 0
    for first in range(twins.shape[0]):
        if part[first] >= 0:
            continue
        part[first] = count
        waiting[0] = first
        n = 1
        while n > 0:
            n -= 1
            triangle = waiting[n]
            for k in range(3):
                across = twins[triangle, k] // 3
                if across >= 0 and part[across] < 0:
                    part[across] = count
                    waiting[n] = across
                    n += 1
        count += 1
    return part


@kernel
def split_nodes(triangles, twins, offsets, half_edges, nodes, n_nodes):
    """Double the nodes along cracks: each fan of triangles around a node gets its own node.

    A fan is a set of triangles around the node that are connected across sides. The first fan keeps
    the node, each further fan gets a new node with the same coordinates.

    Parameters
    ----------
    triangles : (m, 3) int
        Corners of each triangle; changed in place.
    twins : (m, 3) int
        Twins of the half-edges, already set to -1 along cracks.
    offsets, half_edges
        From `node_stars` of the triangles before nodes were doubled.
    nodes : (k,) int
        Nodes on cracks, each once.
    n_nodes : int
        Number of the first new node.

    Returns
    -------
    parents : (j,) int
        Original node of each new node.
    """
    parents = []
    for node in nodes:
        first, last = offsets[node], offsets[node + 1]
        reached = np.zeros(last - first, np.bool_)
        fans = 0
        for j in range(first, last):
            if reached[j - first]:
                continue
            label = node
            if fans > 0:
                label = n_nodes + len(parents)
                parents.append(node)
            fans += 1
            # Go clockwise to the first triangle of the fan, or once around a closed fan.
            start = half_edges[j]
            while twins[start // 3, start % 3] >= 0:
                twin = twins[start // 3, start % 3]
                start = 3 * (twin // 3) + (twin + 1) % 3
                if start == half_edges[j]:
                    break
            # Then go anticlockwise through the fan.
            current = start
            while True:
                for i in range(first, last):
                    if half_edges[i] == current:
                        reached[i - first] = True
                triangles[current // 3, current % 3] = label
                current = twins[current // 3, (current + 2) % 3]
                if current < 0 or current == start:
                    break
    return np.array(parents, np.int64) if len(parents) > 0 else np.empty(0, np.int64)
