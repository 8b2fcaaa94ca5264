"""Triangulation of the body of a scene, with the names of its parts."""

from __future__ import annotations

import math
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Self

import numpy as np
import shapely
from shapely import contains_xy

from cfmpm.body.grid import Floats, Ints, Triangulation, signed_areas
from cfmpm.errors import MeshError
from cfmpm.meshing.drawing import (
    Drawing,
    Raw,
    Seeds,
    TooManyTrianglesError,
    mesh_drawing,
)
from cfmpm.meshing.session import gmsh_session, in_child
from cfmpm.meshing.sizes import GROWTH, grading_in, size_in, triangles_in
from cfmpm.scene.body import Circle, Crack, Geometry, Vertex
from cfmpm.scene.geometry import ON, BodyShape, polygon_of, shape_of, snap
from cfmpm.scene.mesh import Grading
from cfmpm.scene.model import Scene
from cfmpm.scene.shapes import XY, Side, anticlockwise, sides_of

# In the unit frame; OpenCASCADE merges points closer than 1e-7.
TOLERANCE = 1e-6
ELEMENTS_PER_TURN = 24
# Triangles, and sides of a drawing, that gmsh meshes in half a second; more are meshed in a child
# process, which can be ended and takes a tenth of a second more.
AT_ONCE, MOST_SIDES = 3.5e4, 300
MOST_ADDED = 2e5  # triangles that thin parts may add to a mesh at once: half a minute
# Smallest distance of a cut by a box from other points, relative to the size of the body: a box
# slightly larger than a side must not cause elements as small as the difference. Tractions are
# cut exactly in any case.
LEAST_CUT = 1e-3


@dataclass(frozen=True)
class Frame:
    """The unit frame: shifted and scaled so that the body has size one about the origin.

    OpenCASCADE and gmsh have absolute tolerances, and lose digits far from the origin.
    """

    centre: XY
    scale: float

    @classmethod
    def around(cls, body: BodyShape) -> Self:
        """The frame of a body."""
        x_min, y_min, x_max, y_max = body.outline.bounds
        return cls(((x_min + x_max) / 2, (y_min + y_max) / 2), body.size)

    def point(self, at: XY) -> XY:
        """Return a point [mm] in the unit frame."""
        return (at[0] - self.centre[0]) / self.scale, (at[1] - self.centre[1]) / self.scale

    def side(self, side: Side) -> Side:
        """Return a side [mm] in the unit frame."""
        through = None if side.through is None else self.point(side.through)
        return Side(self.point(side.start), self.point(side.end), through)

    def back(self, points: Floats) -> Floats:
        """Return points of the unit frame, (n, 2), in mm."""
        return points * self.scale + np.array(self.centre)


def triangulate_body(scene: Scene) -> Triangulation:
    """Triangulate the body of a scene that has a geometry or a family."""
    scene = snap(scene)
    body = BodyShape.of(scene)
    frame = Frame.around(body)
    size = size_in(body, scene)
    cuts = _box_cuts(scene, body)
    drawing = _drawing(scene, body, frame, cuts)
    seeds = [
        *_tip_seeds(scene, body, frame),
        *_hole_seeds(scene, body, frame),
        *_arc_seeds(body.geometry, size, frame),
    ]

    def mesh(most: float) -> Raw:
        with gmsh_session() as gmsh:
            return mesh_drawing(gmsh, drawing, size / frame.scale, seeds, most)

    many = triangles_in(body, scene)
    if many <= AT_ONCE and len(body.sides) + len(drawing.cracks) <= MOST_SIDES:
        with suppress(TooManyTrianglesError):
            return _named(scene, body, frame, mesh(AT_ONCE), cuts)
    try:
        raw = in_child(lambda: mesh(max(MOST_ADDED, many)))
    except TooManyTrianglesError as error:
        count, place, height = error.args
        x, y = frame.back(np.array(place))
        raise MeshError(
            f"the body is {height * frame.scale:.2g} thin near ({x:.6g}, {y:.6g}), where its grid "
            f"would need another {count:.0e} triangles: look for lines that nearly touch"
        ) from error
    return _named(scene, body, frame, raw, cuts)


def _drawing(scene: Scene, body: BodyShape, frame: Frame, cuts: list[XY]) -> Drawing:
    geometry = body.geometry

    def drawn(sides: Iterable[Side]) -> list[Side]:
        return [frame.side(side) for side in sides]

    # OpenCASCADE loses cracks in a face whose outline is clockwise.
    def line(shape: Circle | list[Vertex]) -> list[Side]:
        return drawn(anticlockwise(sides_of(shape)))

    return Drawing(
        [line(shape) for shape in (geometry.outline, *map(shape_of, geometry.holes))],
        [line(shape_of(region)) for region in geometry.regions],
        [side for crack in geometry.cracks for side in drawn(_segments(crack))],
        [
            *(frame.point(load.point) for load in scene.loads if load.point is not None),
            *map(frame.point, cuts),
        ],
    )


def _box_cuts(scene: Scene, body: BodyShape) -> list[XY]:
    """Points at which the boundary enters and leaves boxes of loads; they become nodes."""
    kept = [side.start for _, side in body.sides]
    kept += [load.point for load in scene.loads if load.point is not None]
    kept += [point for crack in body.geometry.cracks for point in crack.points]
    n_given = len(kept)
    clear = LEAST_CUT * body.size
    for box in (load.box for load in scene.loads if load.box is not None):
        low, high = np.min(box, axis=0) - ON * body.size, np.max(box, axis=0) + ON * body.size
        for axis, corner in product((0, 1), box):
            for _, side in body.sides:
                for point in side.crossings(axis, corner[axis]):
                    inside = low[1 - axis] <= point[1 - axis] <= high[1 - axis]
                    if inside and all(math.dist(point, other) > clear for other in kept):
                        kept.append(point)
    return kept[n_given:]


def _segments(crack: Crack) -> list[Side]:
    return [Side(a, b) for a, b in pairwise(crack.points)]


def _tip_seeds(scene: Scene, body: BodyShape, frame: Frame) -> list[Seeds]:
    tips = [frame.point(point) for _, _, point in body.tips]
    grading = grading_in(body, scene)
    if grading is None or not tips:
        return []
    return [Seeds(np.array(tips), grading.tip_size / frame.scale, grading.growth)]


def _hole_seeds(scene: Scene, body: BodyShape, frame: Frame) -> list[Seeds]:
    """Seeds along the holes, with the element size there as spacing."""
    size, grading = scene.mesh.hole_size, scene.mesh.grading
    if size is None or not body.holes:
        return []
    along = shapely.segmentize([hole.exterior for hole in body.holes.values()], size)
    points = [frame.point((x, y)) for x, y in shapely.get_coordinates(along)]
    growth = grading.growth if isinstance(grading, Grading) else GROWTH
    return [Seeds(np.array(points), size / frame.scale, growth)]


def _arc_seeds(geometry: Geometry, size: float, frame: Frame) -> list[Seeds]:
    """Seeds along arcs for which `size` is too coarse."""
    inner = [*map(shape_of, geometry.holes), *map(shape_of, geometry.regions)]
    along: dict[float, list[XY]] = {}
    for side in (side for shape in (geometry.outline, *inner) for side in sides_of(shape)):
        if side.through is not None:
            points = along.setdefault(math.tau * side.radius / ELEMENTS_PER_TURN, [])
            points += [frame.point(point) for point in (*side.points()[::10], side.end)]
    return [
        Seeds(np.array(points), arc_size / frame.scale, GROWTH)
        for arc_size, points in along.items()
        if arc_size < size
    ]


def _named(scene: Scene, body: BodyShape, frame: Frame, raw: Raw, cuts: list[XY]) -> Triangulation:
    """Assign the names of the scene to a mesh of its drawing, and set exact coordinates."""
    nodes = frame.back(raw.nodes)
    samples = np.stack([ends_and_middle for ends_and_middle, _ in raw.curves])

    def on(side: Side) -> Ints:
        """Node pairs on a side; nodes of a straight side are moved exactly onto it."""
        drawn = frame.side(side)
        pairs = _pairs_on(drawn, raw, samples)
        if side.through is None:
            here = np.unique(pairs)
            along = _along(drawn, raw.nodes[here])[:, None]
            nodes[here] = np.array(side.start) + along * np.subtract(side.end, side.start)
        return pairs

    edges: dict[str, list[Ints]] = {}
    for name, side in body.sides:
        edges.setdefault(name, []).append(on(side))
    cracks = {}
    for crack in body.geometry.cracks:
        parts = []
        for side in _segments(crack):
            here = np.unique(on(side))
            order = here[np.argsort(_along(frame.side(side), raw.nodes[here]))]
            parts.append(np.column_stack([order[:-1], order[1:]]))
        cracks[str(crack.name)] = np.concatenate(parts)

    points = {str(load.name): load.point for load in scene.loads if load.point is not None}
    exact = [
        *(point for crack in body.geometry.cracks for point in crack.points),
        *points.values(),
        *cuts,
        *(side.start for _, side in body.sides),
    ]
    for point in exact:
        nodes[_node_at(frame.point(point), raw)] = point

    if signed_areas(nodes[raw.triangles]).min() <= 0:
        raise MeshError("the grid has triangles without area: check for lines that nearly touch")
    return Triangulation(
        nodes,
        raw.triangles,
        _regions(body.geometry, frame, raw),
        ("body", *(region.name for region in body.geometry.regions)),
        {name: np.concatenate(pairs) for name, pairs in edges.items()},
        cracks,
        {name: _node_at(frame.point(point), raw) for name, point in points.items()},
        {str(c.name): c.uncounted for c in body.geometry.cracks if c.uncounted},
    )


def _pairs_on(side: Side, raw: Raw, samples: Floats) -> Ints:
    """Node pairs of the curves that lie on a side; gmsh's own assignment is incomplete.

    `samples` are the ends and the midpoint of all curves, (n, 3, 2).
    """
    near = np.flatnonzero(side.distances(samples[:, 1]) <= TOLERANCE)
    lies = (side.distances(samples[near].reshape(-1, 2)) <= TOLERANCE).reshape(-1, 3).all(axis=1)
    pairs = [raw.curves[i][1] for i in near[lies]]
    if not pairs or min(part.min() for part in pairs) < 0:
        raise MeshError("the grid does not follow all edges and cracks: do they leave the body?")
    return np.concatenate(pairs)


def _along(side: Side, points: Floats) -> Floats:
    """Positions of points (n, 2) along a straight side: 0 at its start, 1 at its end."""
    direction = np.subtract(side.end, side.start)
    return (points - np.array(side.start)) @ direction / (direction @ direction)


def _node_at(point: XY, raw: Raw) -> int:
    distance = np.linalg.norm(raw.nodes[raw.vertices] - np.array(point), axis=1)
    nearest = int(np.argmin(distance))
    if distance[nearest] > TOLERANCE:
        raise MeshError("the grid has no node at a corner, crack or load point: is it outside?")
    return int(raw.vertices[nearest])


def _regions(geometry: Geometry, frame: Frame, raw: Raw) -> Ints:
    """The region of each triangle; if regions overlap it is the last one."""
    # The largest triangle of each face is tested, since a small one at an arc may lie outside it.
    by_size = np.lexsort((signed_areas(raw.nodes[raw.triangles]), raw.surfaces))
    largest = by_size[np.cumsum(np.bincount(raw.surfaces)) - 1]
    x, y = frame.back(raw.nodes[raw.triangles[largest]].mean(axis=1)).T
    index = np.zeros(len(largest), dtype=np.int64)
    for i, region in enumerate(geometry.regions, 1):
        index[contains_xy(polygon_of(shape_of(region)), x, y)] = i
    return index[raw.surfaces]
