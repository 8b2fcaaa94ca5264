"""Cycles of fatigue: against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from fatigue_strip import NU, C, E, M, strip
from hypothesis import given, settings
from hypothesis import strategies as st

import cfmpm
from cfmpm.errors import SceneError
from cfmpm.fracture import fatigue
from cfmpm.fracture.fatigue import Progress
from cfmpm.output.variables import TIP_STATUS
from cfmpm.scene import scene_from_dict
from cfmpm.scene.growth import Fatigue


def progress(rates, pending=None, leader="a", cycles=0.0):
    return Progress(cycles, {}, rates, pending or {}, leader, {})


def test_range_of_a_cycle():
    law = Fatigue(C=C, m=M, load_ratio=0.4)
    assert fatigue.stress_range(law, 3.0, 4.0) == pytest.approx(0.6 * 5.0)
    assert fatigue.stress_range(law, -3.0, 4.0) == pytest.approx(0.6 * 4.0)


def test_nothing_grows_at_the_threshold():
    law = Fatigue(C=C, m=M, threshold=30.0)
    assert fatigue.growth_rate(law, 30.0) == 0.0
    assert fatigue.growth_rate(law, 31.0) == pytest.approx(C * 31.0**M)


def test_exact_where_the_inverse_rate_is_linear_in_the_length():
    """dN/da = 1e6 (3 - a): N = 1e6 (3 a - a^2 / 2)."""
    length = np.array([0.0, 0.1, 0.7, 1.0, 2.0])
    rates = 1e-6 / (3.0 - length)
    cycles = 0.0
    for grown, start, end in zip(np.diff(length), rates, rates[1:], strict=False):
        cycles, pending = fatigue.count(
            progress({"a": start}, cycles=cycles), {"a": grown}, {"a": end}
        )
        assert pending["a"] == pytest.approx(0.0, abs=1e-15)
    assert cycles == pytest.approx(1e6 * (3 * 2.0 - 2.0**2 / 2), rel=1e-13)


def test_on_arrival_the_last_rate_counts():
    cycles, _ = fatigue.count(progress({"a": 1e-6}, cycles=7.0), {"a": 0.5}, {})
    assert cycles == pytest.approx(7.0 + 0.5e6)


def test_who_is_due():
    rates, segments = {"a": 1.0, "b": 0.6, "c": 0.3, "d": 0.0}, dict.fromkeys("abcd", 2.0)
    assert fatigue.select_tips({}, rates, segments) == ("a", ["a", "b"])
    assert fatigue.select_tips({"c": 1.9}, rates, segments) == ("c", ["c"])
    assert fatigue.select_tips({}, {"d": 0.0}, segments) == ("", [])


@settings(max_examples=50)
@given(
    rates=st.lists(st.floats(0.01, 1.0), min_size=1, max_size=4),
    lengths=st.lists(st.floats(0.6, 1.4), min_size=60, max_size=60),
)
def test_all_tips_keep_to_the_law_within_a_segment(rates, lengths):
    """For any segment lengths, at constant rates."""
    names = "abcd"[: len(rates)]
    rate = dict(zip(names, rates, strict=True))
    grown = dict.fromkeys(names, 0.0)
    state, given_lengths = progress(rate, leader=""), iter(lengths)
    cycles, pending = 0.0, {}
    for _ in range(15):
        leader, chosen = fatigue.select_tips(pending, rate, dict.fromkeys(names, 1.0))
        state = progress(rate, pending, leader, cycles)
        segments = {name: next(given_lengths) for name in chosen}
        cycles, pending = fatigue.count(state, segments, rate)
        for name, length in segments.items():
            grown[name] += length
    for name in names:
        assert rate[name] * cycles == pytest.approx(grown[name] + pending[name], rel=1e-12)
        assert abs(pending[name]) <= 1.4


def test_a_load_that_breaks_the_body_at_once():
    material = {"E": E, "nu": NU, "g_c": 1.0}
    history = cfmpm.run(scene_from_dict(strip({"crack": (150, 10.0)}, material=material))).history
    assert history.attrs["ending"] == "fractured: crack reaches g_c in the first cycle"
    assert history.attrs["run_status"] == "fractured"
    assert (float(history.cycles_to_fracture), float(history.critical_crack_length)) == (0.0, 10.0)
    assert history.sizes["step"] == 1
    # What comes now is no growth by fatigue.
    assert TIP_STATUS[int(history.tip_status[0, 0])] == "stopped"
    assert float(history.da_dN[0, 0]) > 0.0


def test_no_other_scene_has_cycles():
    scene = strip({"crack": (150, 10.0)}, growth={"control": "crack", "increments": 1})
    del scene["fatigue"]
    assert not {"cycles", "delta_K", "da_dN"} & set(cfmpm.run(scene_from_dict(scene)).history)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"growth": None}, r"fatigue: .*growth.control: fatigue"),
        ({"growth": {"control": "crack"}}, r"fatigue: .*growth.control: fatigue"),
        ({"fatigue": None}, r"fatigue: is missing"),
        ({"growth": {"control": "fatigue", "tips": "largest"}}, r"growth.tips: largest"),
        ({"load_steps": 3}, r"load_steps: .*control: fatigue"),
        ({"kinematics": "finite"}, r"growth.control: fatigue needs kinematics: small"),
        ({"fatigue": {"C": C}}, r"fatigue.m"),
        ({"fatigue": {"C": 0, "m": 3}}, r"fatigue.C"),
        ({"fatigue": {"C": C, "m": -1}}, r"fatigue.m"),
        ({"fatigue": {"C": C, "m": 3, "load_ratio": 1}}, r"fatigue.load_ratio"),
    ],
)
def test_what_makes_no_sense_is_refused(changes, reason):
    with pytest.raises(SceneError, match=reason):
        scene_from_dict(strip({"crack": (150, 10.0)}, **changes))
