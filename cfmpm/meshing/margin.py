"""A margin of the grid around a body and in its holes, into which material may move."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import ModuleType

import numpy as np
from shapely import LineString, Point, Polygon

from cfmpm.body.grid import Floats, Ints, Triangulation, signed_areas
from cfmpm.errors import MeshError
from cfmpm.kernels import topology
from cfmpm.meshing.session import gmsh_session, in_child
from cfmpm.scene.shapes import polygon_area

# Sides of the body, around which gmsh makes a margin in half a second; a larger one is made in a
# child process, which can be ended.
MOST_SIDES = 300


@dataclass(frozen=True)
class _Mouth:
    """An end of a crack at the margin, and the end of its extension there."""

    crack: str
    end: int
    node: int
    far: tuple[float, float]


def surround(body: Triangulation, margin: float, size: float) -> Triangulation:
    """Add a margin around a body, fill its holes, and extend cracks through both.

    Parameters
    ----------
    body : Triangulation
    margin : float
        Width of the margin [mm].
    size : float
        Element size at its outer side [mm]; at the body it is that of the body.

    Returns
    -------
    Triangulation
        Nodes and triangles of the body come first and keep their numbers. Cracks that start at a
        hole end at its centre.

    Raises
    ------
    MeshError
        If gmsh cannot mesh the margin.
    """
    loops = _loops(body)
    if sum(polygon_area(body.nodes[loop]) > 0.0 for loop in loops) != 1:
        raise MeshError("a fixed grid needs a body of one part; this one has several outlines")
    outline = next(loop for loop in loops if polygon_area(body.nodes[loop]) > 0.0)
    outer = Polygon(body.nodes[outline]).buffer(margin, join_style="mitre").exterior
    holes = [loop for loop in loops if loop is not outline]
    mouths = [
        mouth
        for crack, pairs in body.cracks.items()
        for mouth in _mouths(crack, pairs, body.nodes, outline, holes, outer)
    ]
    ring = list(outer.coords)[:-1]
    on_ring = [m.far for m in mouths if outer.distance(Point(m.far)) <= 1e-9 * outer.length]
    ring = sorted({*ring, *on_ring}, key=lambda at: outer.project(Point(at)))
    # gmsh has absolute tolerances.
    centre, scale = body.nodes.mean(axis=0), float(np.ptp(body.nodes, axis=0).max())

    def mesh() -> tuple[Floats, Ints, list[Ints]]:
        with gmsh_session() as gmsh:
            made = _Margin(gmsh, (body.nodes - centre) / scale, size / scale)
            made.around(outline, [_tuple((np.array(at) - centre) / scale) for at in ring])
            for hole in holes:
                made.inside(hole)
            for mouth in mouths:
                made.crack(mouth.node, _tuple((np.array(mouth.far) - centre) / scale))
            return made.mesh()

    many = sum(len(loop) for loop in loops) > MOST_SIDES
    nodes, triangles, lines = in_child(mesh) if many else mesh()
    nodes = nodes * scale + centre
    cracks = dict(body.cracks)
    for mouth, line in zip(mouths, lines, strict=True):
        pairs = cracks[mouth.crack]
        beyond = np.column_stack([line[:-1], line[1:]])
        cracks[mouth.crack] = (
            np.vstack([beyond[::-1, ::-1], pairs]) if mouth.end == 0 else np.vstack([pairs, beyond])
        )
    return replace(
        body,
        nodes=np.vstack([body.nodes, nodes]),
        triangles=np.vstack([body.triangles, triangles]),
        regions=np.concatenate([body.regions, np.zeros(len(triangles), np.int64)]),
        cracks=cracks,
    )


class _Margin:
    """Drawing in gmsh that keeps the sides of a body's triangles."""

    def __init__(self, gmsh: ModuleType, nodes: Floats, size: float) -> None:
        self._gmsh, self._nodes, self._size = gmsh, nodes, size
        self._points: dict[tuple[float, float], int] = {}
        self._of_body: dict[int, int] = {}
        self._sides: list[int] = []
        self._lines: list[tuple[int, int, int]] = []
        self._surface_at: dict[int, int] = {}

    def around(self, outline: Ints, ring: list[tuple[float, float]]) -> None:
        """Draw the margin between the outline of the body and a ring around it."""
        geo = self._gmsh.model.geo
        corners = [self._point(at) for at in ring]
        outer = [geo.addLine(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
        surface = geo.addPlaneSurface([geo.addCurveLoop(outer), self._loop(outline)])
        self._surface_at |= dict.fromkeys(outline.tolist(), int(surface))

    def inside(self, hole: Ints) -> None:
        """Draw the inside of a hole."""
        surface = self._gmsh.model.geo.addPlaneSurface([self._loop(hole)])
        self._surface_at |= dict.fromkeys(hole.tolist(), int(surface))

    def crack(self, node: int, far: tuple[float, float]) -> None:
        """Draw a line from a node of the body to a point, which becomes a line of sides."""
        line = self._gmsh.model.geo.addLine(self._body_point(node), self._point(far))
        self._lines.append((line, node, self._surface_at[node]))

    def mesh(self) -> tuple[Floats, Ints, list[Ints]]:
        """Return the new nodes, the triangles, and the nodes along each crack line."""
        gmsh = self._gmsh
        gmsh.model.geo.synchronize()
        for line, _, surface in self._lines:
            gmsh.model.mesh.embed(1, [line], 2, surface)
        for side in self._sides:
            gmsh.model.mesh.setTransfiniteCurve(side, 2)
        gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 1)
        gmsh.option.setNumber("Mesh.MeshSizeMax", self._size)
        try:
            gmsh.model.mesh.generate(2)
        except Exception as error:  # gmsh raises nothing more specific
            raise MeshError(
                f"gmsh could not mesh the margin ({error}): change updated.margin or mesh.size"
            ) from error
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        number = np.full(int(tags.max()) + 1, -1)
        for node, point in self._of_body.items():
            number[gmsh.model.mesh.getNodes(0, point)[0]] = node
        new = number[tags] < 0
        number[tags[new]] = len(self._nodes) + np.arange(np.count_nonzero(new))
        nodes = coordinates.reshape(-1, 3)[new, :2]
        triangles = number[gmsh.model.mesh.getElementsByType(2)[1].reshape(-1, 3)]
        turned = signed_areas(np.vstack([self._nodes, nodes])[triangles]) < 0.0
        triangles[turned] = triangles[turned, ::-1]
        lines = []
        for line, node, _ in self._lines:
            pairs = number[gmsh.model.mesh.getElementsByType(1, line)[1].reshape(-1, 2)]
            following = dict(pairs.tolist())
            chain = [node]
            while chain[-1] in following:
                chain.append(following[chain[-1]])
            lines.append(np.array(chain))
        return nodes, triangles, lines

    def _loop(self, nodes: Ints) -> int:
        geo = self._gmsh.model.geo
        points = [self._body_point(int(node)) for node in nodes]
        sides = [geo.addLine(a, b) for a, b in zip(points, points[1:] + points[:1], strict=True)]
        self._sides += sides
        return int(geo.addCurveLoop(sides))

    def _body_point(self, node: int) -> int:
        if node not in self._of_body:
            x, y = self._nodes[node]
            self._of_body[node] = int(self._gmsh.model.geo.addPoint(x, y, 0))
        return self._of_body[node]

    def _point(self, at: tuple[float, float]) -> int:
        if at not in self._points:
            self._points[at] = int(self._gmsh.model.geo.addPoint(*at, 0))
        return self._points[at]


def _loops(body: Triangulation) -> list[Ints]:
    """Closed lines of boundary nodes with the body on their left."""
    stars = topology.node_stars(body.triangles, len(body.nodes))
    twins = topology.find_twins(body.triangles, *stars)
    triangle, side = np.nonzero(twins < 0)
    start = body.triangles[triangle, side]
    following = dict(
        zip(start.tolist(), body.triangles[triangle, (side + 1) % 3].tolist(), strict=True)
    )
    if len(following) < len(start):
        raise MeshError("a fixed grid needs a boundary that does not touch itself")
    loops = []
    while following:
        loop = [next(iter(following))]
        while loop[-1] in following:
            loop.append(following.pop(loop[-1]))
        loops.append(np.array(loop[:-1]))
    return loops


def _tuple(point: Floats) -> tuple[float, float]:
    return float(point[0]), float(point[1])


def _mouths(
    crack: str, pairs: Ints, nodes: Floats, outline: Ints, holes: list[Ints], outer: LineString
) -> list[_Mouth]:
    """Find the ends of a crack on the boundary, and extend them straight ahead."""
    found = []
    for end, node, before in ((0, *pairs[0]), (-1, *pairs[-1, ::-1])):
        x = nodes[node]
        away = (x - nodes[before]) / np.hypot(*(x - nodes[before]))
        ray = LineString([x, x + outer.length * away])
        if node in outline:
            crossing = ray.intersection(outer)
            first = min(getattr(crossing, "geoms", [crossing]), key=Point(x).distance)
            found.append(_Mouth(crack, end, int(node), (first.x, first.y)))
        for hole in holes:
            if node in hole:
                chord = ray.intersection(Polygon(nodes[hole])).length
                half = x + 0.5 * chord * away
                found.append(_Mouth(crack, end, int(node), (float(half[0]), float(half[1]))))
    return found
