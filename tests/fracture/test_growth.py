from __future__ import annotations

import math

import numpy as np
import pytest
from structured import rectangle

from cfmpm.body.grid import build_grid
from cfmpm.ending import RunEnded
from cfmpm.fracture import growth
from cfmpm.fracture.criteria.protocols import direction_by
from cfmpm.scene.growth import Growth

GRID = build_grid(rectangle(8, 6, crack=(3, 2, 5)), "T3")


def values(g, k_1=(1.0, 1.0), k_2=(0.0, 0.0), norm=None, error=0.0):
    return {
        "G": np.array(g, float),
        "G_radius": np.array(g, float)[:, None],
        "J_radius": (1.0 - error) * np.array(g, float)[:, None],
        "cf_norm": np.array(g if norm is None else norm, float),
        "cf_x": np.array([-1.0, 1.0]),
        "cf_y": np.array([0.0, 0.1]),
        "K_I": np.array(k_1, float),
        "K_II": np.array(k_2, float),
    }


def decide(g, config=None, g_c=1.0, **more):
    return growth.decide(GRID, values(g, **more), [g_c], Growth(**(config or {})))


def test_stationary_cracks_do_nothing():
    assert growth.decide(GRID, {}, [None], None) == growth.Decision(1.0, {})


def test_load_control_runs_whatever_meets_the_criterion():
    assert set(decide([0.9, 1.0]).running) == {"crack_1_end"}
    assert set(decide([1.2, 3.0]).running) == {"crack_1_start", "crack_1_end"}
    assert set(decide([1.2, 3.0], {"tips": "largest"}).running) == {"crack_1_end"}
    assert decide([0.5, 0.6]).running == {}
    assert decide([1.2, 3.0]).load_factor == 1.0


def test_crack_control_finds_the_load():
    decision = decide([0.16, 0.25], {"control": "crack"})
    assert decision.load_factor == pytest.approx(2.0)
    assert set(decision.running) == {"crack_1_end"}
    assert decision.tied == ()
    twins = decide([0.249, 0.25], {"control": "crack"}, error=0.003)
    assert set(twins.running) == set(twins.tied) == {"crack_1_start", "crack_1_end"}
    assert twins.load_factor == pytest.approx(2.0)
    alone = decide([0.249, 0.25], {"control": "crack"}, error=0.001)
    assert set(alone.running) == {"crack_1_end"}
    largest = decide([0.249, 0.25], {"control": "crack", "tips": "largest"}, error=0.003)
    assert set(largest.running) == {"crack_1_end"}
    assert len(largest.tied) == 2
    nothing = decide([0.0, 0.0], {"control": "crack"})
    assert nothing.load_factor == math.inf
    assert nothing.running == {}


def test_tips_run_by_shear_but_not_under_pressure():
    assert decide([5.0, 5.0], k_1=(-1.0, -1.0), k_2=(0.5, -0.5)).running == {}
    assert len(decide([5.0, 5.0], k_1=(-1e-3, 0.0), k_2=(1.0, 1.0)).running) == 2


class NoAnswer:
    def heading(self, values, tangent):
        return tangent * (np.nan if values["K_II"] > 0.0 else 1.0)

    def kink_factor(self, values):
        return np.nan


def test_a_tip_runs_only_where_the_criterion_has_an_answer(monkeypatch):
    monkeypatch.setattr(growth, "direction_by", lambda word: NoAnswer())
    decision = decide([5.0, 5.0], k_2=(0.0, 1.0))
    assert set(decision.running) == {"crack_1_start"}


def test_the_paper_s_criterion_and_direction():
    config = {"criterion": "cf_norm", "direction": "cf"}
    decision = decide([0.1, 0.1], config, norm=[0.9, 1.1])
    assert set(decision.running) == {"crack_1_end"}
    np.testing.assert_allclose(
        decision.running["crack_1_end"], np.array([1.0, 0.1]) / math.hypot(1.0, 0.1)
    )


@pytest.mark.parametrize("rule", ["max_hoop", "max_energy"])
def test_directions_turn_from_the_tangent_of_their_own_tip(rule):
    decision = decide([2.0, 2.0], {"direction": rule}, k_2=(0.3, 0.3))
    angle = direction_by(rule).angle({"K_I": 1.0, "K_II": 0.3})
    assert angle < 0
    for name, tangent in (("crack_1_end", 1.0), ("crack_1_start", -1.0)):
        turned = np.exp(1j * math.radians(angle)) * tangent
        np.testing.assert_allclose(decision.running[name], [turned.real, turned.imag])


def test_second_order_segments_follow_a_parabola_to_second_order():
    """Path y' = x / r from tangents at both ends of each segment, against y = x^2 / (2 r)."""
    errors = {1: [], 2: []}
    for order in errors:
        for n in (20, 40):
            x = y = 0.0
            before = None
            for _ in range(n):
                now = np.array([1.0, x / 4.0])
                now /= np.hypot(*now)
                use = before is not None and order == 2
                step = growth.secant(before, now) if use else now
                x, y = x + 2.0 / n, y + 2.0 / n * step[1] / step[0]
                before = now
            errors[order].append(abs(y - x * x / 8.0))
    assert math.log2(errors[1][0] / errors[1][1]) == pytest.approx(1.0, abs=0.1)
    assert math.log2(errors[2][0] / errors[2][1]) == pytest.approx(2.0, abs=0.15)
    assert errors[2][1] < 0.1 * errors[1][1]


def test_a_sharp_turn_is_not_extrapolated():
    ahead = growth.secant(np.array([1.0, 0.0]), np.array([0.0, 1.0]))
    np.testing.assert_allclose(np.degrees(np.arctan2(ahead[1], ahead[0])), 95.0)


GOES_ON = growth.Decision(1.0, {"crack_1_end": np.array([1.0, 0.0])})
STOPS = growth.Decision(1.0, {})
CONFIG = Growth(increments=3)


@pytest.mark.parametrize(
    ("config", "decision", "tips", "step", "status"),
    [
        (None, GOES_ON, GRID.tips, 1, "solved"),
        (CONFIG, GOES_ON, (), 1, "arrived"),
        (CONFIG, STOPS, GRID.tips, 1, "stopped"),
        (CONFIG, growth.Decision(np.inf, {}), GRID.tips, 1, "stopped"),
        (CONFIG, GOES_ON, GRID.tips, 4, "increments"),
    ],
)
def test_reasons_to_end(config, decision, tips, step, status):
    with pytest.raises(RunEnded) as end:
        growth.check_end(config, decision, tips, step, lengths={})
    assert end.value.ending.status == status
    assert end.value.ending.text.startswith(f"{status}: ")
    assert end.value.cracks is None


def test_no_reason_to_end():
    growth.check_end(CONFIG, GOES_ON, GRID.tips, 3, lengths={})
    growth.check_end(None, GOES_ON, GRID.tips, 1, last_level=False, lengths={})
    growth.check_end(CONFIG, STOPS, GRID.tips, 1, last_level=False, lengths={})
