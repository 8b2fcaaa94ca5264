"""The body of a scene: its polygon, its crack tips, and points snapped to its boundary.

The functions take a scene with a geometry or a family; with a mesh file they raise ValueError.
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

# Distances relative to the size of the body. Coordinates are typed with about seven digits: a crack
# end nearer to the boundary than ON is meant to lie on it, and is snapped to it. A distance between
# ON and CLEAR is ambiguous and too small for the grid; `rules` refuses it.
ON = 1e-6
CLEAR = 1e-4


@dataclass(frozen=True)
class BodyShape:
    """Shapes of a geometry with all names, whose closed lines are valid.

    Polygons have chords in place of arcs, with an error of at most 1e-5 of the radius; distances
    to the boundary are exact. Lengths are in mm.

    Attributes
    ----------
    geometry : Geometry
    """

    geometry: Geometry

    @classmethod
    def of(cls, scene: Scene) -> Self:
        """Make the shapes of a scene with a geometry or a family.

        Raises
        ------
        ValueError
            If the scene has a mesh file.
        """
        return cls(geometry_of(scene))

    @cached_property
    def outline(self) -> Polygon:
        """Polygon of the outline, holes included."""
        return polygon_of(self.geometry.outline)

    @cached_property
    def holes(self) -> dict[str, Polygon]:
        """Polygons of the holes by name."""
        return {str(hole.name): polygon_of(shape_of(hole)) for hole in self.geometry.holes}

    @cached_property
    def polygon(self) -> BaseGeometry:
        """Area of the body: the outline less the holes."""
        return self.outline.difference(unary_union(list(self.holes.values())))

    @cached_property
    def size(self) -> float:
        """Longer side of the bounding box of the outline [mm]."""
        return body_size(self.geometry)

    @cached_property
    def sides(self) -> list[tuple[str, Side]]:
        """Sides of the outline and of the holes, each with the name of its edge."""
        outline = self.geometry.outline
        named = [(str(v.edge), side) for v, side in zip(outline, sides_of(outline), strict=True)]
        for hole in self.geometry.holes:
            named += [(str(hole.name), side) for side in sides_of(shape_of(hole))]
        return named

    @cached_property
    def cracks(self) -> dict[str, LineString]:
        """Lines of the cracks by name; crack mouths are snapped to the boundary."""
        return {str(c.name): LineString(self.snapped(c.points)) for c in self.geometry.cracks}

    @cached_property
    def tips(self) -> list[tuple[str, int, XY]]:
        """Crack tips, as returned by `tip_points`."""
        return [
            (str(crack.name), index, crack.points[index])
            for crack in self.geometry.cracks
            for index in (0, -1)
            if not self.is_on_boundary(crack.points[index])
        ]

    def nearest(self, point: XY) -> tuple[str, XY, float]:
        """Find the point of the boundary nearest to a point.

        Parameters
        ----------
        point : (float, float)
            [mm].

        Returns
        -------
        edge : str
            Name of its edge.
        nearest : (float, float)
            [mm].
        distance : float
            [mm].
        """
        if point not in self._nearest:
            found = ((name, side.nearest(point)) for name, side in self.sides)
            self._nearest[point] = min(
                ((name, at, math.dist(at, point)) for name, at in found), key=lambda f: f[2]
            )
        return self._nearest[point]

    @cached_property
    def _nearest(self) -> dict[XY, tuple[str, XY, float]]:
        """Results of `nearest`: the rules need those of the same few points many times."""
        return {}

    def is_on_boundary(self, point: XY) -> bool:
        """Whether a point is within `ON` times the size of the body from the boundary."""
        return self.nearest(point)[2] <= ON * self.size

    def snap(self, point: XY) -> XY:
        """Snap a point on the boundary within the tolerance `ON` to the boundary.

        Parameters
        ----------
        point : (float, float)
            [mm].

        Returns
        -------
        (float, float)
            The nearest corner if it is within the tolerance, otherwise the nearest point of the
            boundary; the point itself if it is not on the boundary [mm].
        """
        corner = min((side.start for _, side in self.sides), key=lambda at: math.dist(at, point))
        if math.dist(corner, point) <= ON * self.size:
            return corner
        return self.nearest(point)[1] if self.is_on_boundary(point) else point

    def snapped(self, points: list[XY]) -> list[XY]:
        """Return the points of a crack with its mouths snapped to the boundary [mm]."""
        return [self.snap(points[0]), *points[1:-1], self.snap(points[-1])]

    def snapped_regions(self) -> list[Region]:
        """Return the regions with their corners snapped to adjacent lines.

        A corner within `ON` times the size of the body from a line is moved onto it. The lines are,
        in the order of precedence, the boundary, the cracks, and the borders of earlier regions.
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
        """Snap a corner of a region to the boundary or one of the lines, corners first."""
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
    """Return the geometry of a scene with a geometry or a family, with all names.

    Raises
    ------
    ValueError
        If the scene has a mesh file.
    """
    geometry = expand(scene).geometry
    if geometry is None:
        raise ValueError(f"scene {scene.name}: a mesh file has no geometry before it is read")
    return geometry


def body_size(geometry: Geometry) -> float:
    """Return the longer side of the bounding box of the outline [mm]."""
    x_min, y_min, x_max, y_max = polygon_of(geometry.outline).bounds
    return float(max(x_max - x_min, y_max - y_min))


def body_polygon(scene: Scene) -> BaseGeometry:
    """Return the area of the body: the outline less the holes.

    Parameters
    ----------
    scene : Scene
        With a geometry or a family.

    Returns
    -------
    shapely.Polygon or shapely.MultiPolygon
        With chords in place of arcs, with an error of at most 1e-5 of the radius [mm].

    Raises
    ------
    ValueError
        If the scene has a mesh file.
    """
    return BodyShape.of(scene).polygon


def tip_points(scene: Scene) -> list[tuple[str, int, XY]]:
    """Return the crack tips: the crack ends inside the body.

    Parameters
    ----------
    scene : Scene
        With a geometry or a family.

    Returns
    -------
    list of (str, int, (float, float))
        Name of the crack; 0 for its first point, -1 for its last; coordinates [mm]. An end within
        `ON` times the size of the body from the boundary is a crack mouth and not returned.

    Raises
    ------
    ValueError
        If the scene has a mesh file.
    """
    return BodyShape.of(scene).tips


def snap(scene: Scene) -> Scene:
    """Expand the scene and snap crack mouths and load points to the boundary.

    Corners of regions are also snapped to cracks and to other regions. The tolerance is `ON` times
    the size of the body. A point is moved to a corner within the tolerance, otherwise to the
    nearest point of a side within the tolerance; other points are not moved.

    Parameters
    ----------
    scene : Scene
        With a geometry or a family.

    Returns
    -------
    Scene
        Expanded.

    Raises
    ------
    ValueError
        If the scene has a mesh file.
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
    """Return the circle or the corners of a hole or a region."""
    return part.circle or part.polygon or []


def polygon_of(shape: Circle | list[Vertex]) -> Polygon:
    """Return the area inside a closed line, with chords in place of arcs."""
    return Polygon(ring(sides_of(shape)))
