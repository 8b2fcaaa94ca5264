"""The studies of the paper are valid and agree with the schema for editors."""

from __future__ import annotations

from pathlib import Path

import pytest
from ruamel.yaml import YAML

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
    assert study_file.scene_of(str(path)) == str(FOLDER.parent / f"{path.stem}.yaml")
    jsonschema = pytest.importorskip("jsonschema")
    data = YAML(typ="safe", pure=True).load(path)
    jsonschema.validate(data, schema(Study), jsonschema.Draft202012Validator)


def test_there_is_one_for_each_section_with_a_sweep():
    assert len(STUDIES) == 6
