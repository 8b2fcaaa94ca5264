"""The body of a scene: its polygon, which crack ends are tips, and points put onto its boundary.

All functions take a scene with a geometry or a family; a mesh file has to be meshed first.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from shapely import Polygon

from cfmpm.scene.families import expand
from cfmpm.scene.model import Circle, Geometry, Hole, Region, Scene, Vertex
from cfmpm.scene.shapes import XY, Side, ring, sides_of

# Relative to the size of the body. Coordinates are typed with some seven digits, so that a crack
# end nearer to the boundary than ON was meant to lie on it, and is put there. Between ON and CLEAR
# nobody can say what was meant, and no grid could resolve it: the checks refuse it.
ON = 1e-6
CLEAR = 1e-4


def body_polygon(scene: Scene) -> Polygon:
    """The body without its holes, arcs as chords that are off by at most 1e-5 radii [mm]."""
    geometry = geometry_of(scene)
    holes = [ring(sides_of(shape_of(hole))) for hole in geometry.holes]
    return Polygon(ring(sides_of(geometry.outline)), holes)


def body_size(geometry: Geometry) -> float:
    """The longer side of the box around the outline [mm]."""
    x_min, y_min, x_max, y_max = Polygon(ring(sides_of(geometry.outline))).bounds
    return float(max(x_max - x_min, y_max - y_min))


def tip_points(scene: Scene) -> list[tuple[str, int, XY]]:
    """The crack ends inside the body.

    Returns
    -------
    list of (name, index, point)
        Name of the crack; 0 for its first point, -1 for its last; coordinates [mm]. An end that
        is nearer to the boundary than `ON` times the size of the body is a mouth and left out.
    """
    geometry = geometry_of(scene)
    tolerance = ON * body_size(geometry)
    sides = list(boundary(geometry))
    return [
        (str(crack.name), index, crack.points[index])
        for crack in geometry.cracks
        for index in (0, -1)
        if math.dist(nearest(sides, crack.points[index]), crack.points[index]) > tolerance
    ]


def snap(scene: Scene) -> Scene:
    """Expand the scene and put crack mouths and load points exactly onto the boundary.

    A point within `ON` times the size of the body goes to the nearest corner within that distance,
    or else to the nearest point of a side; any other point stays.
    """
    scene = expand(scene)
    geometry = geometry_of(scene)
    sides = list(boundary(geometry))
    tolerance = ON * body_size(geometry)

    def put(point: XY) -> XY:
        on_side = nearest(sides, point)
        corner = min((side.start for side in sides), key=lambda at: math.dist(at, point))
        return next((p for p in (corner, on_side) if math.dist(p, point) <= tolerance), point)

    cracks = [
        crack.model_copy(
            update={"points": [put(crack.points[0]), *crack.points[1:-1], put(crack.points[-1])]}
        )
        for crack in geometry.cracks
    ]
    loads = [
        load if load.point is None else load.model_copy(update={"point": put(load.point)})
        for load in scene.loads
    ]
    geometry = geometry.model_copy(update={"cracks": cracks})
    return scene.model_copy(update={"geometry": geometry, "loads": loads})


def geometry_of(scene: Scene) -> Geometry:
    """The geometry of a scene, with all names."""
    geometry = expand(scene).geometry
    if geometry is None:
        raise ValueError(f"scene {scene.name}: a mesh file has no geometry before it is read")
    return geometry


def shape_of(part: Hole | Region) -> Circle | list[Vertex]:
    """The circle or the corners of a hole or a region."""
    return part.circle or part.polygon or []


def boundary(geometry: Geometry) -> Iterator[Side]:
    """All sides of the outline and the holes."""
    for shape in (geometry.outline, *map(shape_of, geometry.holes)):
        yield from sides_of(shape)


def nearest(sides: list[Side], point: XY) -> XY:
    """The point on any of the sides that is nearest to `point` [mm]."""
    return min((side.nearest(point) for side in sides), key=lambda p: math.dist(p, point))
