"""A state given to an observer is not changed by later steps."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pytest

from cfmpm import simulation
from cfmpm.scene import scene_from_dict
from cfmpm.state import State

PLATE: dict[str, Any] = {
    "name": "plate",
    "family": {"kind": "single_edge", "width": 40, "height": 60, "crack_length": 12},
    "material": {"E": 1e4, "nu": 0.3},
    "loads": [
        {"edge": "bottom", "displacement": {"x": 0, "y": 0}},
        {"edge": "top", "displacement": {"y": 3}},
    ],
    "load_steps": 3,
    "mesh": {"element": "T3", "size": 6, "grading": "uniform"},
}
FINITE = {"kinematics": "finite"}
STEEL = {"E": 1e4, "nu": 0.3, "law": "j2", "yield_stress": 100, "hardening": 200}
UPDATED = {**FINITE, "formulation": "updated"}
BRITTLE = {"E": 1e4, "nu": 0.3, "g_c": 1.0}
GROWING = {"material": BRITTLE, "growth": {"increments": 4}, "load_steps": 1}
KINDS: dict[str, dict[str, Any]] = {
    "small": {"kinematics": "small"},
    "finite": FINITE,
    "j2": {**FINITE, "material": STEEL},
    "growth": GROWING,
    "growth by the paper's transfer": {**GROWING, "growth": {"increments": 4, "transfer": "paper"}},
    "finite growth": {**FINITE, **GROWING, "growth": {"increments": 4, "direction": "cf"}},
    "updated, fixed grid": {**UPDATED, "updated": {"grid": "fixed"}},
    "updated, following grid": {**UPDATED, "updated": {"grid": "following", "smooth_below": 1.0}},
    "updated, particle domains": {**UPDATED, "updated": {"integration": "domains"}},
    "updated, j2": {**UPDATED, "material": STEEL},
}


def arrays_of(value: Any, name: str = "", seen: set[int] | None = None) -> dict[str, Any]:
    """All arrays inside a record at any depth, by their path."""
    seen = set() if seen is None else seen
    if id(value) in seen:
        return {}
    if isinstance(value, np.ndarray):
        return {name: value}
    seen.add(id(value))
    parts: dict[str, Any] = {}
    if is_dataclass(value):
        parts = {field.name: getattr(value, field.name) for field in fields(value)}
    elif isinstance(value, dict):
        parts = value
    elif isinstance(value, list | tuple):
        parts = dict(enumerate(value))
    found: dict[str, Any] = {}
    for key, part in parts.items():
        found |= arrays_of(part, f"{name}.{key}", seen)
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_an_observed_state_stays_what_it_was(kind: str) -> None:
    states: list[State] = []
    copies: list[dict[str, Any]] = []

    def observe(state: State, _: Any) -> None:
        states.append(state)
        copies.append({name: array.copy() for name, array in arrays_of(state).items()})

    simulation.run(scene_from_dict(PLATE | KINDS[kind]), observe=observe)
    assert len(states) >= 3
    for name in ("stress", "displacement_gradient", "energy", "position", "element"):
        assert f".balance.points.{name}" in copies[0]
    for state, before in zip(states, copies, strict=True):
        after = arrays_of(state)
        assert after.keys() == before.keys()
        for name, array in after.items():
            np.testing.assert_array_equal(array, before[name], err_msg=name)
    if KINDS[kind].get("kinematics") == "finite":
        stress = [np.abs(state.points.stress).max() for state in states]
        assert len(set(stress)) == len(stress)
