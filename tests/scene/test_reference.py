"""The reference of scene files agrees with the models."""

from __future__ import annotations

import difflib
import re
from pathlib import Path

import pytest

from cfmpm.scene.reference import reference_text
from cfmpm.scene.schema import schema

PAGE = Path(__file__).parents[2] / "docs" / "scene.md"


def sections() -> dict[str, str]:
    """The text under each heading."""
    _, *parts = re.split(r"^## ", reference_text(), flags=re.MULTILINE)
    return {title: text for title, _, text in (part.partition("\n") for part in parts)}


def row(section: str, key: str) -> list[str]:
    (line,) = (x for x in sections()[section].splitlines() if x.startswith(f"| `{key}` |"))
    return [cell.strip() for cell in line.strip("|").split("|")]


def test_the_page_is_up_to_date() -> None:
    differences = difflib.unified_diff(
        PAGE.read_text("utf-8").splitlines(), reference_text().splitlines(), "docs", "models"
    )
    text = "\n".join(differences)
    assert not text, f"python -m cfmpm.scene.reference > docs/scene.md\n{text}"


def test_every_key_of_every_model_has_its_row() -> None:
    whole = schema()
    models = [whole, *whole["$defs"].values()]
    assert len(sections()) == len(models)
    rows = re.findall(r"^\| `(\w+)` \|", reference_text(), flags=re.MULTILINE)
    assert len(rows) == sum(len(model["properties"]) for model in models)


def test_every_link_leads_to_a_heading() -> None:
    anchors = {title.lower().replace(" ", "-") for title in sections()}
    links = set(re.findall(r"\]\(#([\w-]+)\)", reference_text()))
    assert links == anchors - {"scene"}


@pytest.mark.parametrize(
    ("section", "key", "kind", "default"),
    [
        ("Material", "nu", "number > -1, < 0.5", "required"),
        ("Crack", "points", "list of points, at least 2", "required"),
        ("Growth", "control", "`load`, `crack`, `fatigue`", "`load`"),
        ("Mesh", "size", "number > 0", ""),
        ("Mesh", "grading", "[Grading](#grading) or `auto`, `uniform`", "`auto`"),
        ("Load", "box", "two points", ""),
        ("Load", "traction", "vector", ""),
        ("Output", "fields", "`true`, `false`", "`false`"),
        ("Centre crack", "kind", "`centre_crack`", "required"),
        ("Growth", "increments", "whole number ≥ 1, ≤ 100000", "`500`"),
    ],
)
def test_what_a_key_takes(section: str, key: str, kind: str, default: str) -> None:
    assert row(section, key)[1:3] == [kind, default]
