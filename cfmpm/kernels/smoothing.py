"""Laplacian smoothing of nodes at triangles of low quality, where it improves the quality."""

from __future__ import annotations

import math

import numpy as np

from cfmpm._jit import kernel
from cfmpm.kernels.triangles import quality


@kernel
def worst_quality(nodes, triangles, half_edges, x, y):
    """Return the lowest quality of the triangles around a node, if the node is at (x, y).

    Parameters
    ----------
    nodes : (n, 2) float
        [mm].
    triangles : (m, 3) int
        Corners of each triangle.
    half_edges : (j,) int
        Half-edges that leave the node, from `topology.node_stars`.
    x, y : float
        Trial position of the node [mm].

    Returns
    -------
    float
        `triangles.quality`.
    """
    worst = math.inf
    for h in half_edges:
        t, k = h // 3, h % 3
        b, c = triangles[t, (k + 1) % 3], triangles[t, (k + 2) % 3]
        here = quality(x, y, nodes[b, 0], nodes[b, 1], nodes[c, 0], nodes[c, 1])
        worst = min(worst, here)
    return worst


@kernel
def smooth(nodes, triangles, offsets, half_edges, movable, least, sweeps):
    """Move nodes of triangles of low quality to the mean of their neighbours.

    A node is moved only if the lowest quality of its triangles increases.

    Parameters
    ----------
    nodes : (n, 2) float
        Changed in place [mm].
    triangles : (m, 3) int
        Corners of each triangle.
    offsets, half_edges
        From `topology.node_stars`.
    movable : (n,) bool
        Interior nodes that may move.
    least : float
        `triangles.quality` below which the nodes of a triangle are moved.
    sweeps : int
        Largest number of passes over all nodes.

    Returns
    -------
    (n,) bool
        Whether each node has moved.
    """
    moved = np.zeros(len(nodes), np.bool_)
    for _ in range(sweeps):
        done = True
        for i in range(len(nodes)):
            if not movable[i]:
                continue
            star = half_edges[offsets[i] : offsets[i + 1]]
            worst = worst_quality(nodes, triangles, star, nodes[i, 0], nodes[i, 1])
            if worst >= least:
                continue
            x = y = 0.0
            for h in star:
                neighbour = triangles[h // 3, (h + 1) % 3]
                x += nodes[neighbour, 0] / len(star)
                y += nodes[neighbour, 1] / len(star)
            if worst_quality(nodes, triangles, star, x, y) > worst:
                nodes[i, 0], nodes[i, 1] = x, y
                moved[i] = True
                done = False
        if done:
            break
    return moved
