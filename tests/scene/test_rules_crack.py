"""Refused and accepted cracks."""

from __future__ import annotations

import pytest
from scene_texts import LINE, assert_refused_once, family, plate, refused

from cfmpm.scene import load_scene

HOLE = "[{circle: {centre: [50, 30], radius: 5}}]"
TWO = "[{circle: {centre: [30, 30], radius: 5}}, {circle: {centre: [70, 30], radius: 5}}]"
REFUSED = [
    ("[{points: [[10, 70], [20, 70]]}]", "", "[0].points", "lies outside the body"),
    ("[{points: [[-20, 30], [-10, 30], [-5, 50]]}]", "", "[0].points", "lies outside the body"),
    ("[{points: [[48, 30], [52, 30]]}]", HOLE, "[0].points", "lies outside the body"),
    ("[{points: [[-1, 30], [10, 30]]}]", "", "[0].points", "leaves the body near (-0.5, 30)"),
    (
        "[{points: [[-1, 28], [9, 38]]}]",
        "",
        "[0].points",
        "near (-0.5, 28.5); for a crack mouth, end the crack on the edge, at (0, 29)",
    ),
    (
        "[{points: [[20, 30], [47, 30]]}]",
        HOLE,
        "[0].points",
        "hole_1 near (46, 30); for a crack mouth, end the crack on the edge, at (45, 30)",
    ),
    ("[{points: [[50, 30], [50, 61], [60, 30]]}]", "", "[0].points", "leaves the body"),
    ("[{points: [[30, 30], [70, 30]]}]", HOLE, "[0].points", "runs through hole_1 near (50, 30)"),
    ("[{points: [[30, 30], [50, 30]]}]", HOLE, "[0].points", "runs through hole_1"),
    ("[{points: [[10, 10], [20, 10], [20, 20], [15, 5]]}]", "", "[0].points", "itself"),
    ("[{points: [[10, 10], [20, 10], [20, 20], [15, 10]]}]", "", "[0].points", "touches itself"),
    ("[{points: [[10, 10], [20, 10], [20, 20], [10, 10]]}]", "", "[0].points", "touches itself"),
    ("[{points: [[10, 10], [20, 10], [15, 10]]}]", "", "[0].points", "touches itself"),
    ("[{points: [[10, 10], [10, 10]]}]", "", "[0].points[1]", "repeats the previous point"),
    (
        "[{points: [[10, 10], [13, 14]], uncounted: 5}]",
        "",
        "[0].uncounted",
        "must be less than the length of the crack, 5",
    ),
    ("[{points: [[10, 10], [13, 14]], uncounted: -1}]", "", "[0].uncounted", "at least 0"),
    (
        "[{points: [[10, 10], [20, 10], [20.00001, 10], [30, 20]]}]",
        "",
        "[0].points[2]",
        "repeats the previous point, (20, 10)",
    ),
    (
        "[{points: [[10, 10], [30, 10]]}, {name: b, points: [[20, 5], [20, 20]]}]",
        "",
        "[1]",
        "crosses or touches crack_1, which is not supported",
    ),
    (
        "[{name: a, points: [[10, 10], [30, 10]]}, {points: [[20, 10], [20, 20]]}]",
        "",
        "[1]",
        "crosses or touches a, which is not supported",
    ),
    ("[{points: [[20, 0], [40, 0]]}]", "", "[0].points", "lies along bottom"),
    ("[{points: [[20, 0], [30, 0], [40, 20]]}]", "", "[0].points", "lies along bottom"),
    (
        "[{points: [[0, 10], [30, 0.004]]}, {points: [[80, 9], [81, 9]]}]",
        "",
        "[0].points[1]",
        "it must be on it, or at least 0.01 mm away",
    ),
    (
        "[{points: [[20, 20], [20, 59.995]]}]",
        "",
        "[0].points[1]",
        "0.005 mm from top; it must be on it",
    ),
    ("[{points: [[44.997, 30], [30, 30]]}]", HOLE, "[0].points[0]", "0.003 mm from hole_1"),
    (
        "[{points: [[20, 20], [30, 0], [40, 20]]}]",
        "",
        "[0].points",
        "touches bottom between its ends",
    ),
    ("[{points: [[40, 35], [60, 35]]}]", HOLE, "[0].points", "touches hole_1 between its ends"),
    ("[{points: [[0, 30], [100, 30]]}]", "", "[0]", "cuts the body in two"),
    ("[{points: [[20, 0], [30, 10], [40, 0]]}]", "", "[0]", "cuts the body in two"),
    ("[{points: [[55, 30], [65, 30], [65, 45], [50, 45], [50, 35]]}]", HOLE, "[0]", "in two"),
    ("[{points: [[0, 30], [45, 30]]}, {points: [[55, 30], [100, 30]]}]", HOLE, "[1]", "in two"),
    (
        "[{points: [[0, 30], [25, 30]]}, {points: [[35, 30], [65, 30]]}, "
        "{points: [[75, 30], [100, 30]]}]",
        TWO,
        "[2]",
        "cuts the body in two",
    ),
    (
        "[{points: [[0, 30], [99.99999, 30]]}]",
        "",
        "[0]",
        "cuts the body in two; the end (99.99999, 30) is 1e-05 mm from right and is taken to lie "
        "on it; a tip must be at least 0.01 mm away",
    ),
    (
        "[{name: a, points: [[10, 10], [30, 10]]}, {name: a, points: [[10, 20], [30, 20]]}]",
        "",
        "[1].name",
        "a is a name already in use",
    ),
    (
        "[{name: a, points: [[0, 10], [20, 10]]}, {name: a, points: [[0, 40], [20, 40]]}]",
        "",
        "[1].name",
        "a is a name already in use",
    ),
    (
        "[{name: crack_1, points: [[10, 9], [30, 9]]}, {points: [[10, 20], [30, 20]]}, "
        "{name: crack_1, points: [[10, 40], [30, 40]]}]",
        "",
        "[2].name",
        "crack_1 is a name already in use",
    ),
]


@pytest.mark.parametrize(("cracks", "holes", "key", "fragment"), REFUSED)
def test_refused(cracks: str, holes: str, key: str, fragment: str, tmp_path) -> None:
    text = plate(cracks=cracks, holes=holes or "[]")
    assert_refused_once(text, tmp_path, f"geometry.cracks{key}", LINE["cracks"], fragment)


ACCEPTED = {
    "embedded, kinked": ("[{points: [[10, 10], [30, 10], [40, 20]]}]", ""),
    "from the outline": ("[{points: [[0, 30], [40, 30]]}]", ""),
    "from a corner": ("[{points: [[0, 0], [40, 30]]}]", ""),
    "oblique mouth": ("[{points: [[20, 0], [60, 5]]}]", ""),
    "from a hole": ("[{points: [[55, 30], [70, 30]]}]", HOLE),
    "mouth on an arc, seven digits": ("[{points: [[53.5355339, 33.5355339], [60, 40]]}]", HOLE),
    "both sides of a hole": (
        "[{points: [[0, 30], [45, 30]]}, {points: [[55, 30], [60, 30]]}]",
        HOLE,
    ),
    "hole to outline, no tip": ("[{points: [[55, 30], [100, 30]]}]", HOLE),
    "hole to hole": ("[{points: [[35, 30], [65, 30]]}]", TWO),
    "chain that ends before the outline": (
        "[{points: [[0, 30], [25, 30]]}, {points: [[35, 30], [65, 30]]}, "
        "{points: [[75, 30], [90, 30]]}]",
        TWO,
    ),
}


@pytest.mark.parametrize(("cracks", "holes"), ACCEPTED.values(), ids=ACCEPTED)
def test_accepted(cracks: str, holes: str, tmp_path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(plate(cracks=cracks, holes=holes or "[]"))
    assert load_scene(path).geometry is not None


@pytest.mark.parametrize(
    ("first", "second", "key"), [("a", "a", "holes[1]"), ("left", "b", "holes[0]")]
)
def test_cracks_at_holes_without_a_name_of_their_own(
    first: str, second: str, key: str, tmp_path
) -> None:
    holes = TWO.replace("{circle", f"{{name: {first}, circle", 1)
    holes = holes.replace(" {circle", f" {{name: {second}, circle", 1)
    cracks = "[{points: [[0, 30], [25, 30]]}, {points: [[35, 30], [65, 30]]}]"
    text = plate(cracks=cracks, holes=holes)
    assert_refused_once(text, tmp_path, f"geometry.{key}.name", LINE["holes"], "is ")


def test_ends_on_the_boundary_are_not_said_to_be_near_it(tmp_path) -> None:
    (problem,) = refused(plate(cracks="[{points: [[0, 30], [100, 30]]}]"), tmp_path)
    assert problem.reason == "cuts the body in two"


def test_growth_without_a_tip_says_which_end_was_moved(tmp_path) -> None:
    text = plate(cracks="[{points: [[55, 30], [99.99999, 30]]}]", holes=HOLE)
    (problem,) = refused(f"{text}growth: {{control: fatigue}}\nfatigue: {{C: 1, m: 3}}", tmp_path)
    assert problem.key == "growth"
    assert "the scene has none; the end (99.99999, 30) is 1e-05 mm from right" in problem.reason


FAMILIES = [
    (
        "kind: centre_crack, width: 50, height: 90, crack_length: 60, traction: 1",
        "family.crack_length",
        "leaves the body",
    ),
    (
        "kind: centre_crack, width: 50, height: 90, crack_length: 50, traction: 1",
        "family.crack_length",
        "cuts the body in two",
    ),
    (
        "kind: single_edge, width: 50, height: 90, crack_length: 49.999, traction: 1",
        "family.crack_length",
        "it must be on it, or at least",
    ),
    (
        "kind: three_point_bend, length: 20, height: 8, span: 18, crack_length: 3, force: 1, "
        "holes: [{centre: [10, 3], radius: 1}]",
        "family.crack_length",
        "runs through hole_1",
    ),
    (
        "kind: plate_with_holes, width: 50, height: 90, traction: 1, "
        "holes: [{centre: [20, 20], radius: 5}, {centre: [60, 20], radius: 5}]",
        "family.holes[1]",
        "lies outside the body",
    ),
    (
        "kind: plate_with_holes, width: 50, height: 90, traction: 1, "
        "holes: [{centre: [20, 20], radius: 5}], cracks: [{points: [[0, 20], [20, 20]]}]",
        "family.cracks[0].points",
        "runs through hole_1",
    ),
    (
        "kind: three_point_bend, length: 20, height: 8, span: 18, crack_length: 3, "
        "crack_offset: -9, force: 1",
        "family.force",
        "is on crack_1",
    ),
]


@pytest.mark.parametrize(("parameters", "key", "fragment"), FAMILIES)
def test_key_is_the_one_of_the_family(parameters: str, key: str, fragment: str, tmp_path) -> None:
    assert_refused_once(family(parameters), tmp_path, key, 3, fragment)
