"""Scene texts for the tests, and the messages for invalid ones."""

from __future__ import annotations

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cfmpm.errors import Problem, SceneError
from cfmpm.scene import Scene, load_scene

LINE = {"outline": 4, "holes": 5, "cracks": 6, "regions": 7, "loads": 8, "mesh": 9, "fracture": 10}
GOOD: dict[str, Any] = {
    "name": "specimen",
    "family": {
        "kind": "single_edge",
        "width": 50,
        "height": 90,
        "crack_length": 9,
        "traction": 1,
    },
    "material": {"E": 210e3, "nu": 0.3},
}


def changed(**parts: Any) -> dict[str, Any]:
    """A valid scene with some parts replaced."""
    return copy.deepcopy(GOOD) | parts


def plate(
    outline: str = "[{at: [0, 0], edge: bottom}, {at: [100, 0], edge: right}, "
    "{at: [100, 60], edge: top}, {at: [0, 60], edge: left}]",
    holes: str = "[]",
    cracks: str = "[]",
    regions: str = "[]",
    loads: str = "[{body_force: [0, -1]}]",
    mesh: str = "{}",
    fracture: str = "{}",
) -> str:
    """A plate of 100 x 60 mm; LINE has the line number of each part."""
    return f"""name: plate
material: {{E: 1000, nu: 0.3}}
geometry:
  outline: {outline}
  holes: {holes}
  cracks: {cracks}
  regions: {regions}
loads: {loads}
mesh: {mesh}
fracture: {fracture}
"""


def family(parameters: str, rest: str = "") -> str:
    """A scene with a family on line 3."""
    return f"name: specimen\nmaterial: {{E: 1000, nu: 0.3}}\nfamily: {{{parameters}}}\n{rest}"


def refused(text: str, folder: Path, **overrides: object) -> list[Problem]:
    """The problems of an invalid scene file."""
    path = folder / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        load_scene(path, overrides)
    assert all(p.file == str(path) for p in caught.value.problems if not overrides)
    return caught.value.problems


def assert_refused_once(text: str, folder: Path, key: str, line: int, fragment: str) -> None:
    """Check that there is one problem, at this key and line, with this text."""
    problems = refused(text, folder)
    assert [(p.key, p.line) for p in problems] == [(key, line)], problems
    assert fragment in problems[0].reason
    assert not any(word in str(problems[0]) for word in ("Input should", "pydantic", "http"))


def attempt(call: Callable[[], Scene]) -> tuple[Scene | None, list[Problem]]:
    """Return the scene or the problems; any other error is a failure."""
    try:
        return call(), []
    except SceneError as error:
        return None, error.problems
