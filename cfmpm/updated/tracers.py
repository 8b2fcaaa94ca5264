"""The triangle of the current grid with which each tracer moves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.grid import Floats, Grid, Ints
from cfmpm.body.motion import Motion, nearest_filled
from cfmpm.body.points import locate
from cfmpm.kernels import location, topology


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
    from the crack of the material: its triangle is then the nearest one on that side.
    """
    position, hints = motion.tracers[astray], motion.triangle[astray]
    triangles = np.ascontiguousarray(grid.triangles)
    found: Ints = location.walk_from_hints(grid.nodes, triangles, grid.twins, hints, position)
    blocked = found == location.OUTSIDE
    on_face = blocked & _on_crack(motion.reference)[astray]
    search = _Search(grid)
    every = np.ones(len(triangles), bool)
    for i in np.flatnonzero(on_face):
        found[i] = search.nearest(every, int(hints[i]), position[i])
    rest = blocked & ~on_face
    if rest.any():
        found[rest] = locate(grid, position[rest], hints[rest])
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


def _on_crack(grid: Grid) -> NDArray[np.bool_]:
    """Whether a node lies on a crack face."""
    on_crack = np.zeros(len(grid.nodes), bool)
    for faces in grid.crack_faces.values():
        on_crack[grid.edge_nodes(faces.ravel())] = True
    return on_crack


class _Search:
    """Search for the nearest triangle, never across a crack."""

    def __init__(self, grid: Grid) -> None:
        self._nodes = grid.nodes
        self._triangles = np.ascontiguousarray(grid.triangles)
        self._star = topology.node_stars(self._triangles, grid.n_corners)

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
