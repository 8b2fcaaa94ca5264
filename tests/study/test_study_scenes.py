"""What members of a study have in common is checked once, with the same scenes and problems."""

from __future__ import annotations

import hashlib
import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from mesh_files import Square
from study_texts import write_study
from typer.testing import CliRunner

from cfmpm.cli.app import app
from cfmpm.errors import SceneError
from cfmpm.scene import Scene, config_hash, effective_config, scene_from_document
from cfmpm.scene.document import read_document
from cfmpm.scene.reading import config_texts
from cfmpm.scene.rules import BODY_KEYS, rules_of_body
from cfmpm.study import reading, scenes
from cfmpm.study.reading import load_study

CONFIGS = Path(__file__).parents[2] / "configs"
STUDIES = [*CONFIGS.glob("studies/*.yaml"), *CONFIGS.glob("paper/studies/*.yaml")]
VARIANTS = """\
name: variants
base: small.yaml
replace: {mesh.size: 3, growth: {control: load}}
product:
  how:
    variants:
      as_it_is: {}
      finer: {mesh.size: 1, fracture.radii: [0.5, 1]}
      plate:
        family: null
        geometry: {outline: [[0, 0], [9, 0], [9, 9], [0, 9]], cracks: [{points: [[0, 4], [3, 4]]}]}
        loads: [{edge: edge_1, displacement: {x: 0, y: 0}}, {edge: edge_3, traction: [0, 1]}]
zip:
  E: {key: material.E, values: [1, 2, 3]}
  nu: {key: material.nu, linspace: [0.1, 0.3, 3]}
"""


def one_by_one(path: Path) -> list[Scene]:
    """The scene of each member, each checked as a whole from the document."""
    plan = load_study(path, range(0))
    document = read_document(path)
    base, folder = reading._base(document, plan.study, path.parent)
    parameters = {name: one for _, name, one in plan.study.parameters()}
    found = []
    for index in reading.expansion.places(plan.axes):
        overrides = dict(plan.study.replace)
        for axis, i in zip(plan.axes, index, strict=True):
            for name, values in axis.values.items():
                overrides |= parameters[name].replaced(values[i])
        found.append(scene_from_document(base.overridden(overrides), folder))
    return found


def assert_as_one_by_one(path: Path) -> None:
    members = load_study(path).members
    expected = one_by_one(path)
    assert [one.scene for one in members] == expected
    for one, scene in zip(members, expected, strict=True):
        plain = replace(one, key=reading._key(config_hash(scene)), repeats=1, measure=None)
        assert one.key == reading._measured(plain, one.repeats, one.measure).key


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_shipped_studies(path: Path) -> None:
    assert_as_one_by_one(path)


def test_variants(tmp_path: Path) -> None:
    assert_as_one_by_one(write_study(tmp_path, VARIANTS))


def test_mesh_files_are_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for i, name in enumerate(("one.msh", "two.msh")):
        square = Square()
        square.nodes[40] = (4.0 + i / 10, 4.0)
        square.write(tmp_path / name)
    text = """\
name: files
base:
  name: square
  mesh_file: {file: one.msh}
  material: {E: 1000, nu: 0.3}
  loads: [{edge: bottom, displacement: {x: 0, y: 0}}, {edge: top, traction: [0, 1]}]
product:
  file: {key: mesh_file.file, values: [one.msh, two.msh]}
  E: {key: material.E, linspace: [1000, 2000, 5]}
"""
    path = write_study(tmp_path, text)
    assert_as_one_by_one(path)
    read = []
    digest = scenes.scene_from_document
    monkeypatch.setattr(scenes, "scene_from_document", lambda *a: read.append(a) or digest(*a))
    members = load_study(path).members
    assert len(read) == 2
    assert len({one.scene.mesh_file.sha256 for one in members}) == 2


def test_problems_are_those_of_each_member(tmp_path: Path) -> None:
    """Of a body, of a key, of both together, and of keys that do not fit each other."""
    text = """\
name: wrong
base: small.yaml
product:
  length: {key: family.crack_length, values: [2, 10, 4]}
  E: {key: material.E, values: [1, -2, 3]}
  law: {key: material.law, values: [hencky, j2]}
  size: {key: mesh.size, values: [2, 300]}
"""
    with pytest.raises(SceneError) as caught:
        load_study(write_study(tmp_path, text))
    base = tmp_path / "small.yaml"
    # pydantic before 2.12 tells the number as it was converted.
    told = [(p.line, p.key, p.reason.replace("got -2.0", "got -2")) for p in caught.value.problems]
    assert told == [
        (
            7,
            "in 4 members, such as length=2, E=1, law=hencky, size=300: mesh.size",
            "300 mm is larger than the body, whose smaller extent is 10 mm",
        ),
        (
            2,
            "in 12 members, such as length=2, E=1, law=j2, size=2",
            f"{base}:3:1: material.yield_stress: is missing: the law j2 needs it",
        ),
        (
            5,
            "in 12 members, such as length=2, E=-2, law=hencky, size=2: material.E",
            "must be greater than 0; got -2",
        ),
        (
            4,
            "in 12 members, such as length=10, E=1, law=hencky, size=2: family.crack_length",
            "must be less than the width, 10",
        ),
        (None, "", "32 of 36 members are refused; nothing was run"),
    ]


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_rules_of_the_body_read_no_other_keys(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Members that agree in these keys are not checked again."""
    read: set[str] = set()
    plain = Scene.__getattribute__

    def recorded(scene: Scene, key: str) -> Any:
        read.add(key)
        return plain(scene, key)

    members = load_study(path).members
    monkeypatch.setattr(Scene, "__getattribute__", recorded)
    for one in members[:20]:
        rules_of_body(one.scene)
    assert "mesh" in read
    assert read & set(Scene.model_fields) <= set(BODY_KEYS)


def test_the_texts_of_keys_are_those_of_the_config_hash() -> None:
    scene = load_study(STUDIES[0]).members[0].scene
    texts = config_texts(scene)
    assert texts["material"] == config_texts(scene, ["material"])["material"]
    assert "growth" not in config_texts(scene, ["growth", "name"])
    whole = json.dumps(effective_config(scene), sort_keys=True, separators=(",", ":"))
    assert config_hash(scene) == hashlib.sha256(whole.encode()).hexdigest()


LARGE = """\
name: large
base: small.yaml
product:
  length: {key: family.crack_length, linspace: [1, 9, 10]}
  E: {key: material.E, linspace: [1e5, 2e5, 10]}
zip:
  nu: {key: material.nu, linspace: [0.1, 0.4, %d]}
"""


def test_common_parts_are_checked_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    checked = []
    rules = scenes.rules_of_body
    monkeypatch.setattr(scenes, "rules_of_body", lambda one: checked.append(one) or rules(one))
    members = load_study(write_study(tmp_path, LARGE % 3)).members
    assert len(members) == 300
    assert len(checked) == 10
    assert len({id(one.scene.material) for one in members}) == 30
    assert len({id(one.scene.mesh) for one in members}) == 1


@pytest.mark.slow
def test_a_hundred_thousand_members_are_checked_in_ten_seconds(tmp_path: Path) -> None:
    path = write_study(tmp_path, LARGE % 1000)
    begin = time.process_time()
    assert len(load_study(path).members) == 100_000
    assert time.process_time() - begin < 10.0


@pytest.mark.parametrize(("quiet", "seconds"), [([], 0.0), (["--quiet"], 0.0), ([], 1e9)])
def test_a_long_check_is_announced(
    quiet: list[str], seconds: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reading, "LONG", seconds)
    monkeypatch.setattr(reading, "SOON", 0.0)
    path = write_study(tmp_path, LARGE % 1)
    done = CliRunner().invoke(app, ["study", "--check", str(path), *quiet])
    assert done.exit_code == 0
    told = done.stderr.splitlines()
    if quiet or seconds:
        assert not told
    else:
        assert len(told) == 1
        assert told[0].startswith("checking all 100 members first takes about ")


def test_a_key_that_one_member_alone_has_and_no_scene(tmp_path: Path) -> None:
    text = "name: keys\nbase: small.yaml\nproduct: {how: {variants: {a: {grow.x: 1}, b: {}}}}\n"
    with pytest.raises(SceneError, match="grow: unknown key; did you mean growth") as caught:
        load_study(write_study(tmp_path, text))
    assert len(caught.value.problems) == 1
