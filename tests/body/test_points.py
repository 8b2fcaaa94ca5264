from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull
from structured import rectangle

from cfmpm.body.grid import build_grid
from cfmpm.body.points import locate, relocate, seed
from cfmpm.errors import SolveError
from cfmpm.kernels.location import OUTSIDE


def keeps_hull(corners, x):
    """Whether a point leaves the convex hull of a triangle as large as it is: it lies inside.

    The rule of section 2.3, three vertices of the hull, holds outside too: see below.
    """
    hull = ConvexHull(corners).volume
    return ConvexHull(np.vstack([corners, x])).volume <= hull * (1 + 1e-12)


@pytest.mark.parametrize("x", [(3.0, -1.0), (-1.0, -1.0)])
def test_three_vertices_of_the_hull_do_not_mean_inside(x):
    """The rule of section 2.3 as printed takes points behind a corner for points inside."""
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    assert len(ConvexHull(np.vstack([corners, x])).vertices) == 3
    assert not keeps_hull(corners, np.array(x))


def distance_to_triangles(corners, x):
    """Distance from each point to its triangle (..., 3, 2), 0 inside, by its sides."""
    sides, to = np.roll(corners, -1, axis=-2) - corners, x[..., None, :] - corners
    along = np.clip((to * sides).sum(axis=-1) / (sides**2).sum(axis=-1), 0, 1)
    gap = np.linalg.norm(along[..., None] * sides - to, axis=-1).min(axis=-1)
    cross = sides[..., 0] * to[..., 1] - sides[..., 1] * to[..., 0]
    return np.where((cross >= 0).all(axis=-1), 0.0, gap)


@pytest.mark.parametrize(("element", "count"), [("T3", 1), ("T6", 3)])
def test_seeded_points_fill_the_body(element, count):
    grid = build_grid(rectangle(7, 5, 3.0, 2.0, shake=0.5, crack=(2, 0, 3)), element)
    points = seed(grid)
    assert len(points) == count * len(grid.elements)
    assert points.volume.sum() == pytest.approx(6.0, rel=1e-14)
    np.testing.assert_array_equal(points.element, np.repeat(np.arange(70), count))
    # First moments: exact for any rule that integrates linear functions.
    np.testing.assert_allclose(points.volume @ points.position, [9.0, 6.0], rtol=1e-13)


def test_t6_points_are_centroids_of_the_paper_s_corner_triangles():
    grid = build_grid(rectangle(1, 1), "T6")
    corners, middles = grid.elements[0, :3], grid.elements[0, 3:]
    expected = [grid.nodes[[corners[k], middles[k], middles[k - 1]]].mean(axis=0) for k in range(3)]
    np.testing.assert_allclose(seed(grid).position[:3], expected, atol=1e-15)


@settings(max_examples=60)
@given(
    shake=st.floats(0, 0.45),
    rng=st.integers(0, 10_000),
    hinted=st.booleans(),
    shift=st.sampled_from([0.0, 1e3, -1e6]),
)
def test_every_point_is_found_in_the_triangle_that_contains_it(shake, rng, hinted, shift):
    grid = build_grid(rectangle(6, 5, shake=shake, crack=(2, 1, 4), seed=rng), "T3")
    draw = np.random.default_rng(rng)
    x = draw.uniform(-0.2, 1.2, (30, 2))
    grid.nodes[:] += shift
    x += shift
    hints = draw.integers(0, len(grid.elements), len(x)) if hinted else None
    found = locate(grid, x, hints)
    corners, inside = grid.nodes[grid.triangles], found != OUTSIDE
    assert (distance_to_triangles(corners, x[~inside, None]) > 0).all()
    gaps = distance_to_triangles(corners[found[inside]], x[inside])
    assert (gaps <= 1e-9 * (1 + abs(shift))).all()
    if shift == 0.0:
        for element, position in zip(found[inside], x[inside], strict=True):
            assert keeps_hull(corners[element], position)


@settings(max_examples=60)
@given(rng=st.integers(0, 10_000), weight=st.floats(0, 1), hinted=st.booleans())
def test_points_on_edges_and_vertices_are_never_lost(rng, weight, hinted):
    grid = build_grid(rectangle(6, 5, shake=0.5, crack=(2, 1, 4), seed=rng), "T3")
    corners = grid.nodes[grid.triangles]
    on_edges = (weight * corners + (1 - weight) * np.roll(corners, 1, axis=1)).reshape(-1, 2)
    hints = np.random.default_rng(rng).integers(0, len(corners), len(on_edges))
    found = locate(grid, on_edges, hints if hinted else None)
    assert (found != OUTSIDE).all()
    assert distance_to_triangles(corners[found], on_edges).max() < 1e-14


@pytest.mark.parametrize("side", [0, 1])
def test_a_point_on_a_crack_stays_on_the_side_of_its_hint(side):
    grid = build_grid(rectangle(12, 8, crack=(4, 0, 7)), "T3")
    faces = grid.crack_faces["crack_1"][:, side]
    ends = grid.nodes[grid.edge_nodes(faces)]
    for weight in (0.0, 0.3, 0.5):
        x = (1 - weight) * ends[:-1, 0] + weight * ends[:-1, 1]
        # Hints right at the face, and one cell behind it.
        above = grid.nodes[grid.triangles].mean(axis=1)[:, 1] > 0.5
        near = faces[:-1] // 3
        far = grid.twins[near].max(axis=1) // 3
        for hints in (near, far):
            found = locate(grid, x, hints)
            assert (found != OUTSIDE).all()
            assert (above[found] == (side == 0)).all()


def test_a_walk_blocked_by_a_crack_ends_in_the_right_place():
    grid = build_grid(rectangle(12, 8, crack=(4, 0, 10)), "T3")
    centroids = grid.nodes[grid.triangles].mean(axis=1)
    below = np.flatnonzero(centroids[:, 1] < 0.5)
    above = np.flatnonzero(centroids[:, 1] > 0.5)
    hints = np.resize(below, len(above))
    np.testing.assert_array_equal(locate(grid, centroids[above], hints), above)


def test_points_outside_and_not_finite_are_reported():
    grid = build_grid(rectangle(4, 4), "T3")
    x = np.array([[-1e-6, 0.5], [1.5, 0.5], [np.nan, 0.5], [0.5, np.inf], [0.5, 0.5]])
    for hints in (None, np.zeros(5, np.int64)):
        found = locate(grid, x, hints)
        assert (found[:4] == OUTSIDE).all()
        assert found[4] != OUTSIDE


def test_strongly_graded_grids_are_searched_too():
    triangulation = rectangle(40, 40)
    nodes = triangulation.nodes**6
    graded = build_grid(type(triangulation)(**{**triangulation.__dict__, "nodes": nodes}), "T3")
    centroids = graded.nodes[graded.triangles].mean(axis=1)
    np.testing.assert_array_equal(locate(graded, centroids), np.arange(len(centroids)))


def test_points_that_leave_the_grid_are_counted():
    grid = build_grid(rectangle(4, 3), "T6")
    points = seed(grid)
    np.testing.assert_array_equal(relocate(grid, points), points.element)
    points.position[[3, 7]] += 100.0
    with pytest.raises(SolveError, match=rf"2 of {len(points)} material points have left the grid"):
        relocate(grid, points)
