"""Crack faces: the sign of their opening, also after a rotation of the body."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from structured import rectangle

from cfmpm.body.crack_faces import face_pairs, smallest_openings
from cfmpm.body.grid import Floats, Grid, build_grid

# From the left edge to the middle, along x.
GRID = build_grid(rectangle(8, 8, 8.0, 8.0, crack=(4, 0, 4)), "T6")
ABOVE = 4.0


def apart(grid: Grid, gap: float) -> Floats:
    """Displacement that opens the crack except at its tip."""
    pairs = face_pairs(grid, "crack_1")
    motion = np.zeros_like(grid.nodes)
    motion[pairs.left, 1] = 0.5 * gap
    motion[pairs.right, 1] = -0.5 * gap
    return motion


def test_left_is_above_a_crack_that_runs_to_the_right() -> None:
    pairs = face_pairs(GRID, "crack_1")
    np.testing.assert_allclose(pairs.normal, [[0.0, 1.0]] * len(pairs.left), atol=1e-15)
    touching = np.isin(GRID.elements, pairs.left).any(axis=1)
    centre = GRID.nodes[GRID.triangles].mean(axis=1)[touching]
    assert (centre[:, 1] > ABOVE).all()
    # The tip is one node: it has no partner.
    assert GRID.tips[0].node not in {*pairs.left, *pairs.right}


@pytest.mark.parametrize("gap", [0.2, -0.3, 0.0])
def test_opening_is_positive_where_faces_part(gap: float) -> None:
    motion = apart(GRID, gap)
    opening = face_pairs(GRID, "crack_1").opening(motion)
    np.testing.assert_allclose(opening, gap, atol=1e-15)
    assert smallest_openings(GRID, motion) == {"crack_1": pytest.approx(min(gap, 0.0))}


@pytest.mark.parametrize("gap", [0.2, -0.3])
@pytest.mark.parametrize("degrees", [30.0, 90.0, 180.0])
def test_at_finite_deformation_the_normal_turns_with_the_crack(gap: float, degrees: float) -> None:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turned = (GRID.nodes + apart(GRID, gap)) @ np.array([[c, s], [-s, c]])
    found = smallest_openings(GRID, turned - GRID.nodes, finite=True)
    assert found["crack_1"] == pytest.approx(min(gap, 0.0), abs=1e-14)


@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize(("rise", "corner"), [(0.1, False), (0.5, True)])
def test_a_corner_has_the_normals_of_both_sides(rise: float, corner: bool, element: str) -> None:
    """At a bend of only 6 degrees the normal is their mean, the direction of a uniform pressure."""
    mesh = rectangle(8, 8, 8.0, 8.0, crack=(4, 0, 4))
    nodes = mesh.nodes.copy()
    bend = int(np.flatnonzero((nodes == [2.0, ABOVE]).all(axis=1))[0])
    before = nodes[nodes[:, 1] == ABOVE]
    nodes[nodes[:, 1] == ABOVE, 1] += rise * np.clip(before[:, 0] - 2.0, 0.0, None)
    grid = build_grid(replace(mesh, nodes=nodes), element)
    pairs = face_pairs(grid, "crack_1")
    at = (grid.nodes[pairs.left] == nodes[bend]).all(axis=1)
    second = np.array([-rise, 1.0]) / np.hypot(rise, 1.0)
    if corner:
        np.testing.assert_allclose(pairs.normal[at], [[0.0, 1.0], second], atol=1e-15)
    else:
        total = np.array([0.0, 1.0]) + np.hypot(rise, 1.0) * second
        np.testing.assert_allclose(pairs.normal[at], [total / np.hypot(*total)], atol=1e-15)
    assert len(np.unique(pairs.left)) == len(pairs.left) - corner
