"""Reading of scenes: types, messages, overrides, and plain data of a scene."""

from __future__ import annotations

import json
import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scene_texts import GOOD, assert_refused_once, changed, family, refused

from cfmpm.errors import SceneError
from cfmpm.scene import config_hash, effective_config, expand, load_scene, scene_from_dict

SINGLE = "kind: single_edge, width: 50, height: 90, crack_length: 9, traction: 1"
TOP_LEVEL = [
    # unknown keys, at every level
    ("familiy: 3", "familiy", 4, "unknown key; did you mean family?"),
    ("mehs: {}", "mehs", 4, "unknown key; did you mean mesh?"),
    ("mesh: {sise: 2}", "mesh.sise", 4, "did you mean size? known: element, size, grading"),
    (
        "mesh:\n  grading:\n    tip_sizes: 1\n    tip_size: 1",
        "mesh.grading.tip_sizes",
        6,
        "tip_size?",
    ),
    ("output: {field: true}", "output.field", 4, "did you mean fields?"),
    ("fracture: {xyz: 1}", "fracture.xyz", 4, "unknown key; known: radii"),
    ("42: 1", "42", 4, "unknown key; known: name"),
    # words out of a list
    (
        "plane: Strain",
        "plane",
        4,
        'unknown value "Strain"; did you mean strain? known: strain, stress',
    ),
    ("plane: 3", "plane", 4, "unknown value 3; known: strain, stress"),
    ("solver: cholmd", "solver", 4, "did you mean cholmod?"),
    ("mesh: {element: Q4}", "mesh.element", 4, 'unknown value "Q4"; known: T3, T6'),
    ("mesh: {element: t6}", "mesh.element", 4, "did you mean T6?"),
    ("mesh: {grading: auto_}", "mesh.grading", 4, "auto, uniform, or a mapping"),
    ("mesh: {grading: 3}", "mesh.grading", 4, "auto, uniform, or a mapping with tip_size"),
    ("mesh: {grading: [1, 2]}", "mesh.grading", 4, "auto, uniform, or a mapping"),
    ("mesh: {grading: {}}", "mesh.grading.tip_size", 4, "is missing"),
    ("mesh: {grading: {growth: 1}}", "mesh.grading.tip_size", 4, "is missing"),
    # one value or a list
    ("fracture: {radii: 0}", "fracture.radii", 4, "must be at least 1; got 0"),
    ("fracture: {radii: 21}", "fracture.radii", 4, "must be at most 20; got 21"),
    ("fracture: {radii: 2.5}", "fracture.radii", 4, "must be a whole number (a count) or"),
    ("fracture: {radii: 5.0}", "fracture.radii", 4, "must be a whole number (a count) or"),
    ("fracture: {radii: 1e1}", "fracture.radii", 4, "or a list of numbers in brackets; got 10.0"),
    ("fracture: {radii: '3'}", "fracture.radii", 4, "must be a whole number (a count) or"),
    ("fracture: {radii: true}", "fracture.radii", 4, "in brackets; got true"),
    ("fracture: {radii: null}", "fracture.radii", 4, "in brackets; got nothing"),
    ("fracture: {radii: {a: 1}}", "fracture.radii", 4, "must be a whole number (a count) or"),
    ("fracture: {radii: [true]}", "fracture.radii[0]", 4, "must be a number, not true or false"),
    ("load_steps: 2.0", "load_steps", 4, "or a list of numbers in brackets; got 2.0"),
    ("load_steps: .5", "load_steps", 4, "or a list of numbers in brackets; got 0.5"),
    ("load_steps: '4'", "load_steps", 4, "must be a whole number (a count) or"),
    ("load_steps: yes", "load_steps", 4, "must be a whole number (a count) or"),
    ("load_steps: [false]", "load_steps[0]", 4, "must be a number, not true or false"),
    ("growth: {increments: 2.5}", "growth.increments", 4, "must be a whole number without"),
    ("growth: {increments: 1e2}", "growth.increments", 4, "exponent or quotes; got 100.0"),
    ("growth: {increments: '2'}", "growth.increments", 4, 'exponent or quotes; got "2"'),
    ("growth: {order: 2.0}", "growth.order", 4, "must be 1 or 2; got 2.0"),
    ("output: {every: 2.0}", "output.every", 4, "must be a whole number without point"),
    ("output: {fields: 1}", "output.fields", 4, "must be true or false; got 1"),
    ("output: {fields: yes}", "output.fields", 4, 'must be true or false; got "yes"'),
    ("description: 2", "description", 4, "must be text; put it in quotes; got 2"),
    ("description: !!binary eA==", "description", 4, "must be text; put it in quotes"),
    ("growth: {order: true}", "growth.order", 4, "must be 1 or 2; got true"),
    ("growth: {order: [1]}", "growth.order", 4, "must be 1 or 2; got [1]"),
    ("growth: {order: 3}", "growth.order", 4, "must be 1 or 2; got 3"),
    ("growth: {increments: true}", "growth.increments", 4, "quotes; got true"),
    ("fracture: {radii: []}", "fracture.radii", 4, "needs at least 1, has 0"),
    ("fracture: {radii: [1, 0]}", "fracture.radii[1]", 4, "must be greater than 0; got 0"),
    ("fracture: {radii: [1, [2]]}", "fracture.radii[1]", 4, "must be a number; got [2]"),
    # shapes of data
    ("mesh: 5", "mesh", 4, "must be a mapping; got 5"),
    ("mesh: [T3]", "mesh", 4, "must be a mapping; got ["),
    ("mesh:", "mesh", 4, "must be a mapping; got nothing"),
    ("loads: 5", "loads", 4, "must be a list; got 5"),
    ("loads:", "loads", 4, "must be a list; got nothing"),
    ("output: {fields: 7}", "output.fields", 4, "must be true or false; got 7"),
    ("output: {fields: maybe}", "output.fields", 4, "must be true or false"),
    ("description: 5", "description", 4, "must be text; put it in quotes; got 5"),
    ("description: 2024-01-02", "description", 4, "must be text; put it in quotes"),
]


@pytest.mark.parametrize(("text", "key", "line", "fragment"), TOP_LEVEL)
def test_refused(text: str, key: str, line: int, fragment: str, tmp_path: Path) -> None:
    assert_refused_once(family(SINGLE, text), tmp_path, key, line, fragment)


FAMILY = [
    (
        "kind: singel_edge, width: 5",
        "family.kind",
        "did you mean single_edge? known: single_edge, ",
    ),
    ("kind: 3", "family.kind", "unknown kind"),
    ("kind: [3]", "family.kind", "unknown kind"),
    ("width: 3", "family.kind", "is missing; known: single_edge, centre_crack"),
    (SINGLE + ", crack_angle: 3", "family.crack_angle", "unknown key; did you mean crack_length?"),
    (SINGLE + ", crack_hight: 3", "family.crack_hight", "did you mean crack_height?"),
    (SINGLE.replace("50", "-50"), "family.width", "must be greater than 0; got -50"),
    (SINGLE.replace("50", "5.0e+9"), "family.width", "must be at most 1e+09"),
    (SINGLE.replace("50", "wide"), "family.width", 'must be a number; got "wide"'),
    (SINGLE.replace("50", "12:30"), "family.width", 'must be a number; got "12:30"'),
    (SINGLE.replace("50", "true"), "family.width", "must be a number, not true or false"),
    (SINGLE.replace("50", ".nan"), "family.width", "must be a finite number; got nan"),
    (SINGLE.replace("50", ".inf"), "family.width", "must be a finite number; got inf"),
    (SINGLE.replace("50", "1.0e+400"), "family.width", "must be a finite number"),
    (SINGLE.replace("50", "9" * 400), "family.width", "must be a finite number"),
    (SINGLE.replace("50", "[50]"), "family.width", "must be a number; got [50]"),
    (SINGLE.replace("50", ""), "family.width", "must be a number; got nothing"),
    (SINGLE.replace("1", "-.inf"), "family.traction", "must be a finite number; got -inf"),
    (SINGLE.replace("1", "1.0e+31"), "family.traction", "must have a magnitude of at most 1e+30"),
    (SINGLE.replace("height: 90, ", ""), "family.height", "is missing"),
    (SINGLE.replace("width: 50, ", ""), "family.width", "is missing"),
    (SINGLE.replace("length: 9", "length: 50"), "family.crack_length", "less than the width, 50"),
    (SINGLE.replace("length: 9", "length: 60"), "family.crack_length", "less than the width, 50"),
    (SINGLE + ", crack_height: 90", "family.crack_height", "less than the height, 90"),
    (SINGLE + ", crack_height: 99", "family.crack_height", "less than the height, 90"),
    (
        "kind: compact_tension, width: 5, crack_length: 5, force: 1",
        "family.crack_length",
        "width, 5",
    ),
    (
        "kind: compact_tension, width: 5, crack_length: 9, force: 1",
        "family.crack_length",
        "width, 5",
    ),
    (
        "kind: centre_crack, width: 5, height: 9, crack_length: 1, crack_angle: 91, traction: 1",
        "family.crack_angle",
        "must be at most 90; got 91",
    ),
    (
        "kind: centre_crack, width: 5, height: 9, crack_length: 1, crack_angle: -91, traction: 1",
        "family.crack_angle",
        "must be at least -90; got -91",
    ),
    (
        "kind: three_point_bend, length: 20, height: 8, span: 21, crack_length: 1, force: 1",
        "family.span",
        "must be at most the length, 20",
    ),
    (
        "kind: three_point_bend, length: 20, height: 8, span: 18, crack_length: 8, force: 1",
        "family.crack_length",
        "must be less than the height, 8",
    ),
    (
        "kind: three_point_bend, length: 20, height: 8, span: 18, crack_length: 1, force: 1, "
        "crack_offset: -10",
        "family.crack_offset",
        "must be less than half the length, 10",
    ),
    (
        "kind: plate_with_holes, width: 5, height: 9, holes: [], traction: 1",
        "family.holes",
        "needs at least 1, has 0",
    ),
]


@pytest.mark.parametrize(("parameters", "key", "fragment"), FAMILY)
def test_family_refused(parameters: str, key: str, fragment: str, tmp_path: Path) -> None:
    assert_refused_once(family(parameters), tmp_path, key, 3, fragment)


MATERIALS = [
    ({"E": 0, "nu": 0.3}, "material.E", "must be greater than 0; got 0"),
    ({"E": -1.0, "nu": 0.3}, "material.E", "must be greater than 0; got -1.0"),
    ({"E": 1, "nu": 0.5}, "material.nu", "must be less than 0.5; got 0.5"),
    ({"E": 1, "nu": -1}, "material.nu", "must be greater than -1; got -1"),
    ({"E": 1, "nu": 0, "g_c": 0}, "material.g_c", "must be greater than 0; got 0"),
    ({"E": 1, "nu": 0, "gc": 1}, "material.gc", "unknown key; did you mean g_c?"),
    ({"E": 1}, "material.nu", "is missing: Poisson's ratio"),
    ({"E": np.True_, "nu": 0}, "material.E", "must be a number"),
    ({"E": 1 + 2j, "nu": 0}, "material.E", "must be a number"),
    ({"E": 10**5000, "nu": 0}, "material.E", "must be a finite number; got a number of thousands"),
    ({"E": 1, "nu": 0, 3: 4}, "material", "keys must be words, not 3"),
    (None, "material", "must be a mapping; got nothing"),
]


@pytest.mark.parametrize(("material", "key", "fragment"), MATERIALS)
def test_material_refused(material: object, key: str, fragment: str) -> None:
    with pytest.raises(SceneError) as caught:
        scene_from_dict(changed(material=material))
    (problem,) = caught.value.problems
    assert (problem.key, problem.file, problem.line) == (key, "<dict>", None)
    assert fragment in problem.reason


@pytest.mark.parametrize(
    "name", ["3d", "", "a b", "ä", "-a", "a/b", "a.b", "x" * 65, "a\n", 5, None, ["a"], True]
)
def test_name_refused(name: object) -> None:
    with pytest.raises(SceneError) as caught:
        scene_from_dict(changed(name=name))
    assert [p.key for p in caught.value.problems] == ["name"]


@pytest.mark.parametrize("data", [None, 5, "name: x", [GOOD], {1, 2}])
def test_not_a_mapping(data: Any) -> None:
    with pytest.raises(SceneError, match="<dict>: must be a mapping with keys such as name"):
        scene_from_dict(data)


@pytest.mark.parametrize(
    ("parts", "fragment"),
    [
        ({"family": None}, "has no body: exactly one of geometry, family, mesh_file is needed"),
        ({"mesh_file": {"file": "a.msh"}}, "has family and mesh_file: exactly one of"),
        (
            {"geometry": {"outline": [[0, 0], [1, 0], [0, 1]]}},
            "has geometry and family: exactly one",
        ),
    ],
)
def test_exactly_one_body(parts: dict[str, Any], fragment: str) -> None:
    with pytest.raises(SceneError) as caught:
        scene_from_dict(changed(**parts))
    assert [(p.key, fragment in p.reason) for p in caught.value.problems] == [("", True)]


def test_many_problems_come_in_the_order_of_the_file(tmp_path: Path) -> None:
    text = family(SINGLE.replace("50", "-1"), "mesh: {size: -1, element: T9}\nplan: strain\n")
    assert [(p.key, p.line) for p in refused(text, tmp_path)] == [
        ("family.width", 3),
        ("mesh.size", 4),
        ("mesh.element", 4),
        ("plan", 5),
    ]
    column = refused(text, tmp_path)[1].column
    assert text.splitlines()[3][column - 1 :].startswith("size")


@pytest.mark.parametrize(
    ("written", "value"),
    [
        ("1e-9", 1e-9),
        ("210e3", 210e3),
        ("2.1E5", 2.1e5),
        ("'1e-9'", 1e-9),  # what a loader of YAML 1.1 makes of 1e-9
        ("'210e3'", 210e3),
        ("0o17", 15),
        ("+3", 3),
    ],
)
def test_numbers(written: str, value: float, tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(f"name: x\nfamily: {{{SINGLE}}}\nmaterial: {{E: {written}, nu: 0.3}}\n")
    assert value == load_scene(path).material.E


@pytest.mark.parametrize("number", [np.float64(7), np.int64(7), np.float32(7), Fraction(7), "7"])
def test_numbers_of_other_libraries(number: object) -> None:
    material = scene_from_dict(changed(material={"E": number, "nu": 0})).material
    assert material.E == 7
    assert type(material.E) is float


def test_a_decimal_comma_is_recognised(tmp_path: Path) -> None:
    """In a flow mapping the comma separates two keys, in a block mapping it is text."""
    path = tmp_path / "scene.yaml"
    path.write_text(f"name: x\nfamily: {{{SINGLE}}}\nmaterial: {{E: 210.000,5, nu: 0.3}}\n")
    with pytest.raises(SceneError, match=r"material\.5: unknown key 5; write .* as in 1\.5"):
        load_scene(path)
    path.write_text(f"name: x\nfamily: {{{SINGLE}}}\nmaterial:\n  E: 210000,5\n  nu: 0.3\n")
    with pytest.raises(SceneError, match='with a decimal point; got "210000,5"'):
        load_scene(path)
    path.write_text(f"name: x\nfamily: {{{SINGLE}}}\nmaterial: {{E: some, nu: 0.3}}\n")
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    assert "decimal point" not in str(caught.value)


def test_an_override_is_called_by_its_key_once() -> None:
    with pytest.raises(SceneError) as caught:
        scene_from_dict(GOOD, overrides={"mesh.elemnt": "T3"})
    assert str(caught.value).startswith("override mesh.elemnt: unknown key")
    with pytest.raises(SceneError) as caught:
        scene_from_dict(GOOD, overrides={"mesh": {"size": -2}})
    assert str(caught.value).startswith("override mesh: mesh.size: must be")


OVERRIDES = [
    ({"mesh.size": -2}, "mesh.size", "override mesh.size", "must be greater than 0; got -2"),
    ({"mesh": {"size": -2}}, "mesh.size", "override mesh", "must be greater than 0"),
    (
        {"mesh.grading.growth": 1},
        "mesh.grading.tip_size",
        "override mesh.grading.growth",
        "missing",
    ),
    ({"mesh.elemnt": "T3"}, "mesh.elemnt", "override mesh.elemnt", "did you mean element?"),
    ({"name.first": "a"}, "name", "override name.first", "must be text"),
    (
        {"family.crack_length": 60},
        "family.crack_length",
        "override family.crack_length",
        "less than",
    ),
    ({"mesh.size": 70}, "mesh.size", "override mesh.size", "larger than the body"),
    ({"loads[0].traction": 1}, "", "override loads[0].traction", "no entry [0]: no entries"),
    ({"mesh..size": 1}, "", "override mesh..size", "not a key such as mesh.size"),
    ({"": 1}, "", "override ", "not a key such as"),
    ({"a[b]": 1}, "", "override a[b]", "not a key such as"),
]


@pytest.mark.parametrize(("overrides", "key", "file", "fragment"), OVERRIDES)
def test_override_refused(overrides, key, file, fragment, tmp_path: Path) -> None:
    (problem,) = refused(family(SINGLE), tmp_path, **overrides)
    assert (problem.key, problem.file, problem.line) == (key, file, None)
    assert fragment in problem.reason


def test_override_into_lists() -> None:
    data = changed(loads=[{"edge": "top", "traction": [0, 1]}, {"body_force": [0, 1]}])
    del data["family"]["traction"]
    scene = scene_from_dict(data, overrides={"loads[0].traction[1]": 5, "fracture.radii": [1, 2]})
    assert scene.loads[0].traction == (0, 5)
    assert scene.fracture.radii == [1, 2]
    assert data["loads"][0]["traction"] == [0, 1], "the data given stay as they are"
    for key, fragment in [
        ("loads[2].traction", "2 entries are given"),
        ("loads.edge", "this is a list: give an index"),
        ("name[0]", "no entries are given"),
    ]:
        with pytest.raises(SceneError, match=fragment):
            scene_from_dict(data, overrides={key: 1})


def test_override_may_mend_the_file(tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(family(SINGLE.replace("50", "-50")))
    scene = load_scene(path, {"family.width": 60, "mesh.grading.tip_size": 0.5})
    assert scene.family is not None
    assert expand(scene).geometry.outline[1].at == (60, 0)


def test_effective_config_has_the_defaults_and_is_json() -> None:
    config = effective_config(scene_from_dict(GOOD))
    assert config["mesh"] == {"element": "T6", "grading": "auto"}
    assert config["plane"] == "strain"
    assert json.loads(json.dumps(config, allow_nan=False)) == config


def test_hash_is_that_of_the_meaning() -> None:
    plain = config_hash(scene_from_dict(GOOD))
    assert plain == config_hash(scene_from_dict(changed(plane="strain")))
    assert plain == config_hash(scene_from_dict(changed(material={"nu": "0.3", "E": 210000})))
    assert plain != config_hash(scene_from_dict(changed(plane="stress")))
    zero = [
        config_hash(scene_from_dict(changed(material={"E": 1, "nu": nu}))) for nu in (0, 0.0, -0.0)
    ]
    assert len(set(zero)) == 1
    assert len(plain) == 64


def test_import_is_light() -> None:
    code = (
        "import sys, cfmpm.scene; "
        "assert not {'numba', 'gmsh', 'matplotlib', 'xarray', 'scipy'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
