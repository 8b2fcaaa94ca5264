"""Load at fracture of members at finite deformation, interpolated between their steps."""

from __future__ import annotations

import numpy as np
import pytest

from cfmpm.scene import scene_from_dict
from cfmpm.study.fracture_load import fracture_load_factor

SCENE = scene_from_dict(
    {
        "name": "plate",
        "family": {
            "kind": "single_edge",
            "width": 10,
            "height": 20,
            "crack_length": 3,
            "traction": 1,
        },
        "material": {"E": 1e3, "nu": 0.3, "g_c": 1.0},
        "kinematics": "finite",
    }
)


def found(J: list[list[float]], G_kink: list[list[float]], angle: list[float]) -> float:
    J_, kink = np.array(J), np.array(G_kink)
    values = {
        "load_factor": np.arange(1.0, len(J) + 1.0),
        "J": J_,
        "G_kink": kink,
        "cf_angle": np.broadcast_to(angle, J_.shape),
        "critical_load_factor": np.full(J_.shape, np.nan),
        "tip_x": np.zeros(J_.shape),
        "tip_y": np.zeros(J_.shape),
    }
    return fracture_load_factor(SCENE, values)


NAN = np.nan


def test_by_the_kink_where_it_is_known() -> None:
    assert found([[0.2], [0.8]], [[0.25], [1.0]], [20.0]) == pytest.approx(2.0)


def test_by_j_where_the_crack_would_go_straight_ahead() -> None:
    assert found([[0.25], [1.0]], [[NAN], [NAN]], [0.5]) == pytest.approx(2.0)


def test_left_out_where_a_kink_is_not_known() -> None:
    assert np.isnan(found([[0.25], [1.0]], [[NAN], [NAN]], [30.0]))


def test_tips_that_cannot_be_first_do_not_matter() -> None:
    """A tip with a small load and unknown kink, and a tip without load."""
    J = [[0.25, 0.01, NAN], [1.0, 0.04, NAN]]
    assert found(J, np.full((2, 3), NAN).tolist(), [0.1, -43.0, NAN]) == pytest.approx(2.0)
    first = [[0.25, 0.2, NAN], [1.0, 0.8, NAN]]
    assert np.isnan(found(first, np.full((2, 3), NAN).tolist(), [0.1, -43.0, NAN]))


def test_no_load_so_large() -> None:
    assert np.isnan(found([[0.01], [0.04]], [[0.01], [0.04]], [0.0]))
