from __future__ import annotations

import numpy as np
import pytest

from cfmpm import build
from cfmpm.body.transfer import interpolate_displacement
from cfmpm.fracture import growing
from cfmpm.scene import expand
from cfmpm.scene.reading import scene_from_dict


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_fields_of_the_basis_are_carried_over_exactly(element):
    """Linear on T3, quadratic on T6; with a jump across the existing crack."""
    scene = scene_from_dict(
        {
            "name": "plate",
            "family": {"kind": "single_edge", "width": 50, "height": 80, "crack_length": 22},
            "material": {"E": 1e4, "nu": 0.3, "g_c": 1.0},
            "loads": [{"edge": "top", "traction": [0, 1]}, {"edge": "bottom", "traction": [0, -1]}],
            "mesh": {"element": element, "size": 8, "grading": "uniform"},
            "growth": {"direction": "cf"},
        }
    )
    start = build.build(scene)
    (tip,) = start.grid.tips
    grown = growing.release(expand(scene), start, {tip.name: np.array([0.9, 0.3])})

    def field(grid):
        x, y = grid.nodes.T
        power = 1 if element == "T3" else 2
        return np.column_stack([x**power - y, y**power + 2.0 * x])

    carried = interpolate_displacement(start.grid, field(start.grid), grown.grid)
    np.testing.assert_allclose(carried, field(grown.grid), atol=1e-9)

    faces = np.zeros_like(start.grid.nodes)
    pairs = start.grid.crack_faces[tip.crack]
    left = start.grid.edge_nodes(pairs[:, 0]).ravel()
    faces[left[left != tip.node]] = [0.0, 1.0]
    carried = interpolate_displacement(start.grid, faces, grown.grid)
    old = {tuple(x) for x in start.grid.nodes[left[left != tip.node]]}
    here = [i for i, x in enumerate(grown.grid.nodes) if tuple(x) in old]
    # Of each pair of nodes on the old faces the left one has moved, and the right one has not.
    wanted = np.repeat([0.0, 1.0], len(here) // 2)
    np.testing.assert_allclose(sorted(carried[here, 1]), wanted, atol=1e-9)
