"""Cracks that grow into another material, into loaded points, and to the edge."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from outlines import named_rectangle

import cfmpm
from cfmpm.scene import scene_from_dict


def layered(stiff=1.0, **changes) -> dict[str, Any]:
    """An edge crack that grows into another material at x = 12 mm."""
    return {
        "name": "layered",
        "geometry": {
            "outline": named_rectangle(30, 40),
            "cracks": [{"points": [[0, 20], [6, 20]]}],
            "regions": [
                {
                    "name": "other",
                    "polygon": [[12, 0], [30, 0], [30, 40], [12, 40]],
                    "material": {"E": stiff * 1e4, "nu": 0.3, "g_c": 4.0},
                }
            ],
        },
        "material": {"E": 1e4, "nu": 0.3, "g_c": 1.0},
        "loads": [
            {"edge": "bottom", "traction": [0, -10]},
            {"edge": "top", "traction": [0, 10]},
        ],
        "mesh": {"element": "T6", "size": 1.0, "grading": "uniform"},
        "growth": {"control": "crack", "increments": 14},
    } | changes


@pytest.fixture(scope="module")
def tougher():
    return cfmpm.run(scene_from_dict(layered())).history


def test_each_segment_costs_the_toughness_of_what_it_runs_through(tougher):
    x = tougher.tip_x.values[:, 0]
    assert x[-1] > 14.0
    segment = np.hypot(np.diff(x), np.diff(tougher.tip_y.values[:, 0]))
    middle = 0.5 * (x[1:] + x[:-1])
    spent = np.append(0.0, np.cumsum(segment * np.where(middle > 12.0, 4.0, 1.0)))
    np.testing.assert_allclose(tougher.fracture_energy, spent, rtol=1e-12)
    # The load rises to what the tougher one needs, twice as much for four times g_c.
    load = tougher.load_factor.values
    first = int(np.argmax(x > 12.0 - 1e-9))
    assert load[first] > 1.6 * load[first - 1]


def test_energy_balances_step_by_step(tougher):
    gap = np.abs(tougher.energy_gap.values)
    np.testing.assert_allclose(
        tougher.energy_gap,
        tougher.external_work - tougher.strain_energy - tougher.fracture_energy,
        rtol=0,
        atol=1e-12 * float(tougher.external_work.max()),
    )
    assert gap.max() < 0.03 * float(tougher.external_work.max())
    assert not tougher.jump.values.any()


def test_no_stress_intensity_on_the_border_of_two_materials():
    history = cfmpm.run(scene_from_dict(layered(stiff=3.0))).history
    border = np.isclose(history.tip_x.values[:, 0], 12.0, atol=1e-9)
    assert border.sum() == 1
    assert np.isnan(history.K_I.values[border, 0]).all()
    assert np.isfinite(history.K_I.values[~border, 0]).all()
    np.testing.assert_array_equal(history.G.values[border], history.J.values[border])
    warning = next(w for w in json.loads(history.attrs["warnings"]) if "interface" in w)
    assert f"in step {int(np.flatnonzero(border)[0]) + 1} " in warning
    # Straight on.
    heading = np.arctan2(np.diff(history.tip_y.values[:, 0]), np.diff(history.tip_x.values[:, 0]))
    k = int(np.flatnonzero(border)[0])
    assert heading[k] == pytest.approx(heading[k - 1], abs=1e-9)


def test_a_crack_that_meets_a_point_load_ends():
    loads = [
        *layered()["loads"],
        {"name": "rivet", "point": [10, 20], "displacement": {"x": 0.0}},
    ]
    history = cfmpm.run(scene_from_dict(layered(loads=loads))).history
    assert history.attrs["run_status"] == "met_point"
    assert "rivet" in history.attrs["ending"]
    assert float(history.tip_x[-1, 0]) == pytest.approx(10.0)


def test_the_last_ligament_is_told_apart():
    """Two edge cracks; the first arrives at a hole: this step is a jump."""
    scene = layered()
    scene["geometry"]["regions"] = []
    scene["geometry"]["holes"] = [{"name": "hole", "circle": {"centre": [11, 20], "radius": 2}}]
    scene["geometry"]["cracks"].append({"points": [[30, 20], [26, 20]]})
    history = cfmpm.run(scene_from_dict(scene | {"growth": {"control": "crack"}})).history
    jumps = np.flatnonzero(history.jump.values > 0)
    assert len(jumps) >= 1
    first = jumps[0]
    assert history.stability.values[first - 1] == 0
    lost = np.diff(history.energy_gap.values, prepend=0.0)
    others = np.delete(lost, jumps)
    others = others[np.isfinite(others)]
    work = float(history.external_work.max())
    # The way to it costs nothing but the error of the grid, the jump itself sets energy free.
    assert lost[first] > 0.0
    assert np.abs(others).max() < 0.01 * work
