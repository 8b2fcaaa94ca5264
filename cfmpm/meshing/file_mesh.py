"""The triangulation of a mesh file with its names, and whether it is sound."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from shapely import Polygon, make_valid

from cfmpm.body.grid import Floats, Ints, signed_areas
from cfmpm.scene.rules_body import at, place_of_fault
from cfmpm.scene.shapes import polygon_area

# Area of a triangle in squares of its longest side that is round-off. Thinner triangles than any
# that can be solved with are told by the solver.
FLAT = 1e-15
# Relative difference between the areas of all triangles and of the outline: round-off.
AREA = 1e-9


@dataclass(frozen=True)
class FileMesh:
    """The content of a mesh file, with compact node numbers.

    Attributes
    ----------
    nodes : (n, 2) float
    triangles : (m, 3) int
        Anticlockwise.
    surfaces : dict of str to (k,) int
        Triangles of each physical surface.
    curves : dict of str to (k, 2) int
        Node pairs of each physical curve; -1 stands for a node in no triangle.
    """

    nodes: Floats
    triangles: Ints
    surfaces: dict[str, Ints]
    curves: dict[str, Ints]

    @cached_property
    def size(self) -> float:
        """The longer side of the box around all nodes [mm]."""
        return float(np.ptp(self.nodes, axis=0).max())

    @cached_property
    def sides(self) -> Ints:
        """The sides of all triangles as node pairs, (3 m, 2)."""
        return self.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)

    @cached_property
    def side_counts(self) -> tuple[Ints, Ints]:
        """The key of each side, and how many triangles share it."""
        return np.unique(self.keys(self.sides), return_counts=True)

    @cached_property
    def boundary(self) -> Ints:
        """Node pairs of the boundary, the body on the left, (k, 2)."""
        keys, counts = self.side_counts
        return self.sides[np.isin(self.keys(self.sides), keys[counts == 1])]

    def count_of(self, pairs: Ints) -> Ints:
        """How many triangles share each node pair, (k,)."""
        keys, counts = self.side_counts
        wanted = self.keys(pairs)
        at = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        return np.where((keys[at] == wanted) & (pairs >= 0).all(axis=1), counts[at], 0)

    def without(self, named: Iterable[Ints]) -> Ints:
        """Node pairs of the boundary that are in none of the parts given, (k, 2)."""
        keys = self.keys(self.boundary)
        rest = np.ones(len(keys), bool)
        for pairs in named:
            rest &= ~np.isin(keys, self.keys(pairs))
        return self.boundary[rest]

    @cached_property
    def on_boundary(self) -> Ints:
        """The nodes on the boundary, ascending."""
        return np.unique(self.boundary)

    def keys(self, pairs: Ints) -> Ints:
        """One number for each pair of nodes, the same in either sense."""
        return pairs.min(axis=1) * len(self.nodes) + pairs.max(axis=1)

    @cached_property
    def loops(self) -> list[Ints]:
        """The nodes of each closed line of the boundary: the outline first, then the holes."""
        following = dict(self.boundary.tolist())
        found = []
        while following:
            start, node = following.popitem()
            loop = [start]
            while node != start:
                loop.append(node)
                node = following.pop(node)
            found.append(np.array(loop))
        areas = [polygon_area(self.nodes[loop]) for loop in found]
        return [found[i] for i in np.argsort(areas)[::-1]]


def broken_triangles(mesh: FileMesh) -> Iterator[str]:
    """What makes single triangles useless, or neighbours of them."""
    longest = np.zeros(len(mesh.triangles))
    for k in range(3):
        side = mesh.nodes[mesh.triangles[:, k]] - mesh.nodes[mesh.triangles[:, k - 1]]
        longest = np.maximum(longest, (side**2).sum(axis=1))
    flat = int((signed_areas(mesh.nodes[mesh.triangles]) <= FLAT * longest).sum())
    if flat:
        yield f"{flat} triangles have no area"
    _, counts = mesh.side_counts
    if counts.max() > 2:
        n = int((counts > 2).sum())
        yield f"{n} edges belong to more than two triangles: is something twice?"
    elif not flat:
        # Anticlockwise neighbours on two sides of what they share pass it in opposite senses.
        senses, first = np.unique(
            mesh.sides[:, 0] * len(mesh.nodes) + mesh.sides[:, 1], return_index=True
        )
        if len(senses) < len(mesh.sides):
            twice = np.setdiff1d(np.arange(len(mesh.sides)), first)
            yield _tangled(mesh.nodes[mesh.sides[twice[0]]].mean(axis=0), len(twice))


def _tangled(place: Floats, n: int) -> str:
    x, y = place.tolist()
    return (
        f"is tangled: {n} pairs of neighbouring triangles lie over each other, the first near "
        f"{at((x, y))}; has a node been moved?"
    )


def parts_apart(mesh: FileMesh) -> Iterator[str]:
    """Pieces that share no node."""
    n = len(mesh.nodes)
    graph = coo_array((np.ones(len(mesh.sides), dtype=bool), mesh.sides.T), shape=(n, n))
    parts, _ = connected_components(graph, directed=False)
    if parts > 1:
        yield f"is in {parts} parts that share no nodes; merge equal nodes"


def broken_body(mesh: FileMesh) -> Iterator[str]:
    """What makes a body of sound triangles none: single shared nodes, overlap."""
    starts, times = np.unique(mesh.boundary[:, 0], return_counts=True)
    if (times > 1).any():
        x, y = mesh.nodes[starts[times > 1][0]].tolist()
        yield (
            f"hangs together by a single node at {at((x, y))}; surfaces that meet have to share "
            "all nodes there"
        )
        return
    outline, *holes = (mesh.nodes[loop] for loop in mesh.loops)
    body = Polygon(outline, holes)
    area = float(signed_areas(mesh.nodes[mesh.triangles]).sum())
    # Of an outline that crosses itself the area counts each part as often as it winds around.
    inside = body.area if body.is_valid else make_valid(body).area
    if abs(inside - area) > AREA * area:
        yield (
            "is tangled: triangles lie over each other (area of the triangles "
            f"{area:.6g} mm^2, inside of the outline {inside:.6g} mm^2)"
        )
    elif not body.is_valid:
        yield (
            f"has an outline that crosses or touches itself{place_of_fault(body)}; surfaces that "
            "meet have to share their nodes (gmsh: BooleanFragments, or Coherence)"
        )


def parts_without(mesh: FileMesh, pairs: Ints) -> int:
    """Into how many parts, joined by sides, the body falls along node pairs."""
    m = len(mesh.triangles)
    keys = mesh.keys(mesh.sides)
    order = np.argsort(keys, kind="stable")
    same = np.flatnonzero(keys[order][1:] == keys[order][:-1])
    kept = same[~np.isin(keys[order][same], mesh.keys(pairs))]
    joined = order[kept] // 3, order[kept + 1] // 3
    graph = coo_array((np.ones(len(kept), dtype=bool), joined), shape=(m, m))
    return int(connected_components(graph, directed=False)[0])
