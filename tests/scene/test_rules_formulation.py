"""Keys that do not go with the updated Lagrangian formulation."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from scene_texts import GOOD, refused

from cfmpm.scene import effective_config, scene_from_dict

UPDATED = "kinematics: finite\nformulation: updated\n"
T3 = "mesh: {element: T3}\n"
REFUSED = [
    ("updated: {grid: following}\n", "updated", "needs formulation: updated"),
    ("formulation: updated\n", "formulation", "needs kinematics: finite"),
    (
        UPDATED + T3 + "growth: {direction: cf}\n",
        "growth.transfer",
        "domains does not go with updated.integration: points; use paper",
    ),
    (
        UPDATED + T3 + "updated: {integration: domains}\n"
        "growth: {direction: cf, transfer: paper}\n",
        "growth.transfer",
        "paper does not go with updated.integration: domains; use domains",
    ),
    (
        UPDATED + T3 + "growth: {direction: cf, transfer: paper, control: crack}\n",
        "growth.control",
        "crack needs kinematics: small",
    ),
    (UPDATED + "updated: {grid: following}\n", "updated.grid", "following needs mesh.element: T3"),
    (UPDATED + "updated: {integration: domains}\n", "updated.integration", "domains needs mesh"),
    (UPDATED + "updated: {ghost: 0.1}\n", "updated.ghost", "needs mesh.element: T3"),
    (UPDATED + T3 + "updated: {ghost: -0.1}\n", "updated.ghost", "must be at least 0"),
    (
        UPDATED + T3 + "updated: {grid: following, margin: 1}\n",
        "updated.margin",
        "needs updated.grid: fixed",
    ),
    (
        UPDATED + T3 + "updated: {smooth_below: 0.5}\n",
        "updated.smooth_below",
        "needs updated.grid: following",
    ),
]


def text(rest: str) -> str:
    return (
        "name: specimen\nmaterial: {E: 1000, nu: 0.3, g_c: 1}\n"
        "family: {kind: single_edge, width: 50, height: 90, crack_length: 9, traction: 1}\n" + rest
    )


@pytest.mark.parametrize(("rest", "key", "fragment"), REFUSED)
def test_refused(tmp_path: Path, rest: str, key: str, fragment: str) -> None:
    problems = refused(text(rest), tmp_path)
    assert [problem.key for problem in problems] == [key]
    assert fragment in problems[0].reason


def test_plastic_points_do_not_share_their_state(tmp_path: Path) -> None:
    plastic = text(UPDATED + T3 + "updated: {integration: domains}\n")
    plastic = plastic.replace("nu: 0.3", "nu: 0.3, law: j2, yield_stress: 10")
    (problem,) = refused(plastic, tmp_path)
    assert problem.key == "updated.integration"


@pytest.mark.parametrize(
    "options", [{}, {"grid": "following", "smooth_below": 0.5}, {"margin": 3, "ghost": 0.1}]
)
def test_what_is_written_out_can_be_read_again(options: dict[str, Any]) -> None:
    scene = scene_from_dict(
        GOOD
        | {
            "kinematics": "finite",
            "formulation": "updated",
            "updated": options,
            "mesh": {"element": "T3"},
        }
    )
    assert scene_from_dict(effective_config(scene)) == scene
    total = scene_from_dict(GOOD)
    assert scene_from_dict(effective_config(total)) == total
