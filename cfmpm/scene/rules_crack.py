"""Rules for cracks: inside the body, separate from each other, and not cutting the body in two."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import shapely
from shapely import LineString, Point

from cfmpm.scene.body import Crack
from cfmpm.scene.geometry import CLEAR, ON, BodyShape
from cfmpm.scene.rules_body import Finding, at
from cfmpm.scene.shapes import XY

# Largest length of a crack within CLEAR of the boundary at its mouth, relative to the size of the
# body: a crack must leave the boundary at about three degrees or more.
LONGEST_NEAR_MOUTH = 20 * CLEAR
# Of the size of the body: distance of a point of the boundary that is computed, as one on an arc.
ROUND_OFF = 1e-12


def misplaced_cracks(body: BodyShape) -> Iterator[Finding]:
    """Find cracks that are not simple lines, leave the body, cross each other, or cut it in two.

    Parameters
    ----------
    body : BodyShape

    Yields
    ------
    (str, str)
        Dotted key in the expanded scene, and reason.
    """
    sound = []
    for i, crack in enumerate(body.geometry.cracks):
        key = f"geometry.cracks[{i}]"
        findings = list(_line(key, crack, body))
        if not findings:
            findings = list(_inside(key, crack, body))
        if not findings:
            sound.append((key, crack))
        yield from findings
    yield from _crossings(sound, body)
    yield from _cuts(sound, body)


def _line(key: str, crack: Crack, body: BodyShape) -> Iterator[Finding]:
    repeated = [
        i for i, (a, b) in enumerate(pairwise(crack.points), 1) if math.dist(a, b) <= ON * body.size
    ]
    for i in repeated:
        yield f"{key}.points[{i}]", f"repeats the previous point, {at(crack.points[i])}"
    if repeated:
        return
    length = body.cracks[str(crack.name)].length
    if crack.uncounted >= length:
        yield f"{key}.uncounted", f"must be less than the length of the crack, {length:g}"
    segments = [LineString(pair) for pair in pairwise(crack.points)]
    close = (
        shapely.distance(segments[i], segments[i + 2 :]).min() <= ON * body.size
        for i in range(len(segments) - 2)
    )
    if not body.cracks[str(crack.name)].is_simple or any(close):
        yield f"{key}.points", "the crack crosses or touches itself"


def _inside(key: str, crack: Crack, body: BodyShape) -> Iterator[Finding]:
    line, clear = body.cracks[str(crack.name)], CLEAR * body.size
    # At an arc, the chords of the polygon are within `clear` of the arc.
    outside = line.difference(body.polygon)
    if outside.length > clear:
        if outside.length >= line.length - clear:
            yield f"{key}.points", "lies outside the body"
            return
        holes = [name for name, h in body.holes.items() if line.intersection(h).length > clear]
        where = f"runs through {', '.join(holes)}" if holes else "leaves the body"
        worst = max(shapely.get_parts(outside), key=lambda part: part.length)
        yield f"{key}.points", f"{where} near {at(_middle(worst))}{_mouth(crack, worst, body)}"
        return
    near = line.intersection(body.polygon.boundary.buffer(clear))
    for part in shapely.get_parts(shapely.line_merge(near)):
        yield from _near_boundary(key, crack, part, body)


def _mouth(crack: Crack, outside: LineString, body: BodyShape) -> str:
    """Suggest the mouth of a crack that ends outside the body: the point on the boundary."""
    ends = [end for end in (0, -1) if outside.distance(Point(crack.points[end])) <= ON * body.size]
    if len(ends) != 1:
        return ""
    points = [Point(outside.coords[k]) for k in (0, -1)]
    mouth = max(points, key=lambda point: point.distance(Point(crack.points[ends[0]])))
    return f"; for a crack mouth, end the crack on the edge, at {at((mouth.x, mouth.y))}"


def _near_boundary(key: str, crack: Crack, part: LineString, body: BodyShape) -> Iterator[Finding]:
    """Check a part of a crack that is within `CLEAR` of the boundary."""
    tolerance = 2 * ON * body.size
    ends = {
        i: crack.points[i] for i in (0, -1) if part.distance(Point(crack.points[i])) < tolerance
    }
    tips = {i: point for i, point in ends.items() if not body.is_on_boundary(point)}
    name = body.nearest(_middle(part))[0]
    for i, point in tips.items():
        distance = body.nearest(point)[2]
        yield (
            f"{key}.points[{i % len(crack.points)}]",
            f"the crack end is {distance:.2g} mm from {name}; it must be on it, or at least "
            f"{CLEAR * body.size:.2g} mm away",
        )
    if not tips:
        if not ends:
            yield f"{key}.points", f"touches {name} between its ends, near {at(_middle(part))}"
        elif part.length > LONGEST_NEAR_MOUTH * body.size:
            yield f"{key}.points", f"lies along {name} near {at(_middle(part))}"


def _crossings(cracks: list[tuple[str, Crack]], body: BodyShape) -> Iterator[Finding]:
    for i, (key, crack) in enumerate(cracks):
        for _, other in cracks[:i]:
            pair = (body.cracks[str(c.name)] for c in (crack, other))
            if shapely.distance(*pair) <= CLEAR * body.size:
                yield key, f"crosses or touches {other.name}, which is not supported"


def _cuts(cracks: list[tuple[str, Crack]], body: BodyShape) -> Iterator[Finding]:
    """Find cracks from boundary to boundary that cut the body in two.

    A crack between a hole and the outline joins both to one closed line of the boundary. A crack
    between two points of one closed line severs a part of the body.
    """
    joined = {name: name for name in body.holes}  # the outline is one closed line, ""

    def line_of(point: XY) -> str:
        name = body.nearest(point)[0]
        while joined.get(name, "") not in (name, ""):
            name = joined[name]
        return joined.get(name, "")

    for key, crack in cracks:
        ends = [crack.points[0], crack.points[-1]]
        if all(body.is_on_boundary(end) for end in ends):
            one, other = map(line_of, ends)
            if one == other:
                yield key, f"cuts the body in two{moved_ends([crack], body)}"
            else:
                # A hole is joined to the outline, never the outline to a hole.
                joined[one or other] = other if one else one


def moved_ends(cracks: Sequence[Crack], body: BodyShape) -> str:
    """Name the crack ends that are taken to lie on the boundary, to which they are only close.

    Parameters
    ----------
    cracks : sequence of Crack
    body : BodyShape

    Returns
    -------
    str
        Continuation of a message; empty if there are none.
    """
    found = []
    for end in (crack.points[index] for crack in cracks for index in (0, -1)):
        name, _, distance = body.nearest(end)
        if ROUND_OFF * body.size < distance <= ON * body.size:
            x, y = end
            found.append(
                f"; the end ({x:.10g}, {y:.10g}) is {distance:.2g} mm from {name} and is taken to "
                f"lie on it; a tip must be at least {CLEAR * body.size:.2g} mm away"
            )
    return "".join(found)


def _middle(line: LineString) -> XY:
    point = line.interpolate(0.5, normalized=True)
    return point.x, point.y
