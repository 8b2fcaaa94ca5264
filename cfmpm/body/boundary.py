"""The parts of the boundary that loads act on, and the integrals of the basis along them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cfmpm.body.grid import Floats, Grid, Ints, lengths_of
from cfmpm.body.protocols import XY, GivenLoad, TrueSide
from cfmpm.registry.loads import LOADS

# Tolerance of positions for round-off, relative to the size of the body or of an edge.
SLACK = 1e-9


@dataclass(frozen=True)
class Segments:
    """The parts of boundary edges that one load acts on.

    Attributes
    ----------
    edges : (k, p + 1) int
        Nodes of each edge.
    weights : (k, p + 1) float
        Integrals of their basis functions over the part of the edge [mm].
    """

    edges: Ints
    weights: Floats


def find_segments(load: GivenLoad, sides: Mapping[str, Sequence[TrueSide]], grid: Grid) -> Segments:
    """Find the parts of the boundary that a load on an edge or in a box acts on.

    Parameters
    ----------
    load : GivenLoad
    sides : mapping of str to sequence of TrueSide
        The exact sides of the boundary, by the names of their edges; empty for a mesh file.
    grid : Grid

    Returns
    -------
    Segments
        For a box exactly the part of the boundary in it; edges are cut at its border.
    """
    names = [load.edge] if load.edge is not None else list(grid.edges)
    edges = np.concatenate([grid.edges[name] for name in names])
    lengths = np.concatenate(
        [_true_lengths(grid, grid.edges[name], sides.get(name, ())) for name in names]
    )
    if load.box is not None:
        # In a mesh file an edge may have two names.
        edges, first = np.unique(edges, axis=0, return_index=True)
        lengths = lengths[first]
    start, end = np.zeros(len(edges)), np.ones(len(edges))
    if load.box is not None:
        start, end = _inside(load.box, grid, edges)
        touched = end - start > SLACK
        edges, lengths, start, end = (part[touched] for part in (edges, lengths, start, end))

    def primitive(s: Floats) -> Floats:
        """The integrals of the basis functions from one end of the edge to s."""
        rows = grid.element.side_integrals
        return np.asarray(
            sum(np.outer(s**power, column) for power, column in enumerate(rows.T[1:], 1))
        )

    return Segments(edges, lengths[:, None] * (primitive(end) - primitive(start)))


def nodes_and_weights(load: GivenLoad, grid: Grid, segments: Segments) -> tuple[Ints, Floats]:
    """Sum the integrals at the nodes.

    Parameters
    ----------
    load : GivenLoad
    grid : Grid
    segments : Segments
        Segments of this load.

    Returns
    -------
    nodes : (k,) int
        For a displacement only the nodes in its box, for a traction all nodes of its edges.
    weights : (k,) float
        [mm].
    """
    nodes, inverse = np.unique(segments.edges, return_inverse=True)
    weights = np.zeros(len(nodes))
    np.add.at(weights, inverse.ravel(), segments.weights.ravel())
    if load.box is not None and LOADS[load.kind].holds:
        low, high = _corners(load.box, grid)
        within = np.all((grid.nodes[nodes] >= low) & (grid.nodes[nodes] <= high), axis=1)
        nodes, weights = nodes[within], weights[within]
    return nodes, weights


def _inside(box: tuple[XY, XY], grid: Grid, edges: Ints) -> tuple[Floats, Floats]:
    """Positions at which each edge enters and leaves a box: 0 at its start, 1 at its end."""
    low, high = _corners(box, grid)
    enter, leave = np.zeros(len(edges)), np.ones(len(edges))
    for axis in (0, 1):
        a, b = grid.nodes[edges[:, :2], axis].T
        cut = (np.minimum(a, b) < low[axis]) | (np.maximum(a, b) > high[axis])
        # An edge along the border is in the box; others are cut exactly at the border.
        with np.errstate(divide="ignore"):
            crossings = np.sort([(corner[axis] - a[cut]) / (b - a)[cut] for corner in box], axis=0)
        enter[cut] = np.maximum(enter[cut], crossings[0])
        leave[cut] = np.minimum(leave[cut], crossings[1])
    return enter, leave


def _corners(box: tuple[XY, XY], grid: Grid) -> tuple[Floats, Floats]:
    """The lower left and the upper right corner of a box, with a tolerance for round-off."""
    slack = SLACK * np.ptp(grid.nodes, axis=0).max()
    return np.min(box, axis=0) - slack, np.max(box, axis=0) + slack


def _true_lengths(grid: Grid, edges: Ints, sides: Sequence[TrueSide]) -> Floats:
    """Exact length of the boundary along each edge, which on an arc exceeds that of the chord.

    The force is then exactly traction times length. For a mesh file the exact shape is unknown.
    """
    lengths = lengths_of(grid.nodes, edges)
    if all(side.through is None for side in sides):
        return lengths
    middles = grid.nodes[edges[:, :2]].mean(axis=1)
    nearest = np.argmin([side.distances(middles) for side in sides], axis=0)
    for i, side in enumerate(sides):
        if side.through is None:
            continue
        own = nearest == i
        turns = np.arcsin(np.minimum(1.0, lengths[own] / (2 * side.radius)))
        # A crack that arrived on a chord has added a node off the arc; the sum is still exact.
        lengths[own] = side.length * turns / turns.sum()
    return lengths
