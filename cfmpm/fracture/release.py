"""Release of one grid segment: align it with the direction, and lengthen the crack by it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cfmpm.grid import Floats, Ints, Triangulation
from cfmpm.kernels import topology

# Lengths that are tried, as parts of the length of the grid segment.
LENGTHS = (1.0, 0.85, 1.15, 0.7, 1.3, 0.55)
# Quality of a triangle (1 equilateral, 0 flat) with which a search ends, and the least accepted.
GOOD = 0.25
LEAST = 1e-3
# A crack that meets an edge of the boundary this near to its end, as part of the edge, ends there.
SNAP = 0.1


@dataclass(frozen=True)
class Release:
    """A triangulation with a longer crack.

    Attributes
    ----------
    triangulation : Triangulation
        Triangles keep their numbers; those of a split edge are appended.
    changed : (k,) int
        Triangles that changed their shape or are new.
    start, end : int
        Nodes of the new segment; `end` is the new tip, or where the crack arrived.
    deviation : float
        Angle between the segment and the direction asked for [deg].
    quality : float
        Of the worst triangle that changed.
    """

    triangulation: Triangulation
    changed: Ints
    start: int
    end: int
    deviation: float
    quality: float


def advance(triangulation: Triangulation, crack: str, end: int, direction: Floats) -> Release:
    """Lengthen a crack by one grid segment (paper section 4.1).

    Parameters
    ----------
    triangulation : Triangulation
    crack : str
    end : {0, -1}
        Which end of the crack runs: its first or its last node.
    direction : (2,) float
        Where to.

    Returns
    -------
    Release
        Of the segments at the tip, the one nearest to the direction is turned into it by moving
        its far node; its length is searched for the quality of the triangles around that node.
        Where no node may move (boundary, crack, border of a material, point load) or the triangles
        would be too flat, the side that the direction crosses is split there instead.
    """
    direction = np.asarray(direction, float) / np.hypot(*direction)
    star = _Star(triangulation, crack, end)
    first, second, place = star.side_ahead(direction)
    if star.is_wall(first, second):
        options = [star.arrive(first, second, place, direction)]
    else:
        options = star.realign((first, second), direction)
        if not options or max(option.quality for option in options) < GOOD:
            options.append(star.split(first, second, place, direction))
    return max(options, key=lambda option: min(option.quality, GOOD))


def fixed_nodes(triangulation: Triangulation) -> NDArray[np.bool_]:
    """Return which nodes may not move: boundary, cracks, borders of materials, point loads."""
    fixed = np.zeros(len(triangulation.nodes), bool)
    for pairs in (*triangulation.edges.values(), *triangulation.cracks.values()):
        fixed[pairs] = True
    fixed[list(triangulation.points.values())] = True
    if len(triangulation.region_names) > 1:
        lowest = np.full(len(fixed), np.iinfo(np.int64).max)
        highest = np.full(len(fixed), -1)
        for k in range(3):
            np.minimum.at(lowest, triangulation.triangles[:, k], triangulation.regions)
            np.maximum.at(highest, triangulation.triangles[:, k], triangulation.regions)
        fixed |= lowest != highest
    return fixed


def triangle_quality(nodes: Floats, triangles: Ints) -> Floats:
    """Return 4 sqrt(3) area over the sum of squared sides: 1 equilateral, negative inverted."""
    a, b, c = (nodes[triangles[:, k]] for k in range(3))
    squares = sum(((p - q) ** 2).sum(axis=1) for p, q in ((b, a), (c, b), (a, c)))
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    return 2.0 * np.sqrt(3.0) * (ux * vy - uy * vx) / squares


class _Star:
    """The triangles around a tip."""

    def __init__(self, triangulation: Triangulation, crack: str, end: int) -> None:
        self.mesh = triangulation
        self.crack, self.end = crack, end
        pairs = triangulation.cracks[crack]
        self.tip = int(pairs[0, 0] if end == 0 else pairs[-1, 1])
        self.fixed = fixed_nodes(triangulation)
        triangles = triangulation.triangles
        self.offsets, self.half_edges = topology.node_stars(triangles, len(triangulation.nodes))
        around = self.half_edges[self.offsets[self.tip] : self.offsets[self.tip + 1]]
        self.sides = np.column_stack(
            [triangles[around // 3, (around + 1) % 3], triangles[around // 3, (around + 2) % 3]]
        )

    def side_ahead(self, direction: Floats) -> tuple[int, int, float]:
        """Find the side opposite to the tip that a direction crosses, and where along it."""
        origin = self.mesh.nodes[self.tip]
        a, b = (self.mesh.nodes[self.sides[:, k]] - origin for k in range(2))
        to_a, to_b = (direction[0] * x[:, 1] - direction[1] * x[:, 0] for x in (a, b))
        # The direction lies between both ends of a side, seen from the tip; of two that share
        # the end it points at, either will do.
        ahead = (a + b) @ direction > 0.0
        inside = np.flatnonzero(ahead & (to_a <= 0.0) & (to_b >= 0.0))
        if inside.size == 0:
            raise ValueError("the direction leaves the triangles around the tip")
        hit = inside[0]
        first, second = map(int, self.sides[hit])
        return first, second, float(to_a[hit] / (to_a[hit] - to_b[hit]))

    def is_wall(self, first: int, second: int) -> bool:
        """Whether a side is part of the boundary or of a crack."""
        walls = (*self.mesh.edges.values(), *self.mesh.cracks.values())
        pair = {first, second}
        return any(
            pair == set(wall)
            for pairs in walls
            for wall in pairs[(pairs == first).any(axis=1)].tolist()
        )

    def realign(self, candidates: tuple[int, int], direction: Floats) -> list[Release]:
        """Move the far node of a segment onto the direction; the best length of each candidate."""
        nodes = self.mesh.nodes
        origin = nodes[self.tip]
        options = []
        for node in sorted(candidates, key=lambda n: -self._cosine(nodes[n] - origin, direction)):
            if self.fixed[node]:
                continue
            star = self.half_edges[self.offsets[node] : self.offsets[node + 1]] // 3
            length = np.hypot(*(nodes[node] - origin))
            best: tuple[float, Floats] | None = None
            for factor in LENGTHS:
                moved = nodes.copy()
                moved[node] = origin + factor * length * direction
                quality = float(triangle_quality(moved, self.mesh.triangles[star]).min())
                if best is None or quality > best[0]:
                    best = quality, moved
                if quality >= GOOD:
                    break
            assert best is not None
            if best[0] > LEAST:
                mesh = replace(self.mesh, nodes=best[1])
                options.append(self._extended(mesh, star, node, direction))
            if best[0] >= GOOD:
                break
        return options

    def arrive(self, first: int, second: int, place: float, direction: Floats) -> Release:
        """End the crack on a wall: at a node that is near, else at a new one."""
        if SNAP < place < 1.0 - SNAP:
            return self.split(first, second, place, direction)
        node = first if place <= SNAP else second
        return self._extended(self.mesh, np.empty(0, np.int64), node, direction)

    def split(self, first: int, second: int, place: float, direction: Floats) -> Release:
        """Split a side, and the triangles on both sides of it, where the direction crosses it."""
        mesh = self.mesh
        new = len(mesh.nodes)
        nodes = np.vstack(
            [mesh.nodes, (1 - place) * mesh.nodes[first] + place * mesh.nodes[second]]
        )
        star = mesh.triangles, self.offsets, self.half_edges
        beside = [
            int(topology.find_half_edge(*star, *pair))
            for pair in ((first, second), (second, first))
        ]
        triangles, added, regions, changed = mesh.triangles.copy(), [], [], []
        for half_edge in (h for h in beside if h >= 0):
            triangle, side = half_edge // 3, half_edge % 3
            a, b, c = (int(mesh.triangles[triangle, (side + k) % 3]) for k in range(3))
            triangles[triangle] = (a, new, c)
            added.append((new, b, c))
            regions.append(mesh.regions[triangle])
            changed.append(triangle)
        changed += range(len(triangles), len(triangles) + len(added))
        halved = replace(
            mesh,
            nodes=nodes,
            triangles=np.vstack([triangles, added]),
            regions=np.concatenate([mesh.regions, regions]),
            edges={name: _halved(p, first, second, new) for name, p in mesh.edges.items()},
            cracks={name: _halved(p, first, second, new) for name, p in mesh.cracks.items()},
        )
        return self._extended(halved, np.array(changed), new, direction)

    def _extended(
        self, mesh: Triangulation, changed: Ints, node: int, direction: Floats
    ) -> Release:
        """Add the segment from the tip to a node to the crack."""
        pairs = mesh.cracks[self.crack]
        if self.end == 0:
            longer = np.vstack([[(node, self.tip)], pairs])
        else:
            longer = np.vstack([pairs, [(self.tip, node)]])
        quality = triangle_quality(mesh.nodes, mesh.triangles[changed])
        segment = mesh.nodes[node] - mesh.nodes[self.tip]
        return Release(
            triangulation=replace(mesh, cracks={**mesh.cracks, self.crack: longer}),
            changed=changed,
            start=self.tip,
            end=node,
            deviation=float(np.degrees(np.arccos(min(1.0, self._cosine(segment, direction))))),
            quality=float(quality.min(initial=1.0)),
        )

    @staticmethod
    def _cosine(vector: Floats, direction: Floats) -> float:
        return float(vector @ direction / np.hypot(*vector))


def _halved(pairs: Ints, first: int, second: int, new: int) -> Ints:
    """Replace a node pair by the two that a node in its middle makes, where it occurs."""
    for a, b in ((first, second), (second, first)):
        at = np.flatnonzero((pairs[:, 0] == a) & (pairs[:, 1] == b))
        if at.size:
            return np.vstack([pairs[: at[0]], [(a, new), (new, b)], pairs[at[0] + 1 :]])
    return pairs
