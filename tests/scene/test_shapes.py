"""Straight and circular sides."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from shapely import LineString, Point, Polygon

from cfmpm.scene.body import Circle, Vertex
from cfmpm.scene.shapes import Side, arc_centre, polygon_area, ring, sides_of

coordinate = st.floats(-10, 10, width=32)
point = st.tuples(coordinate, coordinate)
angle = st.floats(0.1, 3.0)


def on_circle(centre: tuple[float, float], radius: float, turn: float) -> tuple[float, float]:
    return centre[0] + radius * math.cos(turn), centre[1] + radius * math.sin(turn)


@given(point, st.floats(0.1, 10), st.floats(-4, 4), angle, angle, st.sampled_from([1, -1]))
def test_arc(centre, radius, first, second, third, sense) -> None:
    """An arc is on its circle, contains its third point and has the length of its angle."""
    turns = [first, first + sense * second, first + sense * (second + third)]
    start, through, end = (on_circle(centre, radius, turn) for turn in turns)
    assume(min(math.dist(start, end), math.dist(start, through)) > 1e-3 * radius)
    assert arc_centre(start, through, end) == pytest.approx(centre, abs=1e-6)
    side = Side(start, end, through)
    line = [*side.points(), end]
    assert all(math.dist(p, centre) == pytest.approx(radius, rel=1e-6) for p in line)
    assert LineString(line).length == pytest.approx(radius * (second + third), rel=1e-3)
    assert math.dist(side.nearest(through), through) < 1e-6 * radius
    assert line[0] == start


@given(point, st.floats(0.1, 10), st.floats(-4, 4), angle, angle, point)
def test_nearest_point_is_that_of_the_fine_polygon(
    centre, radius, first, second, third, away
) -> None:
    turns = [first, first + second, first + second + third]
    start, through, end = (on_circle(centre, radius, turn) for turn in turns)
    assume(min(math.dist(start, end), math.dist(start, through)) > 1e-3 * radius)
    side = Side(start, end, through)
    line = LineString([*side.points(), end])
    distance = math.dist(side.nearest(away), away)
    assert distance == pytest.approx(line.distance(Point(away)), abs=2e-5 * radius)


@given(point, point, point)
def test_nearest_point_of_a_straight_side(start, end, away) -> None:
    assume(math.dist(start, end) > 1e-3)
    distance = math.dist(Side(start, end).nearest(away), away)
    assert distance == pytest.approx(LineString([start, end]).distance(Point(away)), abs=1e-9)


@given(point, st.floats(0.1, 10), st.floats(-4, 4), angle, angle, st.lists(point, max_size=9))
def test_distances_are_those_of_the_nearest_points(
    centre, radius, first, second, third, away
) -> None:
    turns = [first, first + second, first + second + third]
    start, through, end = (on_circle(centre, radius, turn) for turn in turns)
    assume(min(math.dist(start, end), math.dist(start, through)) > 1e-3 * radius)
    for side in (Side(start, end, through), Side(start, end)):
        found = side.distances(np.reshape(away, (-1, 2)))
        expected = [math.dist(side.nearest(p), p) for p in away]
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * (40 + radius))


@given(point, st.floats(0.1, 10), st.floats(-4, 4), angle, angle)
def test_length_is_that_of_the_fine_polygon(centre, radius, first, second, third) -> None:
    turns = [first, first + second, first + second + third]
    start, through, end = (on_circle(centre, radius, turn) for turn in turns)
    assume(min(math.dist(start, end), math.dist(start, through)) > 1e-3 * radius)
    assert Side(start, end, through).length == pytest.approx(radius * (second + third), rel=1e-6)
    assert Side(start, end).length == math.dist(start, end)
    assert Side(start, end, through).radius == pytest.approx(radius, rel=1e-6)
    assert Side(start, end).radius == math.inf


def test_crossings() -> None:
    upper = Side((5, 0), (-5, 0), (0, 5))
    np.testing.assert_allclose(upper.crossings(1, 4), [(-3, 4), (3, 4)], rtol=1e-14)
    np.testing.assert_allclose(upper.crossings(0, 3), [(3, 4)], rtol=1e-14)
    assert upper.crossings(1, -4) == upper.crossings(1, 5) == upper.crossings(0, 6) == []
    slope = Side((0, 0), (4, 2))
    assert slope.crossings(0, 1) == [(1, 0.5)]
    assert slope.crossings(1, 2) == [(4, 2)]
    assert slope.crossings(1, 3) == Side((0, 0), (4, 0)).crossings(1, 0) == []


def test_nearest_point_from_the_centre_is_on_the_arc() -> None:
    side = Side((1, 0), (-1, 0), (0, 1))
    assert math.hypot(*side.nearest((0, 0))) == pytest.approx(1)


@pytest.mark.parametrize("radius", [1e-3, 1.0, 1e6])
def test_circle(radius: float) -> None:
    circle = Circle(centre=(3, -2), radius=radius)
    polygon = Polygon(ring(sides_of(circle)))
    assert polygon.area == pytest.approx(math.pi * radius**2, rel=2e-5)
    assert polygon.is_valid


def test_flat_arc_keeps_to_its_chord_limit() -> None:
    side = Side((0, 0), (100, 0), (50, 0.1))
    points = side.points()
    assert len(points) >= 64
    assert max(y for _, y in points) == pytest.approx(0.1, rel=1e-3)


def test_corners_close() -> None:
    corners = [Vertex(at=(0, 0)), Vertex(at=(2, 0), through=(3, 1)), Vertex(at=(2, 2))]
    sides = sides_of(corners)
    assert [side.end for side in sides] == [(2, 0), (2, 2), (0, 0)]
    assert Polygon(ring(sides)).area == pytest.approx(2 + math.pi / 2, rel=1e-4)


def test_area_of_a_polygon_far_from_the_origin() -> None:
    corners = np.array([[0, 0], [4, 0], [4, 2], [1, 1], [0, 2]]) + 1e9
    assert polygon_area(corners) == 6.0
    assert polygon_area(corners[::-1]) == -6.0
