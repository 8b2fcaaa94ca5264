"""Every scene in configs/ is valid, and the schema is up to date."""

from __future__ import annotations

import difflib
import json
import subprocess
import sys
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from cfmpm.scene import Scene, expand, load_scene
from cfmpm.scene.schema import schema, schema_text

CONFIGS = Path(__file__).parents[2] / "configs"
# Values for scenes, which studies name: tests/workflows/test_paper_studies.py.
BLOCKS = ("as_printed", "best")
SCENES = sorted(
    path
    for folder in ("paper", "examples")
    for path in (CONFIGS / folder).glob("*.yaml")
    if path.stem not in BLOCKS
)


@pytest.mark.parametrize("path", SCENES, ids=lambda p: f"{p.parent.name}/{p.stem}")
def test_config(path: Path) -> None:
    scene = load_scene(path)
    assert scene.name == path.stem
    assert expand(scene).loads
    first = path.read_text().splitlines()[0]
    assert first == "# yaml-language-server: $schema=../schema.json"


@pytest.mark.parametrize("path", SCENES, ids=lambda p: f"{p.parent.name}/{p.stem}")
def test_config_fits_the_schema(path: Path) -> None:
    jsonschema = pytest.importorskip("jsonschema")
    data = YAML(typ="safe", pure=True).load(path)
    jsonschema.validate(data, schema(), jsonschema.Draft202012Validator)


def test_each_family_has_an_example() -> None:
    kinds = {scene.family.kind for scene in map(load_scene, SCENES) if scene.family is not None}
    mapping = schema()["properties"]["family"]["anyOf"][0]["discriminator"]["mapping"]
    assert kinds == set(mapping)


def test_schema_is_up_to_date() -> None:
    stored, fresh = (CONFIGS / "schema.json").read_text(encoding="utf-8"), schema_text()
    diff = difflib.unified_diff(
        stored.splitlines(), fresh.splitlines(), "configs/schema.json", "models", lineterm=""
    )
    assert stored == fresh, "\n".join(
        ["run: python -m cfmpm.scene.schema > configs/schema.json", *diff]
    )


@pytest.mark.parametrize(
    ("key", "value"), [("size", 0), ("size", -1.0), ("size", 2e9), ("hole_size", 0.0)]
)
def test_an_editor_sees_the_bounds_of_numbers(key: str, value: float) -> None:
    jsonschema = pytest.importorskip("jsonschema")
    scene = {
        "name": "plate",
        "family": {"kind": "single_edge", "width": 5, "height": 10, "crack_length": 2},
        "material": {"E": 1000, "nu": 0.3},
    }
    jsonschema.validate(scene | {"mesh": {key: 1.0}}, schema())
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(scene | {"mesh": {key: value}}, schema())


def test_schema_is_printed() -> None:
    command = [sys.executable, "-m", "cfmpm.scene.schema"]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert json.loads(printed) == schema()


def test_every_field_of_a_scene_is_in_the_schema() -> None:
    assert set(schema()["properties"]) == set(Scene.model_fields)
