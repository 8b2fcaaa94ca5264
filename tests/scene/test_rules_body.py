"""Refused and accepted outlines, holes and regions."""

from __future__ import annotations

import pytest
from scene_texts import LINE, assert_refused_once, plate

from cfmpm.scene import load_scene

OUTLINES = [
    ("[[0, 0], [10, 10], [10, 0], [0, 10]]", "", "crosses or touches itself near (5, 5)"),
    ("[[0, 0], [10, 0], [10, 10], [5, -2], [0, 10]]", "", "crosses or touches itself"),
    # two lobes that meet in one corner
    ("[[0, 0], [5, 5], [10, 0], [10, 9], [5, 5], [0, 9]]", "", "touches itself near (5, 5)"),
    # an arc that bulges through the opposite side
    ("[{at: [0, 0], through: [5, 12]}, [10, 0], [10, 10], [0, 10]]", "", "crosses or touches"),
    ("[[0, 0], [10, 0]]", "", "has 2 corners; needs at least three"),
    ("[{at: [0, 0], edge: a}, {at: [10, 0], edge: b}]", "", "has 2 corners; needs at least three"),
    ("[[0, 0], [10, 0], [20, 0]]", "", "encloses no area"),
    ("[[0, 0], [10, 10], [20, 20], [5, 5]]", "", "encloses no area"),
    ("[[0, 0], [10, 0], [10, 0], [0, 10]]", "[2]", "repeats the previous corner, (10, 0)"),
    ("[[0, 0], [10, 0], [10, 1.0e-9], [0, 10]]", "[2]", "repeats the previous corner"),
    ("[[0, 0], [10, 0], [0, 10], [0, 0]]", "[3]", "the line is closed without it"),
    ("[{at: [0, 0], through: [5, 0]}, [10, 0], [0, 10]]", "[0].through", "the arc is not defined"),
    (
        "[[0, 0], {at: [10, 0], through: [20, -10]}, [0, 10]]",
        "[1].through",
        "the arc is not defined",
    ),
    ("[{at: [0, 0], through: [0, 0]}, [10, 0], [0, 10]]", "[0].through", "is an end of the edge"),
    ("[{at: [0, 0], through: [10, 0]}, [10, 0], [0, 10]]", "[0].through", "is an end of the edge"),
    (
        "[{at: [0, 0], edge: a}, [9, 0], {at: [9, 9], edge: a}, [0, 9]]",
        "[2].edge",
        "also the name of side 1",
    ),
    (
        "[{at: [0, 0], edge: a}, [9, 0], {at: [9, 9], edge: a}, {at: [5, 9], edge: a}, [0, 9]]",
        "[2].edge",
        "only consecutive sides",
    ),
]
HOLES = [
    ("[{circle: {centre: [150, 30], radius: 5}}]", "[0]", "lies outside the body"),
    ("[{polygon: [[0, 70], [10, 70], [10, 80]]}]", "[0]", "lies outside the body"),
    ("[{circle: {centre: [100, 30], radius: 5}}]", "[0]", "crosses the outline"),
    ("[{polygon: [[50, 30], [60, 30], [55, 70]]}]", "[0]", "crosses the outline"),
    ("[{circle: {centre: [50, 30], radius: 200}}]", "[0]", "crosses the outline"),
    ("[{circle: {centre: [50, 10], radius: 9.9999}}]", "[0]", "touches the outline"),
    ("[{polygon: [[50, 30], [60, 30], [55, 59.999]]}]", "[0]", "touches the outline"),
    (
        "[{circle: {centre: [40, 30], radius: 5}}, {circle: {centre: [45, 30], radius: 5}}]",
        "[1]",
        "overlaps hole_1",
    ),
    (
        "[{name: big, circle: {centre: [40, 30], radius: 9}}, "
        "{polygon: [[38, 30], [42, 30], [40, 34]]}]",
        "[1]",
        "overlaps big",
    ),
    (
        "[{circle: {centre: [40, 30], radius: 5}}, {circle: {centre: [50, 30], radius: 5}}]",
        "[1]",
        "touches hole_1",
    ),
    (
        "[{polygon: [[10, 10], [20, 10], [20, 20]]}, {polygon: [[20, 20], [30, 20], [30, 30]]}]",
        "[1]",
        "touches hole_1",
    ),
    ("[{polygon: [[10, 10], [20, 20], [20, 10], [10, 20]]}]", "[0].polygon", "crosses or touches"),
    ("[{polygon: [[10, 10], [20, 20], [30, 30]]}]", "[0].polygon", "encloses no area"),
    ("[{polygon: [[10, 10], [20, 20]]}]", "[0].polygon", "needs at least three"),
    ("[{circle: {centre: [10, 10], radius: 1.0e-12}}]", "[0].circle.radius", "too small"),
    ("[{circle: {centre: [1.0e+8, 0], radius: 0.05}}]", "[0].circle.radius", "too small"),
    (
        "[{polygon: [{at: [10, 10], edge: a}, [20, 10], [20, 20]]}]",
        "[0].polygon[0].edge",
        "only sides of the outline",
    ),
    (
        "[{polygon: [[10, 10], [20, 10], {at: [20, 20], edge: top}]}]",
        "[0].polygon[2].edge",
        "only sides of the outline",
    ),
    ("[{name: top, circle: {centre: [10, 10], radius: 1}}]", "[0].name", "an edge of the outline"),
    ("[{name: left, circle: {centre: [10, 10], radius: 1}}]", "[0].name", "an edge of the outline"),
    (
        "[{name: a, circle: {centre: [10, 10], radius: 1}}, "
        "{name: a, circle: {centre: [20, 10], radius: 1}}]",
        "[1].name",
        "a is a name already in use",
    ),
    (
        "[{name: a, circle: {centre: [20, 10], radius: 1}}, "
        "{name: a, circle: {centre: [20, 11], radius: 1}}]",
        "[1].name",
        "a is a name already in use",
    ),
    ("[{name: a}]", "[0]", "needs either a circle or a polygon"),
    (
        "[{circle: {centre: [15, 12], radius: 1}, polygon: [[10, 10], [20, 10], [20, 20]]}]",
        "[0]",
        "needs either a circle or a polygon",
    ),
]
SOFT = "material: {E: 1, nu: 0}"
REGIONS = [
    (f"[{{name: a, {SOFT}, circle: {{centre: [50, 90], radius: 9}}}}]", "[0]", "outside the body"),
    (
        f"[{{name: a, {SOFT}, polygon: [[100, 0], [120, 0], [120, 60], [100, 60]]}}]",
        "[0]",
        "lies outside the body",
    ),
    (f"[{{name: a, {SOFT}, circle: {{centre: [50, 60], radius: 9}}}}]", "[0]", "partly outside"),
    (
        f"[{{name: a, {SOFT}, polygon: [[90, 0], [101, 0], [101, 60], [90, 60]]}}]",
        "[0]",
        "partly outside",
    ),
    (
        f"[{{name: a, {SOFT}, circle: {{centre: [50, 30], radius: 9}}}}, "
        f"{{name: b, {SOFT}, circle: {{centre: [50, 30], radius: 5}}}}]",
        "[1]",
        "overlaps region a",
    ),
    (
        f"[{{name: a, {SOFT}, circle: {{centre: [50, 30], radius: 9}}}}, "
        f"{{name: b, {SOFT}, polygon: [[50, 30], [70, 30], [70, 40]]}}]",
        "[1]",
        "overlaps region a",
    ),
    (f"[{{name: a, {SOFT}}}]", "[0]", "needs either a circle or a polygon"),
    (
        f"[{{name: a, {SOFT}, circle: {{centre: [50, 30], radius: 9}}, "
        "polygon: [[1, 1], [9, 1], [9, 9]]}]",
        "[0]",
        "needs either",
    ),
    (
        f"[{{name: body, {SOFT}, circle: {{centre: [50, 30], radius: 9}}}}]",
        "[0].name",
        "body is a name already in use",
    ),
    (
        f"[{{name: a, {SOFT}, circle: {{centre: [20, 30], radius: 9}}}}, "
        f"{{name: a, {SOFT}, circle: {{centre: [50, 30], radius: 9}}}}]",
        "[1].name",
        "a is a name already in use",
    ),
    (
        f"[{{name: a, {SOFT}, polygon: [[10, 10], [20, 20], [20, 10], [10, 20]]}}]",
        "[0].polygon",
        "crosses or touches itself",
    ),
    (
        f"[{{name: a, {SOFT}, polygon: [{{at: [1, 1], edge: b}}, [9, 1], [9, 9]]}}]",
        "[0].polygon[0].edge",
        "only sides of the outline",
    ),
]
TABLE = [
    *(("outline", *row) for row in OUTLINES),
    *(("holes", *row) for row in HOLES),
    *(("regions", *row) for row in REGIONS),
]


@pytest.mark.parametrize(("part", "text", "key", "fragment"), TABLE)
def test_refused(part: str, text: str, key: str, fragment: str, tmp_path) -> None:
    scene = plate(**{part: text})
    assert_refused_once(scene, tmp_path, f"geometry.{part}{key}", LINE[part], fragment)


GOOD = {
    "circle": {"outline": "[{at: [0, 0], through: [5, 5]}, {at: [10, 0], through: [5, -5]}]"},
    "half disc": {"outline": "[{at: [0, 0], through: [5, 5]}, [10, 0]]"},
    "clockwise": {"outline": "[[0, 0], [0, 60], [100, 60], [100, 0]]"},
    "sides in a row share a name, past the first corner": {
        "outline": "[{at: [0, 0], edge: a}, [9, 0], [9, 9], {at: [0, 9], edge: a}]"
    },
    "polygonal hole": {
        "holes": "[{polygon: [[10, 10], {at: [20, 10], through: [25, 15]}, [20, 20]]}]"
    },
    "region up to the outline": {
        "regions": f"[{{name: a, {SOFT}, polygon: [[0, 0], [50, 0], [50, 60], [0, 60]]}}]"
    },
    "regions side by side": {
        "regions": f"[{{name: a, {SOFT}, polygon: [[0, 0], [50, 0], [50, 60], [0, 60]]}}, "
        f"{{name: b, {SOFT}, polygon: [[50, 0], [100, 0], [100, 60], [50, 60]]}}]"
    },
    "ring around a hole": {
        "holes": "[{circle: {centre: [50, 30], radius: 5}}]",
        "regions": f"[{{name: a, {SOFT}, circle: {{centre: [50, 30], radius: 9}}}}]",
    },
}


@pytest.mark.parametrize("parts", GOOD.values(), ids=GOOD)
def test_accepted(parts: dict[str, str], tmp_path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(plate(**parts))
    assert load_scene(path).name == "plate"


def test_region_filled_by_a_hole_is_outside(tmp_path) -> None:
    text = plate(
        holes="[{circle: {centre: [50, 30], radius: 9}}]",
        regions=f"[{{name: a, {SOFT}, circle: {{centre: [50, 30], radius: 5}}}}]",
    )
    key = "geometry.regions[0]"
    assert_refused_once(text, tmp_path, key, LINE["regions"], "lies outside the body")
