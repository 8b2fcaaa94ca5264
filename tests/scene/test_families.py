"""Families: geometry, equilibrium of the loads, names."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scene_texts import changed
from shapely import Point, box

from cfmpm.scene import Scene, body_polygon, expand, scene_from_dict, tip_points
from cfmpm.scene.body import Geometry
from cfmpm.scene.families import key_as_written
from cfmpm.scene.shapes import sides_of

RECTANGLE = {"width": 50.0, "height": 90.0}
FAMILIES: dict[str, dict[str, Any]] = {
    "single_edge": RECTANGLE | {"crack_length": 20, "traction": 3},
    "centre_crack": RECTANGLE | {"crack_length": 20, "crack_angle": 30, "traction": 3},
    "compact_tension": {"width": 50, "crack_length": 25, "force": 100},
    "three_point_bend": {
        "length": 20,
        "height": 8,
        "span": 18,
        "crack_length": 1.5,
        "crack_offset": -5,
        "holes": [{"centre": [6, 2.75], "radius": 0.25}],
        "force": 50,
    },
    "plate_with_holes": RECTANGLE
    | {
        "holes": [{"centre": [20, 20], "radius": 5}],
        "cracks": [{"points": [[0, 50], [10, 50]]}],
        "traction": 3,
    },
}


def specimen(kind: str, **parts: Any) -> Scene:
    return scene_from_dict(changed(family={"kind": kind} | FAMILIES[kind] | parts))


def geometry(scene: Scene) -> Geometry:
    found = expand(scene).geometry
    assert found is not None
    return found


def resultant(scene: Scene) -> tuple[np.ndarray, float]:
    """Force and moment about the origin of all tractions and forces [N/mm, N]."""
    force, moment = np.zeros(2), 0.0
    whole = expand(scene)
    assert whole.geometry is not None
    corners = whole.geometry.outline
    for load in whole.loads:
        if load.force is not None:
            assert load.point is not None
            at, f = np.array(load.point), np.array(load.force)
        elif load.traction is not None:
            (i,) = [i for i, v in enumerate(corners) if v.edge == load.edge]
            a, b = np.array(corners[i].at), np.array(corners[(i + 1) % 4].at)
            at, length = (a + b) / 2, math.dist(a, b)
            f = length * np.array(load.traction)
        else:
            continue
        force += f
        moment += at[0] * f[1] - at[1] * f[0]
    return force, moment


@pytest.mark.parametrize("kind", FAMILIES)
def test_edges_of_the_rectangle(kind: str) -> None:
    outline = geometry(specimen(kind)).outline
    assert [v.edge for v in outline] == ["bottom", "right", "top", "left"]
    assert outline[0].at == (0, 0)
    assert all(x >= 0 and y >= 0 for x, y in (v.at for v in outline))
    middles = {
        str(v.edge): np.add(v.at, w.at) / 2
        for v, w in zip(outline, outline[1:] + outline[:1], strict=True)
    }
    assert middles["bottom"][1] == 0
    assert middles["left"][0] == 0
    assert middles["top"][1] > 0
    assert middles["right"][0] > 0


@pytest.mark.parametrize("kind", ["single_edge", "centre_crack", "plate_with_holes"])
def test_traction_is_on_both_ends_and_in_equilibrium(kind: str) -> None:
    scene = expand(specimen(kind))
    assert {load.name: load.traction for load in scene.loads} == {"top": (0, 3), "bottom": (0, -3)}
    force, moment = resultant(scene)
    assert np.allclose(force, 0)
    assert moment == pytest.approx(0)


def test_single_edge_crack() -> None:
    assert geometry(specimen("single_edge")).cracks[0].points == [(0, 45), (20, 45)]
    higher = geometry(specimen("single_edge", crack_height=60))
    assert higher.cracks[0].points == [(0, 60), (20, 60)]


@pytest.mark.parametrize("angle", [-90, -30, 0, 45, 90])
def test_centre_crack(angle: float) -> None:
    (crack,) = geometry(specimen("centre_crack", crack_angle=angle)).cracks
    start, end = np.array(crack.points)
    assert (start + end) / 2 == pytest.approx([25, 45])
    assert math.dist(start, end) == pytest.approx(20)
    direction = math.degrees(math.atan2(*(end - start)[::-1]))
    assert direction == pytest.approx(angle)
    if abs(angle) == 90:
        assert start[0] == end[0], "an upright crack is upright to the last digit"


def test_compact_tension_is_that_of_astm_e399() -> None:
    scene = expand(specimen("compact_tension"))
    assert scene.geometry is not None
    w = 50.0
    assert scene.geometry.outline[2].at == pytest.approx((1.25 * w, 1.2 * w))
    pins = {str(hole.name): hole.circle for hole in scene.geometry.holes}
    assert list(pins) == ["pin_top", "pin_bottom"]
    assert pins["pin_top"].centre == pytest.approx((0.25 * w, 0.875 * w))
    assert pins["pin_bottom"].centre == pytest.approx((0.25 * w, 0.325 * w))
    assert all(pin.radius == 0.125 * w for pin in pins.values())
    assert scene.geometry.cracks[0].points == [(0, 0.6 * w), (0.25 * w + 25, 0.6 * w)]
    for load, sign in zip(scene.loads, (1, -1), strict=True):
        assert load.traction is not None
        assert load.traction[0] == 0
        assert load.box is not None
        pin = pins[str(load.name)]
        arc = Point(pin.centre).buffer(pin.radius, 720).exterior
        pressed = arc.intersection(box(*np.sort(load.box, axis=0).ravel()))
        # 60 degrees of the hole, about the direction of the pull.
        assert pressed.length == pytest.approx(pin.radius * math.pi / 3, rel=1e-3)
        assert pressed.centroid.x == pytest.approx(pin.centre[0])
        assert (pressed.centroid.y - pin.centre[1]) * sign > 0.9 * pin.radius
        assert load.traction[1] * pin.radius * math.pi / 3 == pytest.approx(sign * 100)
    assert scene.geometry.cracks[0].uncounted == 0.25 * w


def test_three_point_bend() -> None:
    scene = expand(specimen("three_point_bend"))
    assert scene.geometry is not None
    assert scene.geometry.cracks[0].points == [(5, 0), (5, 1.5)]
    assert [hole.name for hole in scene.geometry.holes] == ["hole_1"]
    loads = {load.name: load for load in scene.loads}
    assert list(loads) == ["support_left", "support_right", "force"]
    assert loads["support_left"].point == (1, 0)
    assert loads["support_right"].point == (19, 0)
    assert loads["force"].point == (10, 8)
    assert loads["force"].force == (0, -50)
    left, right = loads["support_left"].displacement, loads["support_right"].displacement
    assert left is not None
    assert right is not None
    assert (left.x, left.y, right.x, right.y) == (0, 0, None, 0)


def test_plate_with_holes() -> None:
    scene = specimen("plate_with_holes", cracks=[])
    assert tip_points(scene) == []
    assert body_polygon(scene).area == pytest.approx(50 * 90 - 25 * math.pi, rel=1e-5)


@pytest.mark.parametrize("kind", FAMILIES)
def test_own_loads_take_the_place_of_the_parameter(kind: str) -> None:
    parts = {k: v for k, v in FAMILIES[kind].items() if k not in ("traction", "force")}
    data = changed(family={"kind": kind} | parts, loads=[{"edge": "top", "displacement": {"y": 1}}])
    scene = scene_from_dict(data)
    assert scene.family is not None, "a scene remembers its family"
    assert [load.name for load in expand(scene).loads] == ["top"]
    assert expand(scene).family is None


@pytest.mark.parametrize("kind", FAMILIES)
def test_expansion_is_a_scene_and_final(kind: str) -> None:
    whole = expand(specimen(kind))
    assert expand(whole) == whole
    assert Scene.model_validate(whole.model_dump()) == whole


def test_default_names() -> None:
    data = changed(
        family=None,
        geometry={
            "outline": [[0, 0], {"at": [9, 0], "edge": "edge_1"}, [9, 9], [0, 9]],
            "holes": [
                {"circle": {"centre": [2, 2], "radius": 1}},
                {"name": "hole_1", "circle": {"centre": [5, 5], "radius": 1}},
            ],
            "cracks": [
                {"points": [[1, 7], [2, 7]]},
                {"name": "a", "points": [[3, 7], [4, 7]]},
                {"points": [[5, 7], [6, 7]]},
            ],
        },
        loads=[
            {"edge": "edge_3", "displacement": {"y": 0}},
            {"edge": "edge_3", "traction": [1, 0]},
            {"point": [0, 0], "displacement": {"x": 0}},
            {"name": "load_5", "edge": "hole_1", "traction": [0, 1]},
            {"body_force": [0, 1]},
        ],
    )
    whole = expand(scene_from_dict(data))
    assert whole.geometry is not None
    assert [v.edge for v in whole.geometry.outline] == ["edge_1_2", "edge_1", "edge_3", "edge_4"]
    assert [h.name for h in whole.geometry.holes] == ["hole_1_2", "hole_1"]
    assert [c.name for c in whole.geometry.cracks] == ["crack_1", "a", "crack_3"]
    names = [load.name for load in whole.loads]
    assert names == ["edge_3", "edge_3_2", "load_3", "load_5", "load_5_2"]


@given(st.lists(st.sampled_from([None, "crack_1", "crack_2", "crack_1_2", "a" * 64]), max_size=6))
def test_names_are_whole_and_explicit_ones_stay(names: list[str | None]) -> None:
    explicit = [name for name in names if name]
    cracks = [{"name": name, "points": [[i, 1], [i, 2]]} for i, name in enumerate(names)]
    square: dict[str, Any] = {"outline": [[-1, 0], [9, 0], [9, 9], [-1, 9]], "cracks": cracks}
    data = changed(family=None, geometry=square, loads=[{"body_force": [0, 1]}])
    found = [crack.name for crack in geometry(Scene.model_validate(data)).cracks]
    assert [new for new, name in zip(found, names, strict=True) if name] == explicit
    assert None not in found
    if len(set(explicit)) == len(explicit):
        assert len(set(found)) == len(found)


@pytest.mark.parametrize(
    ("kind", "key", "written"),
    [
        ("single_edge", "geometry.cracks[0].points[1]", "family.crack_length"),
        ("single_edge", "geometry.outline", "family"),
        ("single_edge", "loads[1].edge", "family.traction"),
        ("three_point_bend", "loads[0].point", "family.force"),
        ("three_point_bend", "geometry.holes[2].circle", "family.holes[2].circle"),
        ("compact_tension", "geometry.holes[1]", "family"),
        ("plate_with_holes", "geometry.cracks[0].points[1]", "family.cracks[0].points[1]"),
        ("plate_with_holes", "mesh.size", "mesh.size"),
    ],
)
def test_key_as_written(kind: str, key: str, written: str) -> None:
    assert key_as_written(specimen(kind), key) == written


def test_hole_is_a_circle_of_two_arcs() -> None:
    (hole,) = geometry(specimen("plate_with_holes")).holes
    assert hole.circle is not None
    assert len(sides_of(hole.circle)) == 2
