"""A plate, the warnings of its run, and the numbers that they state."""

from __future__ import annotations

import json
import re
from typing import Any

import xarray as xr

import cfmpm
from cfmpm.scene import scene_from_dict

OUTLINE = [
    {"at": [0, 0], "edge": "bottom"},
    {"at": [60, 0], "edge": "right"},
    {"at": [60, 60], "edge": "top"},
    {"at": [0, 60], "edge": "left"},
]
PULL = [{"edge": "bottom", "traction": [0, -1]}, {"edge": "top", "traction": [0, 1]}]


def plate(**changes: Any) -> dict[str, Any]:
    """A plate in tension with an edge crack of 10 mm."""
    return {
        "name": "plate",
        "geometry": {"outline": OUTLINE, "cracks": [{"points": [[0, 30], [10, 30]]}]},
        "material": {"E": 3000.0, "nu": 0.3, "g_c": 0.1},
        "loads": PULL,
        "mesh": {"size": 6},
    } | changes


def solved(scene: dict[str, Any]) -> xr.Dataset:
    return cfmpm.run(scene_from_dict(scene)).history


def warnings_of(scene: dict[str, Any]) -> list[str]:
    found: list[str] = json.loads(solved(scene).attrs["warnings"])
    return found


def the_warning(scene: dict[str, Any], part: str) -> str:
    """The one warning that has some words."""
    (text,) = (text for text in warnings_of(scene) if part in text)
    return text


def number_behind(text: str, words: str) -> float:
    """The number that stands behind some words."""
    found = re.search(rf"{re.escape(words)} ([\d.e+-]*\d)", text)
    assert found is not None, text
    return float(found[1])


def gone(scene: dict[str, Any], part: str) -> bool:
    """Whether no warning has some words."""
    return not any(part in text for text in warnings_of(scene))


def until_gone(scene: dict[str, Any], part: str, key: str, times: int = 5) -> dict[str, Any]:
    """Follow the advised size until the warning is gone; return the scene that has none."""
    group, name = key.split(".", 1)
    for _ in range(times):
        told = [text for text in warnings_of(scene) if part in text]
        if not told:
            return scene
        size = number_behind(told[0], f"set {key} to at most")
        value = {"grading": {"tip_size": size}} if group == "mesh" else {name: size}
        scene = scene | {group: scene.get(group, {}) | value}
    assert gone(scene, part), told
    return scene
