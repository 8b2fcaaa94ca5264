"""Stable, unstable and snap-back growth on paths whose kind is known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from outlines import named_rectangle

import cfmpm
from cfmpm.fracture.stability import STABILITY, classify
from cfmpm.scene import scene_from_dict


def words(flags: Any) -> list[str]:
    return [STABILITY[flag] for flag in flags]


def test_each_kind() -> None:
    force = np.array([1.0, 2.0, 1.5, 1.0, 1.0])
    displacement = np.array([1.0, 2.0, 3.0, 2.5, 2.5])
    expected = ["stable", "unstable", "snap_back", "undefined", "undefined"]
    assert words(classify(force, displacement)) == expected


def test_one_state_has_no_kind() -> None:
    assert words(classify(np.ones(1), np.ones(1))) == ["undefined"]


def test_a_last_state_that_is_not_known_has_no_kind() -> None:
    flags = classify(np.array([1.0, 2.0, np.nan]), np.array([1.0, 2.0, np.nan]))
    assert words(flags) == ["stable", "undefined", "undefined"]


def plate(load: dict[str, Any], **changes: Any) -> dict[str, Any]:
    """A strip of 10 x 60 mm with an edge crack of 3 mm."""
    return {
        "name": "strip",
        "geometry": {
            "outline": named_rectangle(10, 60),
            "cracks": [{"points": [[0, 30], [3, 30]]}],
        },
        "material": {"E": 210e3, "nu": 0.3, "g_c": 1.0},
        "loads": [{"edge": "bottom", "displacement": {"x": 0, "y": 0}}, {"edge": "top", **load}],
        "mesh": {"element": "T6", "size": 2},
        "growth": {"control": "crack", "increments": 6},
        **changes,
    }


@pytest.mark.parametrize("load", [{"traction": [0, 10]}, {"displacement": {"x": 0, "y": 0.05}}])
def test_a_long_strip_snaps_back_under_force_and_grip_alike(load: dict[str, Any]) -> None:
    """Most energy is stored far from a short crack: K increases faster than the compliance."""
    history = cfmpm.run(scene_from_dict(plate(load))).history
    assert words(history["stability"].values) == ["snap_back"] * 6 + ["undefined"]
    assert history["stability"].attrs["flag_meanings"].split() == list(STABILITY)


def test_a_wedge_opens_a_crack_unstably_by_force_and_not_by_displacement() -> None:
    """Double cantilever beam loaded at its crack mouth."""
    beam = {
        "geometry": {
            "outline": [[0, 0], [60, 0], [60, 10], [0, 10]],
            "cracks": [{"points": [[0, 5], [25, 5]]}],
        },
        "loads": [
            {"point": [0, 10], "force": [0, 10], "name": "up"},
            {"point": [0, 0], "force": [0, -10], "name": "down"},
        ],
    }
    history = cfmpm.run(scene_from_dict(plate({}) | beam)).history
    assert words(history["stability"].values) == ["unstable"] * 6 + ["undefined"]


def test_under_load_control_nothing_is_known() -> None:
    scene = plate({"traction": [0, 1000]}, growth={"control": "load", "increments": 3})
    history = cfmpm.run(scene_from_dict(scene)).history
    assert set(words(history["stability"].values)) == {"undefined"}
