"""Crack tips, crack mouths, and points snapped to the boundary."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scene_texts import changed

from cfmpm.scene import Scene, body_polygon, expand, scene_from_dict, snap, tip_points
from cfmpm.scene.geometry import ON, BodyShape


def plate(cracks: list[Any], point: Any = (0, 0)) -> Scene:
    return scene_from_dict(
        changed(
            family=None,
            geometry={
                "outline": [[0, 0], [100, 0], [100, 60], [0, 60]],
                "holes": [{"circle": {"centre": [50, 30], "radius": 5}}],
                "cracks": [{"points": points} for points in cracks],
            },
            loads=[{"point": list(point), "force": [0, 1]}],
        )
    )


def test_tips_and_mouths() -> None:
    scene = plate(
        [[[0, 10], [20, 10]], [[20, 50], [0, 50]], [[55, 30], [70, 30]], [[80, 9], [90, 9]]]
    )
    assert tip_points(scene) == [
        ("crack_1", -1, (20, 10)),
        ("crack_2", 0, (20, 50)),
        ("crack_3", -1, (70, 30)),
        ("crack_4", 0, (80, 9)),
        ("crack_4", -1, (90, 9)),
    ]


@given(st.floats(0, 6.28), st.floats(-0.9, 0.9))
def test_mouth_near_an_arc_is_put_onto_it(turn: float, miss: float) -> None:
    radius = 5 + miss * ON * 100
    mouth = [50 + radius * math.cos(turn), 30 + radius * math.sin(turn)]
    scene = plate([[mouth, [50 + 15 * math.cos(turn), 30 + 15 * math.sin(turn)]]], mouth_away(turn))
    assert [index for _, index, _ in tip_points(scene)] == [-1]
    snapped = snap(scene).geometry
    assert snapped is not None
    at = snapped.cracks[0].points[0]
    assert math.dist(at, (50, 30)) == pytest.approx(5, rel=1e-14)
    assert math.dist(at, mouth) <= ON * 100


def mouth_away(turn: float) -> tuple[float, float]:
    """A point on the far side of the hole, with an error in the seventh digit."""
    return 50 - 5.0000003 * math.cos(turn), 30 - 5.0000003 * math.sin(turn)


def test_point_of_a_load_is_put_onto_the_boundary() -> None:
    for point, at in [
        ((99.99999, 20), (100, 20)),
        ((99.99999, 0.00001), (100, 0)),  # a corner goes before its sides
        ((20, 20), (20, 20)),
        ((54.99999999, 30), (55, 30)),
    ]:
        (load,) = snap(plate([], point)).loads
        assert load.point == at


def test_snap_leaves_the_rest_alone() -> None:
    scene = plate([[[0, 10], [20, 10], [30, 20]]])
    assert snap(scene) == expand(scene)
    assert snap(snap(scene)) == snap(scene)


def test_polygon_of_the_body() -> None:
    area = body_polygon(plate([])).area
    assert area == pytest.approx(6000 - 25 * math.pi, rel=1e-6)


def test_size_is_the_longer_side() -> None:
    assert BodyShape.of(plate([])).size == 100


def test_a_mesh_file_has_no_geometry(tmp_path) -> None:
    (tmp_path / "a.msh").touch()
    data = changed(family=None, mesh_file={"file": str(tmp_path / "a.msh")})
    scene = scene_from_dict(
        data | {"loads": [{"edge": "a", "traction": [0, 1]}, {"body_force": [0, 1]}]}
    )
    assert [load.name for load in expand(scene).loads] == ["a", "load_2"]
    with pytest.raises(ValueError, match="a mesh file has no geometry"):
        tip_points(scene)
