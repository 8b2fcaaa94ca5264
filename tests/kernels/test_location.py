"""Search in a bucket grid, for points without a hint and where the walk is blocked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from structured import rectangle

from cfmpm.body.grid import build_grid
from cfmpm.kernels import location


def buckets(grid, cells):
    """Origin, size and shape of a bucket grid, and the triangles in its cells."""
    origin = grid.nodes.min(axis=0)
    shape = np.array(cells)
    size = np.ptp(grid.nodes, axis=0) / shape
    return (
        origin,
        size,
        shape,
        *location.fill_buckets(grid.nodes, grid.triangles, origin, size, shape),
    )


def search(grid, position, hints, cells=(5, 4)):
    hints = np.broadcast_to(hints, len(position)).astype(np.int64)
    places = buckets(grid, cells)
    return location.search_buckets(
        grid.nodes, grid.triangles, grid.twins, *places, hints, np.asarray(position, float)
    )


def plate(angle=0.0):
    """A rotated plate with a crack from its left edge, and its triangles above the crack."""
    grid = build_grid(rectangle(12, 8, 12.0, 8.0, shake=0.3, crack=(4, 0, 7)), "T3")
    above = grid.nodes[grid.triangles].mean(axis=1)[:, 1] > 4.0
    c, s = np.cos(angle), np.sin(angle)
    return replace(grid, nodes=grid.nodes @ np.array([[c, s], [-s, c]])), above


@pytest.mark.parametrize("cells", [(1, 1), (5, 4), (40, 40)])
@pytest.mark.parametrize("angle", [0.0, 0.5, 2.5])
@pytest.mark.parametrize("side", [0, 1])
def test_points_on_a_crack_stay_on_the_side_of_their_hint(side, angle, cells):
    """For any numbering of triangles, with hints near the crack and far away."""
    grid, above = plate(angle)
    wanted = above == (side == 0)
    faces = grid.crack_faces["crack_1"][:, side]
    ends = grid.nodes[grid.edge_nodes(faces)]
    for weight in (0.0, 0.3, 0.5):
        # Not the tip: it has no sides.
        x = ((1 - weight) * ends[:, 0] + weight * ends[:, 1])[1:-1]
        for hints in ((faces // 3)[1:-1], *np.flatnonzero(wanted)[[0, 9, 23, 40]]):
            found = search(grid, x, hints, cells)
            assert (found != location.OUTSIDE).all()
            assert wanted[found].all()
            for element, position in zip(found, x, strict=True):
                corners = grid.triangles[element]
                assert location.containment(grid.nodes, corners, position)[0] > -1e-12


@pytest.mark.parametrize("side", [0, 1])
def test_points_close_to_a_crack_are_found_where_they_are(side):
    """A hint on the other side does not move a point through the crack."""
    grid, above = plate()
    x = np.column_stack([np.linspace(0.1, 6.9, 30), np.full(30, 4.0)])
    x[:, 1] += 1e-5 if side == 0 else -1e-5
    for hint in (-1, np.flatnonzero(above)[5], np.flatnonzero(~above)[5]):
        found = search(grid, x, hint)
        assert (found != location.OUTSIDE).all()
        assert (above[found] == (side == 0)).all()


def test_without_a_hint_a_point_of_several_triangles_is_in_one_of_them():
    grid, _ = plate()
    found = search(grid, grid.nodes, -1)
    touching = (grid.nodes[grid.triangles[found]] == grid.nodes[:, None]).all(axis=2)
    assert touching.any(axis=1).all()


def test_points_outside_have_no_triangle():
    grid, _ = plate()
    x = [[-1e-6, 2.0], [12.001, 2.0], [3.0, 8.5], [np.nan, 1.0], [1.0, np.inf]]
    for hint in (-1, 0, 100):
        assert (search(grid, x, hint) == location.OUTSIDE).all()


def test_each_cell_lists_the_triangles_that_reach_into_it():
    grid, _ = plate(0.5)
    origin, size, shape, offsets, items = buckets(grid, (5, 4))
    assert offsets[-1] == len(items)
    corners = grid.nodes[grid.triangles]
    low, high = corners.min(axis=1), corners.max(axis=1)
    for i, j in np.ndindex(*shape):
        cell = i * shape[1] + j
        listed = items[offsets[cell] : offsets[cell + 1]]
        begin = origin + size * [i, j]
        # Clear of round-off at the borders of cells.
        reach = (high > begin + 1e-9).all(axis=1) & (low < begin + size - 1e-9).all(axis=1)
        assert set(np.flatnonzero(reach)) <= set(listed)
        touch = (high > begin - 1e-9).all(axis=1) & (low < begin + size + 1e-9).all(axis=1)
        assert set(listed) <= set(np.flatnonzero(touch))
