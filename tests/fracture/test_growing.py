"""What a body keeps of its growth: the energy that its segments took, and how far they are off."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cfmpm.body.body import Body
from cfmpm.body.grid import Floats
from cfmpm.build import build
from cfmpm.ending import RunEnded
from cfmpm.fracture.growing import release
from cfmpm.scene import scene_from_dict

AHEAD = np.array([1.0, 0.0])


def two_layers(below: float, above: float, crack: list[list[float]], **changes: Any) -> Body:
    """A plate of 12 mm x 8 mm, of two materials of one stiffness above and below y = 4 mm."""
    scene = {
        "name": "layers",
        "geometry": {
            "outline": [[0, 0], [12, 0], [12, 8], [0, 8]],
            "cracks": [{"name": "crack", "points": crack}],
            "regions": [
                {
                    "name": "upper",
                    "polygon": [[0, 4], [12, 4], [12, 8], [0, 8]],
                    "material": {"E": 1e4, "nu": 0.3, "g_c": above},
                }
            ],
        },
        "material": {"E": 1e4, "nu": 0.3, "g_c": below},
        "loads": [
            {"edge": "edge_1", "displacement": {"x": 0, "y": 0}},
            {"edge": "edge_3", "displacement": {"x": 0, "y": 0.1}},
        ],
        "mesh": {"element": "T3", "size": 1.0, "grading": "uniform"},
        "growth": {},
    }
    return build(scene_from_dict(scene | changes))


def grow(body: Body, *directions: Floats) -> Body:
    for direction in directions:
        body = release(body, {"crack": direction})
    return body


@pytest.mark.parametrize(("below", "above"), [(1.0, 3.0), (3.0, 1.0)])
def test_along_a_border_the_energy_of_the_weaker_material_is_spent(
    below: float, above: float
) -> None:
    body = grow(two_layers(below, above, [[0, 4], [3, 4]]), AHEAD, AHEAD, AHEAD)
    (tip,) = body.grid.tips
    np.testing.assert_allclose(tip.path[:, 1], 4.0, atol=1e-12)
    grown = tip.path[0, 0] - 3.0
    assert grown > 1.5
    assert body.grown.fracture_energy == pytest.approx(1.0 * grown, rel=1e-12)


@pytest.mark.parametrize(("y", "g_c"), [(2.0, 1.0), (6.0, 3.0)])
def test_inside_a_material_its_own_energy_is_spent(y: float, g_c: float) -> None:
    body = grow(two_layers(1.0, 3.0, [[0, y], [3, y]]), AHEAD, AHEAD)
    grown = body.grid.tips[0].path[0, 0] - 3.0
    assert body.grown.fracture_energy == pytest.approx(g_c * grown, rel=1e-12)
    assert body.grown.segments == {
        "crack": pytest.approx(np.hypot(*(body.grid.tips[0].path[0] - body.grid.tips[0].path[1])))
    }


def test_leaving_a_border_spends_the_energy_of_the_side_that_it_runs_into() -> None:
    for side, g_c in ((1.0, 3.0), (-1.0, 1.0)):
        direction = np.array([np.cos(0.8), side * np.sin(0.8)])
        body = grow(two_layers(1.0, 3.0, [[0, 4], [3, 4]]), direction)
        (length,) = body.grown.segments.values()
        assert body.grown.fracture_energy == pytest.approx(g_c * length, rel=1e-12)


def test_the_worst_of_all_segments_is_kept() -> None:
    """Of two tips of which one is asked to turn back, and of the segments before."""
    inner = [[4.0, 2.0], [7.0, 2.1]]
    body = two_layers(1.0, 3.0, inner)
    back = release(body, {"crack_start": AHEAD, "crack_end": AHEAD})
    assert back.grown.deviation == pytest.approx(180.0 - 100.0, abs=3.0)
    assert 0.0 < back.grown.quality < 1.0
    worst, after = back.grown.quality, back
    for _ in range(2):
        after = release(after, {"crack_end": AHEAD})
        assert after.grown.deviation < 1e-9
        assert after.grown.quality <= worst


def test_a_tip_that_another_has_run_into_runs_no_more() -> None:
    """Two tips of one increment, one grid segment apart: the first meets the second."""
    geometry = {
        "outline": [[0, 0], [12, 0], [12, 8], [0, 8]],
        "cracks": [
            {"name": "one", "points": [[0, 4], [5.5, 4]]},
            {"name": "two", "points": [[12, 4], [6.5, 4]]},
        ],
    }
    body = two_layers(1.0, 1.0, [], geometry=geometry)
    for _ in range(4):
        body = release(body, {tip.name: tip.tangent for tip in body.grid.tips})
        if not body.grid.tips:
            break
    assert not body.grid.tips
    assert len(body.grown.segments) == 1


def test_a_crack_that_meets_the_point_of_a_load_ends() -> None:
    loads = [
        {"edge": "edge_1", "displacement": {"x": 0, "y": 0}},
        {"name": "push", "point": [4, 2], "force": [0, 1]},
    ]
    body = two_layers(1.0, 3.0, [[0, 2], [3, 2]], loads=loads)
    with pytest.raises(RunEnded, match=r"^met push: "):
        grow(body, *[AHEAD] * 3)
