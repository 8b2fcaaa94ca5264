"""The triangle of the current grid with which each tracer moves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.grid import Floats, Grid, Ints
from cfmpm.body.motion import Motion, nearest_filled
from cfmpm.body.points import locate
from cfmpm.kernels import location, topology

# Distance from a node into its triangle, over that to the centroid, for the side of a crack.
INSIDE = 1e-2


def placed(grid: Grid, motion: Motion, astray: Ints) -> Ints:
    """Find the triangles that contain tracers, (k,); -1 outside the grid.

    Parameters
    ----------
    grid : Grid
        The current grid.
    motion : Motion
        With the triangles of the tracers before.
    astray : (k,) int
        The tracers.

    Notes
    -----
    A tracer of a crack face stays on its side of the crack of the grid, where that has drifted
    from the crack of the material: in the nearest of the triangles at its own node. A walk alone
    would go round the tip.
    """
    position, hints = motion.tracers[astray], motion.triangle[astray]
    triangles = np.ascontiguousarray(grid.triangles)
    found: Ints = location.walk_from_hints(grid.nodes, triangles, grid.twins, hints, position)
    lost = found == location.OUTSIDE
    own, node = _beside_faces(grid, motion.reference)
    on_face = np.flatnonzero(own[astray] >= 0)
    search = _Search(grid)
    for i in on_face:
        tracer = astray[i]
        place = grid.nodes[node[tracer]]
        inside = place + INSIDE * (grid.nodes[triangles[own[tracer]]].mean(axis=0) - place)
        if lost[i] or search.crosses(inside, position[i]):
            found[i] = search.nearest_at(int(node[tracer]), position[i])
            lost[i] = False
    if lost.any():
        found[lost] = locate(grid, position[lost], hints[lost])
    return found


def carriers(grid: Grid, motion: Motion, filled: NDArray[np.bool_]) -> Ints:
    """Find the triangles with material with which the tracers move, (n,).

    A tracer in a triangle without material moves with the nearest triangle that has some.
    """
    found = nearest_filled(grid, filled)[motion.triangle]
    search = _Search(grid)
    for i in np.flatnonzero(found != motion.triangle):
        found[i] = search.nearest(filled, int(found[i]), motion.tracers[i])
    return found


def _beside_faces(grid: Grid, reference: Grid) -> tuple[Ints, Ints]:
    """A triangle of each tracer of a crack face, and its node in the current grid; else -1."""
    triangle, node = np.full((2, len(reference.nodes)), -1)
    for faces in reference.crack_faces.values():
        element, side = np.divmod(faces.ravel(), 3)
        for corner in range(reference.element.order + 1):
            place = reference.element.sides[side, corner]
            tracer = reference.elements[element, place]
            triangle[tracer], node[tracer] = element, grid.elements[element, place]
    return triangle, node


class _Search:
    """Search for the nearest triangle, never across a crack."""

    def __init__(self, grid: Grid) -> None:
        self._nodes = grid.nodes
        self._triangles = np.ascontiguousarray(grid.triangles)
        self._star = topology.node_stars(self._triangles, grid.n_corners)
        faces = [grid.edge_nodes(faces[:, 0])[:, [0, 1]] for faces in grid.crack_faces.values()]
        self._cracks = grid.nodes[np.concatenate(faces)] if faces else np.zeros((0, 2, 2))
        self._elements = grid.elements

    def nearest(self, allowed: NDArray[np.bool_], start: int, position: Floats) -> int:
        """Walk from a triangle over adjacent allowed ones while they come nearer to a position."""
        best, apart = start, self._distance(start, position)
        while apart > 0.0:
            around = [t for t in self._around(best) if allowed[t]]
            distances = [self._distance(t, position) for t in around]
            if min(distances, default=apart) >= apart:
                break
            apart = min(distances)
            best = around[distances.index(apart)]
        return best

    def nearest_at(self, node: int, position: Floats) -> int:
        """The nearest triangle of those at a node."""
        there = np.flatnonzero((self._elements == node).any(axis=1)).tolist()
        distances = [self._distance(t, position) for t in there]
        return int(there[distances.index(min(distances))])

    def crosses(self, start: Floats, end: Floats) -> bool:
        """Whether the straight way between two points crosses a crack."""
        a, b = self._cracks[:, 0], self._cracks[:, 1]
        of_ends = _side(a, b, start) * _side(a, b, end)
        of_crack = _side(start, end, a) * _side(start, end, b)
        return bool(((of_ends < 0.0) & (of_crack <= 0.0)).any())

    def _around(self, triangle: int) -> list[int]:
        """Triangles with a corner in common."""
        offsets, half_edges = self._star
        found = [half_edges[offsets[n] : offsets[n + 1]] // 3 for n in self._triangles[triangle]]
        return np.unique(np.concatenate(found)).tolist()

    def _distance(self, triangle: int, position: Floats) -> float:
        """Distance of a position from a triangle, 0 inside [mm]."""
        corners = self._nodes[self._triangles[triangle]]
        side = np.roll(corners, -1, axis=0) - corners
        to = position - corners
        if (side[:, 0] * to[:, 1] - side[:, 1] * to[:, 0]).min() >= 0.0:
            return 0.0
        along = np.clip((side * to).sum(axis=1) / (side**2).sum(axis=1), 0.0, 1.0)
        return float(np.hypot(*(to - along[:, None] * side).T).min())


def _side(a: Floats, b: Floats, point: Floats) -> Floats:
    """Twice the area of triangles a, b, point: its sign is the side of a -> b of the point."""
    along, to = b - a, point - a
    return along[..., 0] * to[..., 1] - along[..., 1] * to[..., 0]
