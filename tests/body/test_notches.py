"""Sharp notches of the boundary are found, and nothing else."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from cfmpm.body.notches import sharp_notches
from cfmpm.build import build
from cfmpm.output.warnings.of_scene import doubts_before
from cfmpm.scene import expand, scene_from_dict


def scene(outline: list[list[float]], **geometry: Any) -> dict[str, Any]:
    return {
        "name": "notched",
        "geometry": {"outline": outline, **geometry},
        "material": {"E": 1e3, "nu": 0.3},
        "loads": [
            {"name": "top", "box": [[-1, 19.9], [41, 20.1]], "displacement": {"y": 0.01}},
            {"name": "bottom", "box": [[-1, -0.1], [41, 0.1]], "displacement": {"x": 0, "y": 0}},
        ],
        "mesh": {"element": "T3", "size": 3},
    }


def wedge(width: float, depth: float = 12.0) -> list[list[float]]:
    """A plate with a wedge cut into its left side; the mouth is at (0, 10)."""
    low, high = [0, 10 - 0.5 * width], [0, 10 + 0.5 * width]
    return [[0, 0], [40, 0], [40, 20], [0, 20], high, [depth, 10], low]


@pytest.mark.parametrize("width", [0.5, 4.0, 12.0])
@pytest.mark.parametrize("reverse", [False, True])
def test_a_wedge_is_found(width: float, reverse: bool) -> None:
    outline = wedge(width)[:: -1 if reverse else 1]
    (notch,) = sharp_notches(build(scene_from_dict(scene(outline))).triangulation)
    np.testing.assert_allclose(notch.root, [12, 10], atol=1e-9)
    np.testing.assert_allclose(notch.mouth, [0, 10], atol=1e-9)
    assert notch.angle == pytest.approx(math.degrees(2 * math.atan(0.5 * width / 12.0)))


def test_wide_notches_corners_and_holes_are_none() -> None:
    corner = [[0, 0], [40, 0], [40, 20], [20, 20], [20, 10], [0, 10]]
    for outline in (corner, wedge(18.0)):
        assert sharp_notches(build(scene_from_dict(scene(outline))).triangulation) == []
    plate = [[0, 0], [40, 0], [40, 20], [0, 20]]
    holed = scene(plate, holes=[{"circle": {"centre": [20, 10], "radius": 3}}])
    assert sharp_notches(build(scene_from_dict(holed)).triangulation) == []


def test_a_notch_with_a_crack_at_its_root_is_meant() -> None:
    cracked = scene(wedge(2.0), cracks=[{"points": [[12, 10], [18, 10]]}])
    assert sharp_notches(build(scene_from_dict(cracked)).triangulation) == []


def test_what_it_would_be_as_a_crack() -> None:
    notched = scene_from_dict(scene(wedge(2.0)))
    (text,) = (t for t in doubts_before(expand(notched), build(notched)) if "notch" in t)
    assert "geometry.cracks: [{points: [[0, 10], [12, 10]]}]" in text
    assert "9.53 deg" in text
