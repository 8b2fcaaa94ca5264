"""What is suggested where a run ends as no further stable state is found: it helps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from finite_plate import PLATE
from warned import plate

import cfmpm
from cfmpm.output.warnings.of_scene import ways_on
from cfmpm.scene import scene_from_dict
from cfmpm.state import Result

pytestmark = pytest.mark.slow


def ended(scene: dict[str, Any]) -> tuple[Result, str]:
    """The result of a run, and what is suggested after it."""
    scene_ = scene_from_dict(scene)
    result = cfmpm.run(scene_)
    return result, " ".join(ways_on(scene_, result.balance))


def solved(scene: dict[str, Any]) -> bool:
    return bool(ended(scene)[0].history.attrs["run_status"] == "solved")


def unstable(scene: dict[str, Any], way: str) -> Result:
    result, suggested = ended(scene)
    assert result.history.attrs["run_status"] == "unstable"
    assert way in suggested
    return result


def test_prescribed_displacements_pass_a_limit_load() -> None:
    bottom = {"edge": "bottom", "displacement": {"x": 0, "y": 0}}
    scene = plate(
        material={"E": 1000.0, "nu": 0.3, "law": "j2", "yield_stress": 10, "hardening": 10},
        kinematics="finite",
        load_steps=8,
        mesh={"size": 8, "element": "T3", "grading": "uniform"},
    )
    forced = scene | {"loads": [bottom, {"edge": "top", "traction": [0, 20]}]}
    result = unstable(forced, "Prescribed displacements can pass a limit load")
    most = float(result.history["reaction_y"].values[-1, 1])
    driven, suggested = ended(
        scene | {"loads": [bottom, {"edge": "top", "displacement": {"y": 30}}]}
    )
    assert "Prescribed displacements" not in suggested
    assert driven.history.attrs["run_status"] == "solved"
    reaction = driven.history["reaction_y"].values[:, 1]
    assert reaction.max() == pytest.approx(most, rel=1e-2)
    assert reaction[-1] < 0.95 * most


def test_a_law_that_stays_elliptic() -> None:
    loads = [
        {"edge": "top", "displacement": {"y": 20}},
        {"edge": "bottom", "displacement": {"y": -20}},
    ]
    hencky = PLATE | {"loads": loads, "load_steps": 4, "material": {"E": 1e4, "nu": 0.3}}
    unstable(hencky, "material.law: ciarlet never loses it")
    assert solved(hencky | {"material": PLATE["material"]})


def test_a_grid_that_is_not_reset() -> None:
    loads = [
        {"edge": "top", "displacement": {"y": 16}},
        {"edge": "bottom", "displacement": {"y": -16}},
    ]
    total = PLATE | {"loads": loads, "load_steps": 8}
    reset = total | {"formulation": "updated", "updated": {"grid": "fixed"}}
    unstable(reset, "formulation: total does not reset the grid")
    assert solved(total)


def test_elements_that_tolerate_larger_stretches_behind_a_growing_tip() -> None:
    scene = PLATE | {
        "material": PLATE["material"] | {"g_c": 768.0},
        "loads": [
            {"edge": "top", "displacement": {"y": 16}},
            {"edge": "bottom", "displacement": {"y": -16}},
        ],
        "growth": {"direction": "cf", "increments": 12},
        "mesh": {"element": "T6", "size": 6},
    }
    result = unstable(scene, "mesh.grading: uniform and mesh.element: T3 tolerate larger stretches")
    history = result.history
    grown = history["tip_x"].values[-1, 0] - history["tip_x"].values[0, 0]
    for mesh in ({"element": "T6", "grading": "uniform"}, {"element": "T3"}):
        other, _ = ended(scene | {"mesh": {"size": 6, **mesh}})
        assert other.history.attrs["run_status"] in ("arrived", "increments")
        x = other.history["tip_x"].values[:, 0]
        # By 1.8 to 3 times on the grids of several versions of gmsh.
        assert np.nanmax(x) - x[0] > 1.5 * grown


def test_less_load_where_a_body_buckles() -> None:
    def pressed(by: float) -> dict[str, Any]:
        loads = [
            {"edge": "top", "displacement": {"y": -by}},
            {"edge": "bottom", "displacement": {"y": by}},
        ]
        return PLATE | {"loads": loads}

    unstable(pressed(12), "Reduce the load, or change the body so that it does not buckle.")
    assert solved(pressed(6))
