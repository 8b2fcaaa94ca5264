"""Rules for narrow gaps between lines, which would need elements as small as the gap."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString, Polygon

from cfmpm.scene.geometry import CLEAR, ON, BodyShape, shape_of
from cfmpm.scene.rules_body import Finding, at
from cfmpm.scene.shapes import XY, Side, sides_of

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Length along a line within which it may be close to another one, in units of the smallest gap
# allowed: lines that meet at 0.6 degrees or more are farther apart beyond it.
FAR = 200.0
STEP = 5.0  # distance of the points at which lines are compared, in the same units
# Relative to the size of the body: a border nearer than this to a corner is meant to pass it.
MEANT = 3.0 * ON
# Relative to the size of the body: OpenCASCADE merges points nearer than 1e-7 in the unit frame.
MERGED = 1e-7


def narrow_gaps(body: BodyShape) -> Iterator[Finding]:
    """Find lines that come close to themselves, and borders of regions close to another line.

    The number of triangles in a gap is about its length divided by its width. The smallest width
    allowed, `CLEAR` times the size of the body, limits that number.

    Parameters
    ----------
    body : BodyShape

    Yields
    ------
    (str, str)
        Dotted key in the expanded scene, and reason.
    """
    geometry = body.geometry
    outline = sides_of(geometry.outline)
    yield from _of_itself("geometry.outline", outline, body, full=True)
    for i, hole in enumerate(geometry.holes):
        if hole.polygon is not None:
            key = f"geometry.holes[{i}].polygon"
            yield from _of_itself(key, sides_of(hole.polygon), body, full=False)
    for i, region in enumerate(geometry.regions):
        if region.polygon is not None:
            key = f"geometry.regions[{i}].polygon"
            yield from _of_itself(key, sides_of(region.polygon), body)
    for i, crack in enumerate(geometry.cracks):
        key = f"geometry.cracks[{i}].points"
        yield from _of_itself(key, _segments(crack.points), body, closed=False)
    yield from _beside_regions(body)


def _segments(points: Sequence[XY]) -> list[Side]:
    return [Side(a, b) for a, b in pairwise(points)]


def _of_itself(
    key: str,
    sides: Sequence[Side],
    body: BodyShape,
    *,
    closed: bool = True,
    full: bool | None = None,
) -> Iterator[Finding]:
    """Find two points of a line that are close to each other but far apart along the line.

    Parameters
    ----------
    key : str
        Dotted key of the line.
    sides : sequence of Side
    body : BodyShape
    closed : bool
        Whether the last side ends at the start of the first.
    full : bool or None
        Whether only the inside (True) or only the outside (False) of a closed line is material: a
        gap without material needs no triangles. None: both.

    Yields
    ------
    (str, str)
        Dotted key, and reason.
    """
    chains = [side.points() for side in sides]
    number = np.repeat(np.arange(len(sides)), [len(chain) for chain in chains])
    points = np.array([point for chain in chains for point in chain] + [sides[-1].end])
    lines = shapely.linestrings(np.stack([points[:-1], points[1:]], axis=1))
    clear = CLEAR * body.size
    first, second = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=clear)
    step = np.abs(second - first)
    neighbours = (step == 1) | (closed & (step == len(lines) - 1))
    met = (step != 0) & (~neighbours | _folded(points, first, second))
    first, second, neighbours = first[met], second[met], neighbours[met]
    if len(first) == 0:
        return
    gaps = shapely.distance(lines[first], lines[second])
    far, middles = _furthest(lines, first, second, clear, closed=closed)
    wrong = far >= FAR * clear
    if full is not None:
        wrong &= shapely.contains_xy(Polygon(points), *middles.T) == full
    wrong |= ~neighbours & (gaps <= ON * body.size)
    if not wrong.any():
        return
    worst = int(np.flatnonzero(wrong)[np.argmin(gaps[wrong])])
    a, b = sorted((int(number[first[worst]]) + 1, int(number[second[worst]]) + 1))
    if neighbours[worst]:
        yield (
            key,
            f"folds back onto itself: the angle between sides {a} and {b} is below 0.6 degrees",
        )
        return
    between = shapely.shortest_line(lines[first[worst]], lines[second[worst]])
    x, y = shapely.get_coordinates(between).mean(axis=0)
    yield (
        key,
        f"sides {a} and {b} are {gaps[worst]:.2g} mm apart near {at((x, y))}; the smallest gap "
        f"allowed is {clear:.2g} mm",
    )


def _furthest(
    lines: NDArray[np.object_], first: Ints, second: Ints, clear: float, *, closed: bool
) -> tuple[Floats, Floats]:
    """Return how far apart along the line two segments can be and still be close to each other.

    Parameters
    ----------
    lines : (n,) array of LineString
        Segments of the line.
    first, second : (k,) int
        Pairs of segments with a distance below `clear`.
    clear : float
        Smallest distance allowed [mm].
    closed : bool
        Whether the line is closed.

    Returns
    -------
    far : (k,) float
        Largest distance along the line between points of the pair that are within `clear` [mm].
    middles : (k, 2) float
        Midpoint between these points [mm].
    """
    starts = np.concatenate([[0.0], np.cumsum(shapely.length(lines))])
    near = shapely.intersection(lines[first], shapely.buffer(lines[second], clear))
    far, middles = np.zeros(len(first)), np.zeros((len(first), 2))
    for end in (0, -1):
        place = shapely.get_point(near, end)
        known = np.flatnonzero(~shapely.is_missing(place))
        place, one, other = place[known], first[known], second[known]
        across = shapely.line_locate_point(lines[other], place)
        along = np.abs(
            starts[other] + across - starts[one] - shapely.line_locate_point(lines[one], place)
        )
        if closed:
            along = np.minimum(along, starts[-1] - along)
        opposite = shapely.line_interpolate_point(lines[other], across)
        further = along > far[known]
        here = known[further]
        far[here] = along[further]
        middles[here] = (
            0.5 * (shapely.get_coordinates(place) + shapely.get_coordinates(opposite))[further]
        )
    return far, middles


def _folded(
    points: Floats, first: NDArray[np.int64], second: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Whether consecutive segments turn by nearly 180 degrees."""
    ways = np.diff(points, axis=0)
    ways /= np.hypot(*ways.T)[:, None]
    return np.asarray((ways[first] * ways[second]).sum(axis=1) < -math.cos(4.0 / FAR))


def _beside_regions(body: BodyShape) -> Iterator[Finding]:
    """Find borders of regions close to the boundary, a crack or another border."""
    geometry = body.geometry
    others: list[tuple[str, Sequence[Side]]] = [("the outline", sides_of(geometry.outline))]
    others += [(str(hole.name), sides_of(shape_of(hole))) for hole in geometry.holes]
    others += [(str(c.name), _segments(body.snapped(c.points))) for c in geometry.cracks]
    for i, region in enumerate(body.snapped_regions()):
        border = sides_of(shape_of(region))
        for name, sides in others:
            found = _gap(border, sides, body)
            if found is not None:
                gap, place = found
                yield (
                    f"geometry.regions[{i}]",
                    f"{region.name} and {name} are {gap:.2g} mm apart near {at(place)}: they must "
                    f"coincide or be at least {CLEAR * body.size:.2g} mm apart",
                )
        others.append((f"region {region.name}", border))


def _gap(border: Sequence[Side], sides: Sequence[Side], body: BodyShape) -> tuple[float, XY] | None:
    """Return width [mm] and place of a gap between a border and a line that is too narrow."""
    clear, merged = CLEAR * body.size, MERGED * body.size
    one, other = ([_chords(side) for side in line] for line in (border, sides))
    # Chords are within half of `clear` of their arc.
    close = [shapely.dwithin(other, chords, 2.0 * clear) for chords in one]
    if not np.any(close):
        return None
    parts, gaps = [], []
    for side, near in zip(border, close, strict=True):
        if near.any():
            points = side.sampled(2 + math.ceil(side.length / (STEP * clear)))
            parts.append(points)
            gaps.append(
                np.min([s.distances(points) for s, c in zip(sides, near, strict=True) if c], axis=0)
            )
    points, gap = np.concatenate(parts), np.concatenate(gaps)
    beside = (gap > merged) & (gap <= clear) & shapely.contains_xy(body.polygon, *points.T)
    ends = np.flatnonzero(np.diff(np.concatenate([[0], beside, [0]])))
    if np.max(ends[1::2] - ends[::2], initial=0) > 0.5 * FAR / STEP:
        worst = int(np.argmin(np.where(beside, gap, np.inf)))
        return float(gap[worst]), (float(points[worst, 0]), float(points[worst, 1]))
    corners = np.array([end for side in sides for end in (side.start, side.end)])
    off = np.min([side.distances(corners) for side in border], axis=0)
    cut = (off > merged) & (off <= MEANT * body.size)
    if cut.any():  # the border would cut off an end of a side too short to keep its name
        worst = int(np.argmax(cut))
        return float(off[worst]), (float(corners[worst, 0]), float(corners[worst, 1]))
    all_of_one, all_of_other = (shapely.union_all(lines) for lines in (one, other))
    nearest = shapely.distance(all_of_one, all_of_other)
    if gap.min() <= merged or not merged < nearest <= clear:
        return None
    x, y = shapely.get_coordinates(shapely.shortest_line(all_of_one, all_of_other)).mean(axis=0)
    if not shapely.contains_xy(body.polygon, x, y):
        return None
    return float(nearest), (float(x), float(y))


def _chords(side: Side) -> LineString:
    return LineString([*side.points(), side.end])
