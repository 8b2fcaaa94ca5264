from __future__ import annotations

import numpy as np
import pytest
import round_off
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull
from shapely.geometry.polygon import orient

from cfmpm.elements.record import find_element
from cfmpm.kernels import clipping

UNIT = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])


def convex(rng, n=8, scale=1.0):
    x = rng.uniform(-scale, scale, (n, 2))
    return x[ConvexHull(x).vertices]


def triangle(rng):
    x = rng.uniform(-1, 1, (3, 2))
    while abs(clipping.triangle_area(*x)) < 0.05:
        x = rng.uniform(-1, 1, (3, 2))
    return x if clipping.triangle_area(*x) > 0 else x[::-1].copy()


def clip_to(triangle, polygons, word="T3"):
    """Quadrature points of polygons in one triangle."""
    element = find_element(word)
    return clipping.clip_domains(
        triangle,
        np.arange(3)[None],
        element.points,
        element.weights,
        np.array([0]),
        np.array([p[0] for p in polygons]),
        np.vstack([p - p[0] for p in polygons]),
        np.cumsum([0] + [len(p) for p in polygons]),
        np.arange(len(polygons)),
    )


def second_moments(polygon):
    """Integrals of x x, x y, y y over a polygon (Green)."""
    x, y = polygon.T
    u, v = np.roll(polygon, -1, axis=0).T
    cross = x * v - u * y
    xx = (cross * (x * x + x * u + u * u)).sum() / 12
    yy = (cross * (y * y + y * v + v * v)).sum() / 12
    xy = (cross * (x * v + 2 * x * y + 2 * u * v + u * y)).sum() / 24
    return np.array([xx, xy, yy])


@settings(max_examples=200)
@given(seed=st.integers(0, 10**6), scale=st.sampled_from([0.2, 1.0, 5.0]))
def test_pieces_are_those_of_shapely(seed, scale):
    rng = np.random.default_rng(seed)
    corners, polygon = triangle(rng), convex(rng, scale=scale)
    expected = shapely.Polygon(corners).intersection(shapely.Polygon(polygon))
    _, _, position, volume = clip_to(corners, [polygon])
    area = shapely.Polygon(corners).area
    # Products of coordinates, of which the area is a small rest.
    far = max(np.abs(corners).max(), np.abs(polygon).max())
    error = round_off.of_sum(np.full(2 * len(polygon), far**2))
    assert volume.sum() == pytest.approx(expected.area, rel=0, abs=error)
    if expected.area > 1e-3 * area:
        np.testing.assert_allclose(position[0], np.ravel(expected.centroid.xy), atol=1e-12)


@settings(max_examples=100)
@given(seed=st.integers(0, 10**6), scale=st.sampled_from([0.2, 1.0, 5.0]))
def test_fan_integrates_quadratic_functions_exactly(seed, scale):
    rng = np.random.default_rng(seed)
    corners, polygon = triangle(rng), convex(rng, scale=scale)
    expected = shapely.Polygon(corners).intersection(shapely.Polygon(polygon))
    _, _, position, volume = clip_to(corners, [polygon], "T6")
    first, second = np.zeros(2), np.zeros(3)
    if expected.area > 0:
        first = expected.area * np.ravel(expected.centroid.xy)
        second = second_moments(np.array(orient(expected).exterior.coords)[:-1])
    x, y = position.T
    np.testing.assert_allclose(volume @ position, first, atol=1e-13)
    np.testing.assert_allclose(volume @ np.column_stack([x * x, x * y, y * y]), second, atol=1e-13)


@settings(max_examples=100)
@given(seed=st.integers(0, 10**6), word=st.sampled_from(["T3", "T6"]))
def test_pieces_lie_in_their_triangle_and_their_domain(seed, word):
    rng = np.random.default_rng(seed)
    corners = triangle(rng)
    polygons = [convex(rng, n) for n in (3, 5, 9)]
    # A domain that all but touches the triangle leaves a sliver, whose centroid is hard to keep in.
    polygons.append(corners + 1e-12 * rng.uniform(-1, 1, 2) + (corners[1] - corners[0]))
    owner, _, position, _ = clip_to(corners, polygons, word)
    for p, x in zip(owner, position, strict=True):
        for polygon in (corners, polygons[p]):
            for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
                assert clipping.triangle_area(a, b, x) > -1e-14


@pytest.mark.parametrize(
    ("polygon", "area"),
    [
        (UNIT, 0.5),
        (UNIT[[1, 2, 0]], 0.5),
        (np.array([[1.0, 0], [1, 1], [0, 1]]), 0),
        (np.array([[0.5, -0.5], [0.5, 0], [0, 0]]), 0),
        (np.array([[0.0, 0], [-1, 0], [0, -1]]), 0),
        (np.array([[2.0, 2], [3, 2], [2, 3]]), 0),
        (np.array([[0.0, 0], [0.5, 0], [0.5, 0.5], [0, 0.5]]), 0.25),
        (np.array([[-1.0, -1], [3, -1], [-1, 3]]), 0.5),
        (np.array([[0.2, 0.2], [0.4, 0.2], [0.2, 0.4]]), 0.02),
        (np.array([[0.0, 0], [1, 1], [0, 1]]), 0.25),
    ],
    ids=[
        "identical",
        "identical, turned",
        "shared edge",
        "part of an edge shared",
        "shared corner",
        "disjoint",
        "two edges in line",
        "around",
        "inside",
        "diagonal through a corner",
    ],
)
@pytest.mark.parametrize("word", ["T3", "T6"])
@pytest.mark.parametrize("shift", [0.0, 1e6])
def test_touching_polygons(polygon, area, word, shift):
    # The shift rounds coordinates; quarters survive it.
    exact = (4 * polygon == np.round(4 * polygon)).all()
    _, _, _, volume = clip_to(UNIT + shift, [polygon + shift], word)
    assert volume.sum() == pytest.approx(area, abs=1e-15 if exact or not shift else 1e-9)
    assert (len(volume) > 0) == (area > 0)


@settings(max_examples=100)
@given(seed=st.integers(0, 10**6))
def test_two_sides_of_a_line_make_the_whole(seed):
    rng = np.random.default_rng(seed)
    polygon, (a, b) = convex(rng), rng.uniform(-1, 1, (2, 2))
    parts = []
    for side in (1.0, -1.0):
        out = np.empty((2 * len(polygon), 2))
        parts.append(out[: clipping.clip(polygon, len(polygon), a, b, side, out)])
    areas = [clipping.area_and_centroid(part, len(part))[0] if len(part) else 0.0 for part in parts]
    whole = clipping.area_and_centroid(polygon, len(polygon))[0]
    assert sum(areas) == pytest.approx(whole, rel=1e-14)
    if min(areas) > 0:
        on_cut = {tuple(x) for x in parts[0]} & {tuple(x) for x in parts[1]}
        assert len(on_cut) == 2


@pytest.mark.parametrize("word", ["T3", "T6"])
def test_dust_goes_to_the_largest_piece(word):
    """A hundred strips, each below 1e-14 of the area, whose sum is far above round-off."""
    width, n = 4e-15, 100
    strip = np.array([[0.0, 0.0], [width, 0], [width, 0.5], [0, 0.5]])
    dust = [strip + np.array([i * width, 0.0]) for i in range(n)]
    rest = np.array([[n * width, 0.0], [1, 0], [1, 1], [n * width, 1]])
    owner, _, _, volume = clip_to(UNIT, [*dust, rest], word)
    np.testing.assert_array_equal(owner, n)
    # The largest of the pieces makes up for what is lost.
    assert volume.sum() == pytest.approx(0.5 - 0.5 * n * width, rel=0, abs=1e-15)


@pytest.mark.parametrize(
    ("a", "b", "cut"),
    [
        ((-1, 0.5), (2, 0.5), True),
        ((-1, 0.5), (0.1, 0.5), True),
        ((0.4, 0.5), (0.6, 0.5), True),
        ((-1, 0.5), (0, 0.5), False),
        ((-1, 0.5), (-0.1, 0.5), False),
        ((0, 0), (1, 0), False),
        ((-1, 0), (2, 0), False),
        ((0, 0), (1, 1), True),
        ((-1, -1), (0, 0), False),
        ((-1, 1), (1, -1), False),
        ((-1, 1e-10), (2, 1e-10), False),
        ((-1, 1e-8), (2, 1e-8), True),
        ((-1, 3), (2, 3), False),
    ],
    ids=[
        "through",
        "ends inside",
        "all inside",
        "ends at the border",
        "ends before",
        "one edge",
        "along an edge",
        "diagonal",
        "ends at a corner",
        "past a corner",
        "a sliver",
        "more than a sliver",
        "elsewhere",
    ],
)
@pytest.mark.parametrize("back", [False, True])
def test_which_domains_a_segment_cuts(a, b, cut, back):
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    ends = np.array([a, b], float)[:: -1 if back else 1]
    found = clipping.find_cut_domains(np.zeros((1, 2)), square, np.array([0, 4]), *ends)
    assert found[0] == cut
