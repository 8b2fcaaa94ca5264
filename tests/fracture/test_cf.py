"""Contribution of closed sliding crack faces to J."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from structured import rectangle

from cfmpm.body.crack_faces import face_pairs, turning_of
from cfmpm.body.grid import build_grid
from cfmpm.fracture import cf


@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("degrees", [0.0, 50.0])
@pytest.mark.parametrize("closed", [0, 1])
def test_a_corner_of_twelve_degrees_closed_on_one_side_counts_once(closed, degrees, element):
    """The pair has two normals; the force acts along one of them, on which the faces slide."""
    mesh = rectangle(16, 16, 8.0, 8.0, crack=(8, 0, 8))
    bend, nodes = np.radians(12.0), mesh.nodes.copy()
    ahead = nodes[:, 1] == 4.0
    nodes[ahead, 1] += np.tan(bend) * np.clip(nodes[ahead, 0] - 2.0, 0.0, None)
    grid = build_grid(replace(mesh, nodes=nodes), element)
    (tip,) = grid.tips
    pairs = face_pairs(grid, tip.crack)
    rows = np.flatnonzero((grid.nodes[pairs.left] == [2.0, 4.0]).all(axis=1))
    assert len(rows) == 2
    left, right = pairs.left[rows[0]], pairs.right[rows[0]]
    normal = pairs.normal[rows[closed]]
    force, slip = 7.0, 0.01
    forces, motion = np.zeros_like(grid.nodes), np.zeros_like(grid.nodes)
    forces[left], forces[right] = force * normal, -force * normal
    motion[left] = slip * np.array([-normal[1], normal[0]])
    radius, away = 4.0, 2.0 / np.cos(bend)
    # The turn of the path over the segments on both sides, the mean of which the corner has.
    first, second = 0.5, 0.5 / np.cos(bend)
    q = 2.0 - 2.0 * away / radius
    curvature = bend / (first + second)
    turn = np.radians(degrees)
    rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    moved = (grid.nodes + motion) @ rotation - grid.nodes
    turning = turning_of(grid, tip.crack, moved)
    found = cf.j_of_sliding(grid, tip, radius, forces @ rotation, moved, turning)
    assert abs(found) == pytest.approx(q * force * slip * curvature, rel=0.05)
