"""The studies of the paper are valid and agree with the schema for editors."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from cfmpm.scene import load_scene
from cfmpm.scene.schema import schema
from cfmpm.study.model import Study
from cfmpm.study.reading import load_study
from workflows.configuration import study_file

FOLDER = Path(__file__).parents[2] / "configs" / "paper" / "studies"
STUDIES = sorted(FOLDER.glob("*.yaml"))


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_study(path):
    plan = load_study(path)
    assert plan.study.name == path.stem
    assert plan.study.description
    first = path.read_text(encoding="utf-8").splitlines()[0]
    assert first == "# yaml-language-server: $schema=../../study_schema.json"
    scene = Path(study_file.scene_of(str(path)))
    assert scene.parent == FOLDER.parent
    assert path.stem.startswith((scene.stem, "scatter_"))
    jsonschema = pytest.importorskip("jsonschema")
    data = YAML(typ="safe", pure=True).load(path)
    jsonschema.validate(data, schema(Study), jsonschema.Draft202012Validator)


PAPER = FOLDER.parent
BLOCKS = [
    (file, name)
    for file in ("as_printed", "best")
    for name in YAML(typ="safe", pure=True).load(PAPER / f"{file}.yaml")
]


@pytest.mark.parametrize(("file", "block"), BLOCKS, ids=" ".join)
def test_a_block_of_settings_is_of_the_scene_of_its_name(file, block):
    (scene,) = [one for one in PAPER.glob("*.yaml") if re.fullmatch(rf"{one.stem}(_.*\d)?", block)]
    replaced = YAML(typ="safe", pure=True).load(PAPER / f"{file}.yaml")[block]
    whole = load_scene(scene, replaced)
    if file == "as_printed":
        assert whole.mesh.element == "T3"
        assert len(whole.fracture.radii) == 1
    if file == "as_printed" and whole.growth is not None:
        grown = (whole.growth.criterion, whole.growth.direction, whole.growth.transfer)
        assert grown == ("cf_norm", "cf", "paper")


def test_both_files_of_settings_have_all_scenes():
    printed = {re.sub(r"_(790|2584)$", "", block) for file, block in BLOCKS if file == "as_printed"}
    assert printed == {block for file, block in BLOCKS if file == "best"}


def test_there_is_one_for_each_section_with_a_sweep():
    assert len(STUDIES) >= 11
