"""The Python interface."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import pytest

import cfmpm
from cfmpm.output import summary

PLATE: dict[str, Any] = {
    "name": "plate",
    "family": {
        "kind": "single_edge",
        "width": 40,
        "height": 60,
        "crack_length": 12,
        "traction": 10,
    },
    "material": {"E": 1e4, "nu": 0.3},
    "mesh": {"element": "T3", "size": 9, "grading": "uniform"},
}


@pytest.mark.parametrize(
    ("scene", "way"),
    [("base.yaml", "load_scene"), (Path("base.yaml"), "load_scene"), (PLATE, "scene_from_dict")],
)
def test_run_says_how_to_make_a_scene(scene: Any, way: str) -> None:
    with pytest.raises(TypeError, match=rf"needs a Scene, not \w+: cfmpm.run\(cfmpm.{way}\("):
        cfmpm.run(scene)


def test_results_and_states_are_shown_in_a_line() -> None:
    states = []
    result = cfmpm.run(
        cfmpm.scene_from_dict(PLATE), observe=lambda state, _: states.append(repr(state))
    )
    assert states == ["<State of plate, step 1>"]
    assert repr(result) == "<Result of plate: 1 step, 1 crack tip; see its history>"


def test_round_off_of_the_plastic_part_of_j_is_shown_as_zero() -> None:
    steel = {"law": "j2", "yield_stress": 1e4, "hardening": 200}
    scene = cfmpm.scene_from_dict(
        {**PLATE, "kinematics": "finite", "material": {**PLATE["material"], **steel}}
    )
    result = cfmpm.run(scene)

    def shown(part: float) -> str:
        history = result.history.assign(J_plastic=0.0 * result.history["J"] + part)
        text = summary.of_run(dataclasses.replace(result, history=history), [])
        (line,) = (line for line in text.splitlines() if line.startswith("plastic part of J"))
        return line.split()[-1]

    assert shown(-2.2e-16) == "0.00000"
    assert shown(-2.2e-6) == "-2.20000e-06"
