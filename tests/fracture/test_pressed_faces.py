"""Contact pressure of crack faces from their nodal forces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from structured import rectangle

from cfmpm.body.crack_faces import turning_of
from cfmpm.body.grid import build_grid
from cfmpm.fracture.pressed_faces import PressedFaces


@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("degrees", [0.0, 20.0, 90.0, 180.0])
def test_pressures_at_a_corner_turn_with_the_crack(degrees, element):
    """Forces of unequal pressures on both sides of the corner, in rotated bodies."""
    mesh = rectangle(8, 8, 8.0, 8.0, crack=(4, 0, 4))
    nodes = mesh.nodes.copy()
    ahead = nodes[:, 1] == 4.0
    nodes[ahead, 1] += 0.5 * np.clip(nodes[ahead, 0] - 2.0, 0.0, None)
    grid = build_grid(replace(mesh, nodes=nodes), element)
    (tip,) = grid.tips
    left = grid.edge_nodes(grid.crack_faces[tip.crack][:, 0])
    along = grid.nodes[left[:, 1]] - grid.nodes[left[:, 0]]
    across = np.column_stack([-along[:, 1], along[:, 0]])
    middle = grid.nodes[left[:, :2]].mean(axis=1)[:, 0]
    pressure = np.where(middle < 2.0, 3.0, 5.0)
    force = np.zeros_like(grid.nodes)
    shares = pressure[:, None, None] * across[:, None, :]
    np.add.at(force, left, shares * grid.element.side_weights[None, :, None])
    turn = np.radians(degrees)
    rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    turning = turning_of(grid, tip.crack, grid.nodes @ rotation - grid.nodes)
    found = PressedFaces.behind(grid, force @ rotation, tip, turning)
    # From the tip on, along the crack.
    far = found.place.mean(axis=1) > 2.0 * np.hypot(1.0, 0.5)
    expected = np.where(far, 3.0, 5.0)[:, None]
    np.testing.assert_allclose(found.pressure, np.tile(expected, (1, 2)), rtol=1e-12)
