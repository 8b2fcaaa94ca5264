"""Release of one grid segment: align it with the direction of growth, and extend the crack."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.grid import Floats, Ints, Triangulation
from cfmpm.kernels import topology
from cfmpm.kernels.triangles import triangle_quality

# Trial lengths of the segment, as fractions of the length of the grid segment.
LENGTHS = (1.0, 0.85, 1.15, 0.7, 1.3, 0.55)
# Quality of a triangle (1 equilateral, 0 degenerate) at which a search ends.
GOOD = 0.25
# Worth (`_Star.worth`) down to which a segment of a given length is preferred to another length.
ACCEPTED = 0.5 * GOOD
# The quality of an option is reduced in proportion if its segment ends inside the body and is
# shorter than this fraction of the mean edge at the tip. Without it, two tips that alternately
# split the side between the other tip and a boundary would advance by ever shorter segments.
SHORT = 0.4
# It is also reduced in proportion if the segment deviates by more than this [deg].
SNAP = 3.0
# Largest kink angle [deg]. Every criterion stays below it while a crack is open (45 for the
# configurational force, 70.5 for max_hoop, 77 for max_energy). A direction that points further back
# is noise of a tip whose domain has hardly any elements.
LARGEST_KINK = 100.0


@dataclass(frozen=True)
class Release:
    """A triangulation with a longer crack.

    Attributes
    ----------
    triangulation : Triangulation
        Triangles keep their numbers; those of a split side are appended.
    changed : (k,) int
        Triangles that are new or have changed their shape.
    start, end : int
        Nodes of the new segment; `end` is the new tip, or the node at which the crack arrived.
    deviation : float
        Angle between the segment and the direction of growth [deg].
    quality : float
        Quality of the worst changed triangle.
    """

    triangulation: Triangulation
    changed: Ints
    start: int
    end: int
    deviation: float
    quality: float

    @property
    def length(self) -> float:
        """Length of the new segment [mm]."""
        nodes = self.triangulation.nodes
        return float(np.hypot(*(nodes[self.end] - nodes[self.start])))


@dataclass(frozen=True)
class _Option:
    """A triangulation in which a segment from the tip to `node` can be released."""

    mesh: Triangulation
    changed: Ints
    node: int

    @property
    def quality(self) -> float:
        """Quality of the worst changed triangle."""
        changed = self.mesh.triangles[self.changed]
        return float(triangle_quality(self.mesh.nodes, changed).min(initial=1.0))


def advance(
    triangulation: Triangulation,
    crack: str,
    end: int,
    direction: Floats,
    length: float | None = None,
) -> Release:
    """Extend a crack by one grid segment (paper section 4.1).

    Parameters
    ----------
    triangulation : Triangulation
    crack : str
    end : {0, -1}
        The growing end of the crack, its first or its last node; it is a tip.
    direction : (2,) float
        Direction of growth. The kink angle is limited to `LARGEST_KINK`.
    length : float, optional
        Length of the segment, if its triangles are not worse than `ACCEPTED` [mm].

    Returns
    -------
    Release
        Of the segments at the tip, the one nearest to the direction is aligned with it by moving
        its far node. Its length is chosen for the quality of the triangles around that node.
        If no node may move (boundary, crack, material interface, point load) or the triangles
        would be of low quality, the side that the direction crosses is split there instead, or the
        crack grows to a node close to its direction, whichever gives the better triangles and
        segment.

    Notes
    -----
    Laplacian smoothing around triangles of low quality has little effect. Of 2900 releases in
    random bodies (tests/verification/test_growth_random.py) 4 % left a triangle of quality below
    0.25. Nearly all of these are where a side between fixed nodes is split, and smoothing may not
    move these nodes either: their median quality rose from 0.198 to 0.202.
    """
    asked = direction / np.hypot(*direction)
    star = _Star(triangulation, crack, end)
    heading = star.limited(asked)
    first, second, place = star.side_ahead(heading)
    if length is not None:
        exact = star.of_length((first, second, place), heading, length)
        if exact is not None and star.worth(exact, heading) >= ACCEPTED:
            return star.release(exact, asked)
    options: list[_Option] = []
    if not star.is_wall(first, second):
        options += star.realigned((first, second), heading)
    if not any(option.quality >= GOOD for option in options):
        options += star.split(first, second, place, heading)
        options += star.met((first, second))
    return star.release(max(options, key=lambda option: star.worth(option, heading)), asked)


def worths(
    triangulation: Triangulation,
    crack: str,
    end: int,
    direction: Floats,
    lengths: Sequence[float],
) -> Floats:
    """Rate segments of given lengths by their triangles, from 0 to `GOOD`, (length,).

    Parameters are those of `advance`.
    """
    star = _Star(triangulation, crack, end)
    heading = star.limited(direction / np.hypot(*direction))
    ahead = star.side_ahead(heading)
    options = [star.of_length(ahead, heading, length) for length in lengths]
    return np.array([star.worth(option, heading) if option else 0.0 for option in options])


def fixed_nodes(triangulation: Triangulation) -> NDArray[np.bool_]:
    """Return which nodes may not move: boundary, cracks, material interfaces, point loads."""
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


def split_side(
    mesh: Triangulation, stars: tuple[Ints, Ints], pair: tuple[int, int], place: float
) -> tuple[Triangulation, Ints]:
    """Split a side and its adjacent triangles by a new node, which is appended.

    Parameters
    ----------
    mesh : Triangulation
    stars
        From `topology.node_stars` of the triangles.
    pair : (int, int)
        The end nodes of the side.
    place : float
        Position of the new node, from 0 at the first end to 1 at the second.

    Returns
    -------
    Triangulation
        One part of each split triangle keeps its number; the other is appended.
    changed : (k,) int
        The parts.
    """
    first, second = pair
    new = len(mesh.nodes)
    at = (1 - place) * mesh.nodes[first] + place * mesh.nodes[second]
    half_edges = [
        int(topology.find_half_edge(mesh.triangles, *stars, *ends))
        for ends in ((first, second), (second, first))
    ]
    triangles, added, regions, changed = mesh.triangles.copy(), [], [], []
    for half_edge in (h for h in half_edges if h >= 0):
        triangle, side = half_edge // 3, half_edge % 3
        a, b, c = (int(mesh.triangles[triangle, (side + k) % 3]) for k in range(3))
        triangles[triangle] = (a, new, c)
        added.append((new, b, c))
        regions.append(mesh.regions[triangle])
        changed.append(triangle)
    changed += range(len(triangles), len(triangles) + len(added))
    halved = replace(
        mesh,
        nodes=np.vstack([mesh.nodes, at]),
        triangles=np.vstack([triangles, added]),
        regions=np.concatenate([mesh.regions, regions]),
        edges={name: _halved(p, first, second, new) for name, p in mesh.edges.items()},
        cracks={name: _halved(p, first, second, new) for name, p in mesh.cracks.items()},
    )
    return halved, np.array(changed)


class _Star:
    """The triangles around a tip."""

    def __init__(self, triangulation: Triangulation, crack: str, end: int) -> None:
        self.mesh = triangulation
        self.crack, self.end = crack, end
        self.tip = triangulation.end_of(crack, end)
        self.fixed = fixed_nodes(triangulation)
        triangles = triangulation.triangles
        self.stars = topology.node_stars(triangles, len(triangulation.nodes))
        around = self._around(self.tip)
        self.sides = np.column_stack(
            [triangles[around // 3, (around + 1) % 3], triangles[around // 3, (around + 2) % 3]]
        )
        self.origin = triangulation.nodes[self.tip]
        rim = triangulation.nodes[self.sides[:, 0]] - self.origin
        self.size = float(np.hypot(*rim.T).mean())

        pairs = triangulation.cracks[crack]
        self.behind = int(pairs[0, 1] if end == 0 else pairs[-1, 0])

    def limited(self, direction: Floats) -> Floats:
        """Limit the kink angle of a direction to `LARGEST_KINK`."""
        tangent = complex(*(self.origin - self.mesh.nodes[self.behind]))
        kink = np.degrees(np.angle(complex(*direction) / tangent))
        turn = np.exp(1j * np.radians(np.clip(kink, -LARGEST_KINK, LARGEST_KINK) - kink))
        turned = complex(*direction) * turn
        return np.array([turned.real, turned.imag])

    def side_ahead(self, direction: Floats) -> tuple[int, int, float]:
        """Find the side opposite the tip that a direction crosses, and the position along it."""
        a, b = (self.mesh.nodes[self.sides[:, k]] - self.origin for k in range(2))
        from_a, to_b = (
            sign * (x[:, 0] * direction[1] - x[:, 1] * direction[0])
            for sign, x in ((1.0, a), (-1.0, b))
        )
        # These are the weights of b and a in the direction as a combination of the vectors from
        # the tip to the ends of the side. Where it points at a node, either side may be taken.
        inside = np.minimum(from_a / np.hypot(*a.T), to_b / np.hypot(*b.T))
        hit = int(np.argmax(inside))
        first, second = map(int, self.sides[hit])
        place = from_a[hit] / (from_a[hit] + to_b[hit])
        return first, second, float(np.clip(place, 0.0, 1.0))

    def is_wall(self, first: int, second: int) -> bool:
        """Whether a side is part of the boundary or of a crack."""
        walls = (*self.mesh.edges.values(), *self.mesh.cracks.values())
        pair = {first, second}
        return any(
            pair == set(wall)
            for pairs in walls
            for wall in pairs[(pairs == first).any(axis=1)].tolist()
        )

    def realigned(self, ends: tuple[int, int], direction: Floats) -> Iterator[_Option]:
        """Move the far node of a segment onto the direction; the nearest segment is tried first."""
        away = self.mesh.nodes[list(ends)] - self.origin
        for i in np.argsort(-(away @ direction) / np.hypot(*away.T), kind="stable"):
            node = ends[i]
            if self.fixed[node]:
                continue
            option = self._with_best_length(
                _Option(self.mesh, self._around(node) // 3, node),
                float(np.hypot(*away[i])),
                direction,
            )
            yield option
            if option.quality >= GOOD:
                return

    def of_length(
        self, ahead: tuple[int, int, float], direction: Floats, length: float
    ) -> _Option | None:
        """Give the segment of a length with the best triangles; None before a wall.

        Parameters
        ----------
        ahead
            From `side_ahead`. One of its ends is moved, or a new node on it.
        direction : (2,) float
        length : float
            [mm].
        """
        first, second, place = ahead
        if self.is_wall(first, second):
            return None
        options = [
            _Option(self.mesh, self._around(node) // 3, node)
            for node in (first, second)
            if not self.fixed[node]
        ]
        halved, changed = split_side(self.mesh, self.stars, (first, second), place)
        if len(set(halved.regions[changed])) == 1:
            options.append(_Option(halved, changed, len(self.mesh.nodes)))
        found = []
        for option in options:
            nodes = option.mesh.nodes.copy()
            nodes[option.node] = self.origin + length * direction
            found.append(replace(option, mesh=replace(option.mesh, nodes=nodes)))
            if self.worth(found[-1], direction) >= GOOD:
                break
        return max(found, key=lambda option: self.worth(option, direction), default=None)

    def split(self, first: int, second: int, place: float, direction: Floats) -> Iterator[_Option]:
        """Split a side and its adjacent triangles where the direction crosses it."""
        new = len(self.mesh.nodes)
        halved, changed = split_side(self.mesh, self.stars, (first, second), place)
        option = _Option(halved, changed, new)
        if not self.is_wall(first, second) and len(set(halved.regions[changed])) == 1:
            length = float(np.hypot(*(halved.nodes[new] - self.origin)))
            option = self._with_best_length(option, length, direction)
        yield option

    def met(self, ends: tuple[int, int]) -> Iterator[_Option]:
        """Extend the crack to a node that may not move."""
        for node in ends:
            if self.fixed[node] and node != self.behind:
                yield _Option(self.mesh, np.empty(0, np.int64), node)

    def worth(self, option: _Option, direction: Floats) -> float:
        """Rate an option by the quality of its triangles up to `GOOD`, its length and direction."""
        worth = min(option.quality, GOOD)
        segment = option.mesh.nodes[option.node] - self.origin
        worth *= min(1.0, SNAP / max(SNAP, _angle(segment, direction)))
        extended = self._extended(option)
        if extended.is_tip(self.crack, self.end):
            worth *= min(1.0, float(np.hypot(*segment)) / (SHORT * self.size))
        return worth

    def release(self, option: _Option, asked: Floats) -> Release:
        """Extend the crack by the segment from the tip to the node of an option."""
        return Release(
            triangulation=self._extended(option),
            changed=option.changed,
            start=self.tip,
            end=option.node,
            deviation=_angle(option.mesh.nodes[option.node] - self.origin, asked),
            quality=option.quality,
        )

    def _around(self, node: int) -> Ints:
        """Half-edges that start at a node."""
        offsets, half_edges = self.stars
        return half_edges[offsets[node] : offsets[node + 1]]

    def _extended(self, option: _Option) -> Triangulation:
        pairs = option.mesh.cracks[self.crack]
        if self.end == 0:
            longer = np.vstack([[(option.node, self.tip)], pairs])
        else:
            longer = np.vstack([pairs, [(self.tip, option.node)]])
        return replace(option.mesh, cracks={**option.mesh.cracks, self.crack: longer})

    def _with_best_length(self, option: _Option, length: float, direction: Floats) -> _Option:
        """Place the node of an option on the direction, at the best of the trial lengths."""
        best: _Option | None = None
        for factor in LENGTHS:
            nodes = option.mesh.nodes.copy()
            nodes[option.node] = self.origin + factor * length * direction
            moved = replace(option, mesh=replace(option.mesh, nodes=nodes))
            if best is None or self.worth(moved, direction) > self.worth(best, direction):
                best = moved
            if self.worth(best, direction) >= GOOD:
                break
        assert best is not None
        return best


def _angle(vector: Floats, direction: Floats) -> float:
    """Angle between two vectors [deg], 0 to 180."""
    return float(np.degrees(abs(np.angle(complex(*vector) / complex(*direction)))))


def _halved(pairs: Ints, first: int, second: int, new: int) -> Ints:
    """Replace a pair of nodes, where it occurs, by the two pairs with a new node between them."""
    for a, b in ((first, second), (second, first)):
        at = np.flatnonzero((pairs[:, 0] == a) & (pairs[:, 1] == b))
        if at.size:
            return np.vstack([pairs[: at[0]], [(a, new), (new, b)], pairs[at[0] + 1 :]])
    return pairs
