"""Refused and accepted loads."""

from __future__ import annotations

import pytest
from scene_texts import LINE, assert_refused_once, family, plate

from cfmpm.scene import load_scene

REFUSED = [
    ("[]", "", "no load: nothing is prescribed"),
    (
        "[{edge: topp, traction: [0, 1]}]",
        "[0].edge",
        "unknown edge topp; did you mean top? known: ",
    ),
    ("[{edge: Bottom, traction: [0, 1]}]", "[0].edge", "did you mean bottom?"),
    ("[{edge: xyz, displacement: {x: 0}}]", "[0].edge", "known: bottom, right, top, left, hole_1"),
    ("[{edge: hole_2, traction: [0, 1]}]", "[0].edge", "did you mean hole_1?"),
    ("[{box: [[10, 10], [20, 20]], traction: [0, 1]}]", "[0].box", "no part of the boundary"),
    ("[{box: [[101, 0], [120, 60]], displacement: {x: 0}}]", "[0].box", "no part of the boundary"),
    ("[{box: [[0, 0], [0, 60]], displacement: {x: 0}}]", "[0].box", "zero width or height"),
    (
        "[{box: [[-1, 39], [11, 41]], traction: [0, -1]}]",
        "[0].box",
        "contains 10 mm of crack_1 and 2 mm of the boundary: a traction cannot act on crack faces",
    ),
    (
        "[{box: [[2, 36], [-1, 45]], traction: [0, 1]}]",
        "[0].box",
        "contains 2 mm of crack_1 and 9 ",
    ),
    ("[{box: [[-1, 39], [30, 41]], traction: [1, 0]}]", "[0].box", "end the box at the bound"),
    ("[{box: [[2, 39], [9, 41]], displacement: {x: 0}}]", "[0].box", "only 7 mm of crack_1"),
    ("[{box: [[-1, 39.5], [9, 60]], traction: [1, 0]}]", "[0].box", "contains 9 mm of crack_1 and"),
    ("[{box: [[0, 60], [100, 60]], traction: [0, 1]}]", "[0].box", "zero width or height"),
    (
        "[{point: [101, 30], force: [0, 1]}]",
        "[0].point",
        "(101, 30) is outside the body, 1 mm from right",
    ),
    (
        "[{point: [50, 30], displacement: {x: 0}}]",
        "[0].point",
        "is outside the body, 5 mm from hole_1",
    ),
    (
        "[{point: [50, 0.001], force: [0, 1]}]",
        "[0].point",
        "0.001 mm from bottom; it must be on it",
    ),
    (
        "[{point: [55.005, 30], force: [0, 1]}]",
        "[0].point",
        "0.005 mm from hole_1; it must be on it",
    ),
    ("[{point: [0, 40], force: [0, 1]}]", "[0].point", "is on crack_1: a load on a crack"),
    ("[{point: [5, 40], displacement: {x: 0}}]", "[0].point", "is on crack_1"),
    (
        "[{edge: top, displacement: {x: 0}}, {edge: top, displacement: {x: 1, y: 0}}]",
        "[1].displacement.x",
        "1 contradicts loads[0], which prescribes 0 there",
    ),
    (
        "[{edge: hole_1, displacement: {y: 2}}, {edge: hole_1, displacement: {y: -2}}]",
        "[1].displacement.y",
        "contradicts loads[0]",
    ),
    (
        "[{box: [[-1, -1], [9, 9]], displacement: {x: 0}}, "
        "{box: [[9, 9], [-1, -1]], displacement: {x: 1}}]",
        "[1].displacement.x",
        "contradicts loads[0]",
    ),
    (
        "[{point: [0, 0], displacement: {x: 0}}, {point: [0, 0], displacement: {x: 1}}]",
        "[1].displacement.x",
        "contradicts loads[0]",
    ),
    (
        "[{edge: top, displacement: {x: 0}}, {edge: top, traction: [1, 0]}]",
        "[1].traction",
        "1 in x has no effect: loads[0] prescribes the displacement in x there",
    ),
    (
        "[{box: [[9, 9], [-1, -1]], traction: [1, 2]}, "
        "{box: [[-1, -1], [9, 9]], displacement: {y: 0.5}}]",
        "[0].traction",
        "2 in y has no effect: loads[1]",
    ),
    (
        "[{point: [0, 0], displacement: {y: 0}}, {point: [0, 0], force: [0, 1]}]",
        "[1].force",
        "1 in y has no effect: loads[0]",
    ),
    ("[{traction: [0, 1]}]", "[0]", "has no place: a traction goes with edge or box"),
    (
        "[{displacement: {x: 0}}]",
        "[0]",
        "has no place: a displacement goes with edge or box or point",
    ),
    ("[{force: [0, 1]}]", "[0]", "has no place: a force goes with point"),
    ("[{edge: top, point: [0, 0], displacement: {x: 0}}]", "[0]", "has edge and point; one place"),
    (
        "[{edge: top, box: [[-1, -1], [9, 9]], traction: [0, 1]}]",
        "[0]",
        "has edge and box; one place",
    ),
    ("[{edge: top}]", "[0]", "needs one of displacement, traction, force, body_force"),
    ("[{name: empty}]", "[0]", "needs one of displacement, traction, force, body_force"),
    (
        "[{edge: top, displacement: {x: 0}, traction: [0, 1]}]",
        "[0]",
        "has displacement and traction",
    ),
    ("[{point: [0, 0], displacement: {x: 0}, force: [0, 1]}]", "[0]", "has displacement and force"),
    ("[{point: [0, 0], traction: [0, 1]}]", "[0].point", "a traction goes with edge or box"),
    ("[{edge: top, force: [0, 1]}]", "[0].edge", "a force goes with point"),
    ("[{box: [[-1, -1], [9, 9]], force: [0, 1]}]", "[0].box", "a force goes with point"),
    ("[{edge: top, body_force: [0, 1]}]", "[0].edge", "a body_force has no place"),
    ("[{point: [0, 0], body_force: [0, 1]}]", "[0].point", "a body_force has no place"),
    ("[{edge: top, displacement: {}}]", "[0].displacement", "needs x or y or both"),
    ("[{point: [0, 0], displacement: {x: null}}]", "[0].displacement", "needs x or y or both"),
    (
        "[{name: a, edge: top, traction: [0, 1]}, {name: a, edge: left, traction: [0, 1]}]",
        "[1].name",
        "a is a name already in use",
    ),
    (
        "[{name: b, body_force: [0, 1]}, {edge: top, traction: [0, 1]}, {name: b, edge: left, "
        "traction: [0, 1]}]",
        "[2].name",
        "b is a name already in use",
    ),
    ("[{edge: top, traction: 5}]", "[0].traction", "must be two numbers in brackets"),
    ("[{edge: top, traction: [0, 5, 0]}]", "[0].traction", "must be two numbers in brackets"),
    ("[{edge: top, traction: [0, a]}]", "[0].traction[1]", 'must be a number; got "a"'),
    ("[{box: [[0, 0], 5], traction: [0, 1]}]", "[0].box[1]", "must be two numbers in brackets"),
    ("[{box: 5, traction: [0, 1]}]", "[0].box", "must be two opposite corners"),
    ("[5]", "[0]", "must be a mapping; got 5"),
    ("{edge: top, traction: [0, 1]}", "", "must be a list; got a mapping"),
]


@pytest.mark.parametrize(("loads", "key", "fragment"), REFUSED)
def test_refused(loads: str, key: str, fragment: str, tmp_path) -> None:
    text = plate(
        loads=loads,
        holes="[{circle: {centre: [50, 30], radius: 5}}]",
        cracks="[{points: [[0, 40], [10, 40]]}]",
    )
    assert_refused_once(text, tmp_path, f"loads{key}", LINE["loads"], fragment)


SINGLE = "kind: single_edge, width: 50, height: 90, crack_length: 9"
BEND = "kind: three_point_bend, length: 20, height: 8, span: 18, crack_length: 3"


@pytest.mark.parametrize(
    ("parameters", "rest", "key", "line", "fragment"),
    [
        (SINGLE, "", "loads", 1, "no load: give family.traction, or a list of loads"),
        (BEND, "loads: []", "loads", 4, "no load: give family.force"),
        (
            f"{SINGLE}, traction: 1",
            "loads: [{body_force: [0, 1]}]",
            "family.traction",
            3,
            "already",
        ),
        (f"{BEND}, force: 1", "loads: [{body_force: [0, 1]}]", "family.force", 3, "already"),
    ],
)
def test_families_are_loaded_once(parameters, rest, key, line, fragment, tmp_path) -> None:
    assert_refused_once(family(parameters, rest), tmp_path, key, line, fragment)


ACCEPTED = [
    "[{edge: top, displacement: {x: 0}}, {edge: top, displacement: {x: 0, y: 1}}]",
    "[{edge: top, displacement: {x: 0}}, {edge: top, traction: [0, 1]}]",
    "[{edge: hole_1, traction: [0, 1]}]",
    "[{edge: top, displacement: {x: 0, y: 0}}, {edge: left, traction: [1, 1]}]",
    "[{edge: top, displacement: {x: 0, y: 0}}, {box: [[90, 50], [101, 61]], traction: [1, 1]}]",
    "[{point: [0, 0], displacement: {y: 0}}, {point: [0, 0], force: [1, 0]}]",
    "[{point: [50, 25], force: [0, 1]}, {point: [80, 30], displacement: {x: 0}}]",
    "[{box: [[44, 24], [56, 30]], traction: [0, 1]}]",
    "[{box: [[100, 60], [99, 59]], displacement: {x: 1}}]",
    "[{box: [[-1, 39], [30, 41]], displacement: {x: 1}}]",
]


@pytest.mark.parametrize("loads", ACCEPTED)
def test_accepted(loads: str, tmp_path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(plate(loads=loads, holes="[{circle: {centre: [50, 30], radius: 5}}]"))
    assert load_scene(path).loads
