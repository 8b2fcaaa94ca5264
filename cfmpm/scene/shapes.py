"""Closed lines of straight sides and circular arcs: exact nearest points, and polygons."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cfmpm.scene.body import Circle, Vertex

XY = tuple[float, float]

# Number of chords of a full circle: their distance from the arc is at most 1e-5 of the radius.
POINTS_PER_CIRCLE = 720
# Smallest number of chords of an arc: a flat arc is short compared with its radius.
POINTS_PER_ARC = 64


@dataclass(frozen=True)
class Side:
    """One side of a closed line: a straight line, or a circular arc.

    Attributes
    ----------
    start, end : (float, float)
        [mm].
    through : (float, float) or None
        Third point of an arc [mm]; None for a straight line.
    """

    start: XY
    end: XY
    through: XY | None = None

    def points(self) -> list[XY]:
        """Return the corners of the chords of the side without its end [mm]."""
        if self.through is None:
            return [self.start]
        centre, sweep = self._arc(self.through)
        arm = complex(*self.start) - centre
        n = max(POINTS_PER_ARC, math.ceil(POINTS_PER_CIRCLE * abs(sweep) / math.tau))
        turned = [centre + arm * cmath.rect(1, sweep * i / n) for i in range(1, n)]
        return [self.start, *(_xy(z) for z in turned)]

    def sampled(self, n: int) -> NDArray[np.float64]:
        """Return `n` equidistant points of the side, both ends included, (n, 2) [mm]."""
        s = np.linspace(0.0, 1.0, n)
        a, b = complex(*self.start), complex(*self.end)
        if self.through is None:
            z = a + s * (b - a)
        else:
            centre, sweep = self._arc(self.through)
            z = centre + (a - centre) * np.exp(1j * sweep * s)
        return np.column_stack([z.real, z.imag])

    def nearest(self, point: XY) -> XY:
        """Return the point of the side nearest to `point` [mm]."""
        p, a, b = complex(*point), complex(*self.start), complex(*self.end)
        if self.through is None:
            along = ((p - a) * (b - a).conjugate()).real / abs(b - a) ** 2
            return _xy(a + (b - a) * min(max(along, 0), 1))
        centre, sweep = self._arc(self.through)
        if p == centre:
            return self.start
        turn = math.copysign(1, sweep) * cmath.phase((p - centre) / (a - centre)) % math.tau
        if turn <= abs(sweep):
            return _xy(centre + (p - centre) * (abs(a - centre) / abs(p - centre)))
        return min(self.start, self.end, key=lambda end: math.dist(end, point))

    def distances(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the distances from the side of points (n, 2), as (n,) [mm]."""
        p, a, b = points[:, 0] + 1j * points[:, 1], complex(*self.start), complex(*self.end)
        if self.through is None:
            along = ((p - a) * (b - a).conjugate()).real / abs(b - a) ** 2
            return np.abs(a + (b - a) * np.clip(along, 0, 1) - p)
        centre, sweep = self._arc(self.through)
        arm = a - centre
        turn = np.copysign(1, sweep) * np.angle((p - centre) / arm) % math.tau
        beside = np.abs(np.abs(p - centre) - abs(arm))
        return np.where(turn <= abs(sweep), beside, np.minimum(np.abs(p - a), np.abs(p - b)))

    def crossings(self, axis: int, value: float) -> list[XY]:
        """Return the points of the side with a given coordinate.

        Parameters
        ----------
        axis : int
            0 for x, 1 for y.
        value : float
            The coordinate [mm].

        Returns
        -------
        list of (float, float)
            [mm]; empty for a straight side on which the coordinate is constant.
        """
        if self.through is None:
            a, b = self.start, self.end
            if a[axis] == b[axis] or not min(a[axis], b[axis]) <= value <= max(a[axis], b[axis]):
                return []
            along = (value - a[axis]) / (b[axis] - a[axis])
            across = [a[1 - axis] + along * (b[1 - axis] - a[1 - axis])]
        else:
            centre, _ = self._arc(self.through)
            middle, radius = _xy(centre), abs(complex(*self.start) - centre)
            square = radius**2 - (value - middle[axis]) ** 2
            if square <= 0:
                return []
            across = [middle[1 - axis] + turn * math.sqrt(square) for turn in (-1, 1)]
        found = [(value, other) if axis == 0 else (other, value) for other in across]
        reach = 1e-9 * self.length
        return [point for point in found if math.dist(self.nearest(point), point) <= reach]

    @property
    def length(self) -> float:
        """Length of the side [mm]."""
        if self.through is None:
            return math.dist(self.start, self.end)
        return self.radius * abs(self._arc(self.through)[1])

    @property
    def radius(self) -> float:
        """Radius of an arc [mm]; infinite for a straight side."""
        if self.through is None:
            return math.inf
        return math.dist(arc_centre(self.start, self.through, self.end), self.start)

    def _arc(self, through: XY) -> tuple[complex, float]:
        """Return centre [mm] and angle from start to end, positive anticlockwise [rad]."""
        centre = complex(*arc_centre(self.start, through, self.end))
        start, middle, end = (complex(*p) - centre for p in (self.start, through, self.end))
        sweep = cmath.phase(end / start) % math.tau
        passes = cmath.phase(middle / start) % math.tau <= sweep
        return centre, sweep if passes else sweep - math.tau


def arc_centre(start: XY, through: XY, end: XY) -> XY:
    """Return the centre of the circle through three points that are not on one line [mm]."""
    a, b, c = (complex(*p) for p in (start, through, end))
    w = (c - a) / (b - a)
    return _xy(a + (b - a) * (w - abs(w) ** 2) / complex(0, 2 * w.imag))


def sides_of(shape: Circle | Sequence[Vertex]) -> list[Side]:
    """Return the sides of a circle (two arcs) or of a closed line given by its corners."""
    if isinstance(shape, Circle):
        (x, y), r = shape.centre, shape.radius
        west, east = (x - r, y), (x + r, y)
        return [Side(east, west, (x, y + r)), Side(west, east, (x, y - r))]
    following = [*shape[1:], *shape[:1]]
    return [Side(v.at, w.at, v.through) for v, w in zip(shape, following, strict=True)]


def anticlockwise(sides: Sequence[Side]) -> list[Side]:
    """Return the sides of a closed line in anticlockwise order."""
    if polygon_area(np.array(ring(sides))) > 0.0:
        return list(sides)
    return [Side(side.end, side.start, side.through) for side in reversed(sides)]


def polygon_area(corners: NDArray[np.float64]) -> float:
    """Return the area of a polygon by its corners (n, 2), negative if clockwise [mm^2]."""
    x, y = (corners - corners[0]).T
    return float(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def ring(sides: Sequence[Side]) -> list[XY]:
    """Return the corners of the polygon of a closed line, with chords for arcs [mm]."""
    return [point for side in sides for point in side.points()]


def _xy(z: complex) -> XY:
    return z.real, z.imag
