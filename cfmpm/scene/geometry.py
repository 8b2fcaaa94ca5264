"""The body of a scene: its polygon, which crack ends are tips, and points put onto its boundary.

All functions take a scene with a geometry or a family; a mesh file has to be meshed first.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Self

from shapely import LineString, Polygon, unary_union
from shapely.geometry.base import BaseGeometry

from cfmpm.scene.body import Circle, Geometry, Hole, Region, Vertex
from cfmpm.scene.families import expand
from cfmpm.scene.model import Scene
from cfmpm.scene.shapes import XY, Side, ring, sides_of

# Relative to the size of the body. Coordinates are typed with some seven digits, so that a crack
# end nearer to the boundary than ON was meant to lie on it, and is put there. Between ON and CLEAR
# nobody can say what was meant, and no grid could resolve it: the rules refuse it.
ON = 1e-6
CLEAR = 1e-4


@dataclass(frozen=True)
class BodyShape:
    """A geometry with all names, whose closed lines are sound.

    The polygons have chords in place of arcs, off by at most 1e-5 radii; distances to the boundary
    are exact.
    """

    geometry: Geometry

    @classmethod
    def of(cls, scene: Scene) -> Self:
        """The body of a scene with a geometry or a family."""
        return cls(geometry_of(scene))

    @cached_property
    def outline(self) -> Polygon:
        """What the outline encloses, holes included."""
        return polygon_of(self.geometry.outline)

    @cached_property
    def holes(self) -> dict[str, Polygon]:
        """Each hole by its name."""
        return {str(hole.name): polygon_of(shape_of(hole)) for hole in self.geometry.holes}

    @cached_property
    def polygon(self) -> BaseGeometry:
        """The body without its holes."""
        return self.outline.difference(unary_union(list(self.holes.values())))

    @cached_property
    def size(self) -> float:
        """The longer side of the box around the outline [mm]."""
        return body_size(self.geometry)

    @cached_property
    def sides(self) -> list[tuple[str, Side]]:
        """All sides of the boundary with the names of their edges."""
        outline = self.geometry.outline
        named = [(str(v.edge), side) for v, side in zip(outline, sides_of(outline), strict=True)]
        for hole in self.geometry.holes:
            named += [(str(hole.name), side) for side in sides_of(shape_of(hole))]
        return named

    @cached_property
    def cracks(self) -> dict[str, LineString]:
        """Each crack by its name, its mouths exactly on the boundary."""
        return {str(c.name): LineString(self.snapped(c.points)) for c in self.geometry.cracks}

    @cached_property
    def tips(self) -> list[tuple[str, int, XY]]:
        """The crack ends inside the body, as `tip_points` gives them."""
        return [
            (str(crack.name), index, crack.points[index])
            for crack in self.geometry.cracks
            for index in (0, -1)
            if not self.is_on_boundary(crack.points[index])
        ]

    def nearest(self, point: XY) -> tuple[str, XY, float]:
        """Name of the nearest edge, the nearest point on it, and the distance [mm]."""
        found = ((name, side.nearest(point)) for name, side in self.sides)
        name, at, distance = min(
            ((name, at, math.dist(at, point)) for name, at in found), key=lambda f: f[2]
        )
        return name, at, distance

    def is_on_boundary(self, point: XY) -> bool:
        """Whether a point counts as on the boundary: nearer than `ON` times the size."""
        return self.nearest(point)[2] <= ON * self.size

    def snap(self, point: XY) -> XY:
        """Put a point that counts as on the boundary onto it, at a corner if one is as near."""
        corner = min((side.start for _, side in self.sides), key=lambda at: math.dist(at, point))
        if math.dist(corner, point) <= ON * self.size:
            return corner
        return self.nearest(point)[1] if self.is_on_boundary(point) else point

    def snapped(self, points: list[XY]) -> list[XY]:
        """The line of a crack with its mouths put onto the boundary."""
        return [self.snap(points[0]), *points[1:-1], self.snap(points[-1])]

    def snapped_regions(self) -> list[Region]:
        """The regions, with corners that count as on a line put onto it.

        The lines are the boundary, then cracks, then the regions before.
        """
        lines = [
            [Side(a, b) for a, b in pairwise(self.snapped(crack.points))]
            for crack in self.geometry.cracks
        ]
        found = []
        for region in self.geometry.regions:
            if region.polygon is not None:
                corners = [
                    corner.model_copy(update={"at": self._onto(corner.at, lines)})
                    for corner in region.polygon
                ]
                region = region.model_copy(update={"polygon": corners})
            found.append(region)
            lines.append(sides_of(shape_of(region)))
        return found

    def _onto(self, point: XY, lines: list[list[Side]]) -> XY:
        """Put a corner of a region onto the boundary or one of the lines, at a corner if near."""
        on = ON * self.size
        if self.is_on_boundary(point):
            return self.snap(point)
        for sides in lines:
            corner = min(
                (at for s in sides for at in (s.start, s.end)), key=lambda at: math.dist(at, point)
            )
            if math.dist(corner, point) <= on:
                return corner
            nearest = min((s.nearest(point) for s in sides), key=lambda at: math.dist(at, point))
            if math.dist(nearest, point) <= on:
                return nearest
        return point


def geometry_of(scene: Scene) -> Geometry:
    """The geometry of a scene with a geometry or a family, with all names."""
    geometry = expand(scene).geometry
    if geometry is None:
        raise ValueError(f"scene {scene.name}: a mesh file has no geometry before it is read")
    return geometry


def body_size(geometry: Geometry) -> float:
    """The longer side of the box around the outline [mm]."""
    x_min, y_min, x_max, y_max = polygon_of(geometry.outline).bounds
    return float(max(x_max - x_min, y_max - y_min))


def body_polygon(scene: Scene) -> BaseGeometry:
    """The body without its holes, arcs as chords that are off by at most 1e-5 radii [mm]."""
    return BodyShape.of(scene).polygon


def tip_points(scene: Scene) -> list[tuple[str, int, XY]]:
    """The crack ends inside the body.

    Returns
    -------
    list of (name, index, point)
        Name of the crack; 0 for its first point, -1 for its last; coordinates [mm]. An end that
        is nearer to the boundary than `ON` times the size of the body is a mouth and left out.
    """
    return BodyShape.of(scene).tips


def snap(scene: Scene) -> Scene:
    """Expand the scene and put crack mouths and load points exactly onto the boundary.

    Corners of regions are put onto cracks and other regions, too. A point within `ON` times the
    size of the body goes to the nearest corner within that distance, or else to the nearest point
    of a side; any other point stays.
    """
    body = BodyShape.of(scene)
    cracks = [
        crack.model_copy(update={"points": body.snapped(crack.points)})
        for crack in body.geometry.cracks
    ]
    scene = expand(scene)
    loads = [
        load if load.point is None else load.model_copy(update={"point": body.snap(load.point)})
        for load in scene.loads
    ]
    parts = {"cracks": cracks, "regions": body.snapped_regions()}
    geometry = body.geometry.model_copy(update=parts)
    return scene.model_copy(update={"geometry": geometry, "loads": loads})


def shape_of(part: Hole | Region) -> Circle | list[Vertex]:
    """The circle or the corners of a hole or a region."""
    return part.circle or part.polygon or []


def polygon_of(shape: Circle | list[Vertex]) -> Polygon:
    """What a closed line encloses."""
    return Polygon(ring(sides_of(shape)))
