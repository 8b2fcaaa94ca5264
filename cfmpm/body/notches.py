"""Sharp notches of the boundary, which are no cracks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cfmpm.body.bends import turn
from cfmpm.body.grid import Floats, Ints, Triangulation

# Largest angle between the sides of a notch that may stand for a crack [deg].
WIDEST = 60.0
# Largest angle between two edges of one straight side [deg].
STRAIGHT = 1.0


@dataclass(frozen=True)
class Notch:
    """A wedge cut out of a body.

    Attributes
    ----------
    root : (2,) float
        Where its sides meet [mm].
    mouth : (2,) float
        The middle between the far ends of its sides [mm].
    angle : float
        Between its sides [deg].
    """

    root: Floats
    mouth: Floats
    angle: float


def sharp_notches(mesh: Triangulation) -> list[Notch]:
    """Find the notches of a boundary that may stand for cracks.

    Parameters
    ----------
    mesh : Triangulation

    Returns
    -------
    list of Notch
        Those narrower than `WIDEST` from whose root no crack starts.
    """
    edges = _body_on_the_left(mesh, np.concatenate([np.zeros((0, 2), int), *mesh.edges.values()]))
    along = _directions(mesh.nodes, edges)
    # By the node between two edges: the one that arrives there and the one that leaves.
    arriving, leaving = (np.argsort(edges[:, column]) for column in (1, 0))
    if len(edges) == 0 or not np.array_equal(edges[arriving, 1], edges[leaving, 0]):
        return []  # no closed loops, as where parts of a boundary share a node
    before, after = along[arriving], along[leaving]
    bend = np.degrees(turn(before, after))
    cracks = np.concatenate([np.zeros((0, 2), int), *mesh.cracks.values()])
    cracked = np.isin(edges[leaving, 0], cracks)
    chosen = np.flatnonzero((bend <= WIDEST - 180.0) & ~cracked)
    following = np.empty(len(edges), np.int64)
    following[arriving] = leaving
    previous = np.argsort(following)
    return [
        Notch(
            root=mesh.nodes[edges[leaving[i], 0]],
            mouth=0.5
            * (
                mesh.nodes[edges[_last(leaving[i], following, along), 1]]
                + mesh.nodes[edges[_last(arriving[i], previous, along), 0]]
            ),
            angle=float(180.0 + bend[i]),
        )
        for i in chosen.tolist()
    ]


def _body_on_the_left(mesh: Triangulation, edges: Ints) -> Ints:
    """Turn the edges that have the body on their right."""
    on_boundary = np.zeros(len(mesh.nodes), bool)
    on_boundary[edges] = True
    near = mesh.triangles[on_boundary[mesh.triangles].any(axis=1)]
    sides = near[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    own, directed = (pairs[:, 0] * len(mesh.nodes) + pairs[:, 1] for pairs in (edges, sides))
    return np.where(np.isin(own, directed)[:, None], edges, edges[:, ::-1])


def _last(edge: int, following: Ints, along: Floats) -> int:
    """The last edge of the straight side that an edge is the first one of."""
    *_, last = _side(edge, following, along)
    return last


def _side(edge: int, following: Ints, along: Floats) -> Iterator[int]:
    while True:
        yield edge
        further = int(following[edge])
        if abs(float(np.degrees(turn(along[edge], along[further])))) > STRAIGHT:
            return
        edge = further


def _directions(nodes: Floats, edges: Ints) -> Floats:
    along = nodes[edges[:, 1]] - nodes[edges[:, 0]]
    return np.asarray(along / np.hypot(*along.T)[:, None])
