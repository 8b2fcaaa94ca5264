"""Rules for the closed lines of a body: outline, holes, regions.

Every public function yields a finding for each broken rule: the dotted key in the expanded scene,
and the reason.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from shapely import MultiPoint, Polygon, is_valid_reason

from cfmpm.scene.body import Circle, Geometry, Hole, Region, Vertex
from cfmpm.scene.geometry import CLEAR, ON, BodyShape, polygon_of, shape_of
from cfmpm.scene.shapes import XY

Finding = tuple[str, str]  # dotted key in the expanded scene, and reason


def broken_lines(geometry: Geometry) -> Iterator[Finding]:
    """Find outlines, holes and regions that are not simple closed lines around an area."""
    yield from _corners("geometry.outline", geometry.outline)
    for i, region in enumerate(geometry.regions):
        if (region.circle is None) == (region.polygon is None):
            yield f"geometry.regions[{i}]", "needs either a circle or a polygon"
        else:
            yield from _shape(f"geometry.regions[{i}]", region)
    for i, hole in enumerate(geometry.holes):
        yield from _shape(f"geometry.holes[{i}]", hole)


def misplaced_holes(body: BodyShape) -> Iterator[Finding]:
    """Find holes that are outside the body, touch or cross its outline, or overlap each other."""
    clear = CLEAR * body.size
    holes = list(body.holes.items())
    for i, (_, hole) in enumerate(holes):
        key = f"geometry.holes[{i}]"
        if not hole.intersects(body.outline):
            yield key, "lies outside the body"
        elif not hole.within(body.outline):
            yield key, "crosses the outline"
        elif hole.distance(body.outline.exterior) <= clear:
            yield key, "touches the outline; make it part of the outline instead"
        for other, shape in holes[:i]:
            if hole.distance(shape) <= clear:
                does = "overlaps" if hole.intersection(shape).area > 0 else "touches"
                yield key, f"{does} {other}"


def misplaced_regions(body: BodyShape) -> Iterator[Finding]:
    """Find regions that are not fully inside the body, or that overlap each other."""
    clear = CLEAR * body.size
    regions = [(r.name, polygon_of(shape_of(r))) for r in body.geometry.regions]
    for i, (_, region) in enumerate(regions):
        key = f"geometry.regions[{i}]"
        if region.intersection(body.polygon).area <= clear * region.length:
            yield key, "lies outside the body"
        elif not region.within(body.outline.buffer(clear)):
            yield key, "lies partly outside the body; let it end at the outline"
        for other, shape in regions[:i]:
            # Chords of two regions along one arc may differ: a thin sliver is not an overlap.
            if region.intersection(shape).area > clear * min(region.length, shape.length):
                yield key, f"overlaps region {other}"


def _shape(key: str, part: Hole | Region) -> Iterator[Finding]:
    if part.circle is not None:
        yield from _circle(f"{key}.circle", part.circle)
    if part.polygon is not None:
        yield from _corners(f"{key}.polygon", part.polygon)
    for i, corner in enumerate(part.polygon or []):
        if corner.edge is not None:
            yield f"{key}.polygon[{i}].edge", "only sides of the outline can have names"


def _circle(key: str, circle: Circle) -> Iterator[Finding]:
    if circle.radius <= 1e-9 * max(1.0, *map(abs, circle.centre)):
        yield (
            f"{key}.radius",
            f"{circle.radius:g} mm is too small: it is zero to round-off of the coordinates",
        )


def _corners(key: str, corners: list[Vertex]) -> Iterator[Finding]:
    if len(corners) < 3 and not (len(corners) == 2 and any(v.through for v in corners)):
        yield key, f"has {len(corners)} corners; needs at least three, or two and an arc"
        return
    findings = [f for i in range(len(corners)) for f in _side(key, corners, i)]
    yield from findings
    if findings:
        return
    polygon = polygon_of(corners)
    hull = MultiPoint(polygon.exterior.coords).convex_hull
    if hull.area <= ON * hull.length**2:
        yield key, "encloses no area: all its corners are on one line"
    elif not polygon.is_valid:
        yield key, f"crosses or touches itself{place_of_fault(polygon)}"


def _side(key: str, corners: list[Vertex], i: int) -> Iterator[Finding]:
    """Check the side from corner i to the next."""
    following = (i + 1) % len(corners)
    a, b, through = corners[i].at, corners[following].at, corners[i].through
    near = ON * _extent(corners)
    if math.dist(a, b) <= near:
        if following == 0:
            yield f"{key}[{i}]", f"repeats the first corner, {at(b)}; the line is closed without it"
        else:
            yield f"{key}[{following}]", f"repeats the previous corner, {at(a)}"
    elif through is not None:
        if min(math.dist(through, a), math.dist(through, b)) <= near:
            yield f"{key}[{i}].through", f"{at(through)} is an end of the edge"
        elif _height(a, b, through) <= ON * math.dist(a, b):
            yield (
                f"{key}[{i}].through",
                f"{at(through)} is on the straight line through the ends of the edge: the arc is "
                "not defined",
            )


def _extent(corners: list[Vertex]) -> float:
    points = [v.at for v in corners] + [v.through for v in corners if v.through]
    return max(max(c) - min(c) for c in zip(*points, strict=True))


def _height(a: XY, b: XY, point: XY) -> float:
    """Return the distance of a point from the straight line through a and b [mm]."""
    cross = (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])
    return abs(cross) / math.dist(a, b)


def place_of_fault(polygon: Polygon) -> str:
    """Return the place at which a polygon is not valid, as the end of a message.

    Parameters
    ----------
    polygon : shapely.Polygon
        Not valid.

    Returns
    -------
    str
        Such as " near (1, 2)"; empty if the place is not known.
    """
    reason = is_valid_reason(polygon)
    x, _, y = reason.partition("[")[2].rstrip("]").partition(" ")
    return f" near {at((float(x), float(y)))}" if y else ""


def at(point: XY) -> str:
    """Return the coordinates of a point as text for a message."""
    return f"({point[0]:.6g}, {point[1]:.6g})"
