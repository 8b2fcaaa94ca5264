"""The updated Lagrangian formulation against finite elements, and against the total formulation."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from cfmpm import simulation, state
from cfmpm.scene import scene_from_dict

PAPER = Path(__file__).parents[2] / "configs" / "paper"
# Elongation: J and force on the top [N/mm] of the neo-Hookean plate, by total Lagrangian finite
# elements (T6, graded, converged).
ELONGATED = {
    0.1: (684_877.0, 1.000124e7),
    0.3: (4_803_510.0, 2.667376e7),
    0.5: (11_220_580.0, 4.039292e7),
}


def elongated(**options: Any) -> state.Result:
    scene = {
        "name": "plate",
        "family": {"kind": "single_edge", "width": 500, "height": 1000, "crack_length": 100},
        "material": {"E": 210e3, "nu": 0.3, "law": "neo_hookean"},
        "kinematics": "finite",
        "formulation": "updated",
        "updated": options,
        "loads": [
            {"edge": "bottom", "displacement": {"y": -500}},
            {"edge": "top", "displacement": {"y": 500}},
        ],
        "load_steps": [0.1, 0.2, 0.3, 0.4, 0.5],
        "mesh": {"element": "T3", "size": 50, "grading": {"tip_size": 1, "growth": 0.2}},
        "fracture": {"radii": [50]},
    }
    return simulation.run(scene_from_dict(scene))


@pytest.mark.slow
@pytest.mark.parametrize(
    "options",
    [{}, {"integration": "domains"}, {"integration": "domains", "smooth_below": 0.6}],
)
def test_following_grid_to_half_the_length(options: dict[str, Any]) -> None:
    """J within 1.3 %, the accuracy of T3 of this size; force within 0.15 %."""
    history = elongated(grid="following", **options).history
    assert history["grid_resets"][-1] >= 2
    assert (history["empty_elements"] == 0).all()
    for elongation, (j, force) in ELONGATED.items():
        step = history.sel(step=history["load_factor"] == elongation)
        assert abs(step["J"].item() / j - 1.0) < 0.014
        assert abs(step["cf_norm"].item() / j - 1.0) < 0.014
        assert abs(step["reaction_y"].values[0, 1] / force - 1.0) < 0.0015


@pytest.mark.parametrize(
    "name",
    [
        "edge_crack_growth",
        "plate_two_holes",
        pytest.param("shear_plate_growth", marks=pytest.mark.slow),
        pytest.param("beam_three_holes", marks=pytest.mark.slow),
    ],
)
def test_paper_mode_begins_as_the_total_formulation(name: str) -> None:
    """Sections 5.2 to 5.5 before growth: no reset has occurred in the first step."""
    scene = yaml.safe_load((PAPER / f"{name}.yaml").read_text(encoding="utf-8"))
    del scene["growth"]
    scene.pop("fatigue", None)
    total, updated = (
        simulation.run(scene_from_dict({**scene, "kinematics": "finite", "formulation": which}))
        for which in ("total", "updated")
    )
    for variable in ("cf_norm", "cf_norm_grid"):
        values = updated.history[variable].values
        np.testing.assert_allclose(values, total.history["cf_norm"].values, rtol=1e-4)
