"""Adjacency of triangles, and the splitting of nodes along crack lines.

A half-edge is ``3 * triangle + k``, the side from corner k to corner k + 1; with triangles
anticlockwise the body lies to its left. Every interior edge is two half-edges, its twins.
"""

from __future__ import annotations

import numpy as np

from cfmpm._jit import kernel


@kernel
def node_stars(triangles, n_nodes):
    """List the half-edges that leave each node.

    Parameters
    ----------
    triangles : (m, 3) int
    n_nodes : int

    Returns
    -------
    offsets : (n_nodes + 1,) int
    half_edges : (3 m,) int
        Those of node i are ``half_edges[offsets[i]:offsets[i + 1]]``, ascending.
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
    """Return the half-edge from node a to node b, or -1."""
    for j in range(offsets[a], offsets[a + 1]):
        half_edge = half_edges[j]
        if triangles[half_edge // 3, (half_edge + 1) % 3] == b:
            return half_edge
    return -1


@kernel
def find_half_edges(triangles, offsets, half_edges, pairs):
    """Return the half-edges from ``pairs[:, 0]`` to ``pairs[:, 1]``, or -1; (k,) int."""
    found = np.empty(pairs.shape[0], np.int64)
    for i in range(pairs.shape[0]):
        found[i] = find_half_edge(triangles, offsets, half_edges, pairs[i, 0], pairs[i, 1])
    return found


@kernel
def find_twins(triangles, offsets, half_edges):
    """Return the twin of each half-edge, -1 on the boundary; (m, 3) int."""
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
    """Give each fan of triangles around `nodes` a node of its own, in place.

    The twins along a crack have been set to -1 beforehand. The first fan keeps the node, each
    further one is given a new node at the same place.

    Parameters
    ----------
    triangles, twins : (m, 3) int
        `triangles` is changed.
    offsets, half_edges
        From `node_stars` of the triangles before any splitting.
    nodes : (k,) int
        The nodes on crack lines, each once.
    n_nodes : int
        New nodes are numbered from here.

    Returns
    -------
    parents : (j,) int
        The node that each new node is a copy of.
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
            # Turn clockwise to the start of the fan, unless it closes on itself.
            start = half_edges[j]
            while twins[start // 3, start % 3] >= 0:
                twin = twins[start // 3, start % 3]
                start = 3 * (twin // 3) + (twin + 1) % 3
                if start == half_edges[j]:
                    break
            # Then anticlockwise through all of it.
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
