"""Fatigue cycles against closed forms, and against Paris' law with K of handbooks."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from outlines import named_rectangle
from scipy.integrate import quad

import cfmpm
from cfmpm.errors import SceneError
from cfmpm.fracture import fatigue
from cfmpm.fracture.fatigue import Progress
from cfmpm.output.variables import TIP_STATUS
from cfmpm.scene import scene_from_dict
from cfmpm.scene.growth import Fatigue

C, M = 1e-12, 3.0


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


WIDTH, HEIGHT, TENSION, G_C, E, NU = 50.0, 300.0, 100.0, 20.0, 210e3, 0.3


def handbook_k(a):
    """Single edge crack in tension, ends free to turn (Tada, Paris and Irwin 2000, 2.11): 0.5 %."""
    x = 0.5 * np.pi * a / WIDTH
    shape = 0.752 + 2.02 * a / WIDTH + 0.37 * (1.0 - np.sin(x)) ** 3
    return TENSION * np.sqrt(np.pi * a) * np.sqrt(np.tan(x) / x) * shape / np.cos(x)


def strip(cracks, m=M, size=0.5, **changes) -> dict[str, Any]:
    return {
        "name": "strip",
        "geometry": {
            "outline": named_rectangle(WIDTH, HEIGHT),
            "cracks": [
                {"name": name, "points": [[0, y], [a, y]]} for name, (y, a) in cracks.items()
            ],
        },
        "material": {"E": E, "nu": NU, "g_c": G_C},
        "loads": [
            {"edge": "bottom", "traction": [0, -TENSION]},
            {"edge": "top", "traction": [0, TENSION]},
        ],
        "mesh": {"element": "T6", "size": 10, "grading": {"tip_size": size, "growth": 0.3}},
        "fracture": {"refine": size},
        "growth": {"control": "fatigue"},
        "fatigue": {"C": C, "m": m},
    } | changes


def cycles_to(length, start, m):
    """Paris' law with the handbook's K."""
    return [quad(lambda a: 1.0 / (C * handbook_k(a) ** m), start, end)[0] for end in length]


def length_after(cycles, start, m):
    """Crack length after a number of cycles: the inverse of `cycles_to`."""
    lengths = np.linspace(start, start + 10.0, 500)
    return np.interp(cycles, cycles_to(lengths, start, m), lengths)


@pytest.mark.parametrize("m", [2.5, 3.5])
def test_life_of_an_edge_crack(m):
    """N(a) by Paris' law with the handbook's K, up to the length at which G is g_c.

    N is 0.1 to 0.6 % above, on a grid half as fine 0.7 to 1.3 %: m times the error of K.
    """
    history = cfmpm.run(scene_from_dict(strip({"crack": (150, 10.0)}, m, 0.25))).history
    length = history.crack_length.values[:, 0]
    assert history.sizes["step"] > 30
    np.testing.assert_allclose(history.cycles[1:], cycles_to(length[1:], 10.0, m), rtol=0.01)
    np.testing.assert_allclose(history.delta_K[:, 0], handbook_k(length), rtol=0.005)
    np.testing.assert_allclose(history.da_dN, C * history.delta_K**m, rtol=1e-12)
    np.testing.assert_array_equal(history.load_factor, 1.0)
    assert np.isnan(history.fracture_energy).all()

    words = history.attrs["ending"].split()
    assert words[:4] == ["fractured:", "crack", "reaches", "g_c"]
    critical, life = float(history.critical_crack_length), float(history.cycles_to_fracture)
    assert [float(words[9]), float(words[12])] == pytest.approx([critical, life], rel=1e-5)
    assert length[-2] < critical <= length[-1]
    assert history.cycles[-2] < life <= history.cycles[-1]
    toughness = np.sqrt(G_C * E / (1 - NU**2))
    assert handbook_k(critical) == pytest.approx(toughness, rel=0.01)
    assert np.interp(critical, length, history.cycles) == pytest.approx(life, rel=1e-4)


def test_unequal_cracks_grow_in_one_number_of_cycles():
    """Two edge cracks so far apart that each has the handbook's K; both grow."""
    cracks = {"short": (100, 8.0), "long": (200, 10.0)}
    history = cfmpm.run(scene_from_dict(strip(cracks))).history
    assert history.cycles.dims == ("step",)
    assert (np.diff(history.cycles) > 0).all()
    expected = length_after(history.cycles.values, 8.0, M)
    # Places are those of the law to within an element.
    np.testing.assert_allclose(history.tip_x[:, 0], expected, atol=0.5)
    length = history.tip_x.values[1:, 1]
    np.testing.assert_allclose(history.cycles[1:], cycles_to(length, 10.0, M), rtol=0.015)
    slow = history.tip_x[:, 0].values
    assert slow[-1] - 8.0 > 2.0
    assert (np.diff(slow) > 0).sum() < len(slow) / 2


def test_twins_keep_together():
    history = cfmpm.run(
        scene_from_dict(
            strip(
                {"low": (100, 10.0), "high": (200, 10.0)},
                growth={"control": "fatigue", "increments": 6},
            )
        )
    ).history
    assert np.abs(np.diff(history.tip_x, axis=1)).max() < 0.5
    assert (history.tip_x[-1] > 12.0).all()
    assert history.attrs["run_status"] == "increments"


def test_a_crack_arrests_at_the_threshold():
    """Double cantilever beam with opening d: K = 3^0.5 E' d h^1.5 / (4 (a + 0.6728 h)^2).

    From K and opening of the corrected beam (Fichter 1983, Int. J. Fract. 22, 133-143); pressing
    the beam along its axis keeps the crack straight.
    """
    h, opening, threshold = 10.0, 0.05, 28.0
    scene = {
        "name": "arms",
        "geometry": {
            "outline": named_rectangle(90, 20),
            "cracks": [{"points": [[0, 10], [30, 10]]}],
        },
        "material": {"E": 70e3, "nu": 0.33},
        "loads": [
            {"edge": "right", "displacement": {"x": 0}},
            {"box": [[-1, 10], [0, 20]], "displacement": {"y": opening / 2}},
            {"box": [[-1, 0], [0, 10]], "displacement": {"y": -opening / 2}},
            {"edge": "left", "traction": [3.0, 0]},
        ],
        "mesh": {"element": "T6", "size": 1.0, "grading": "uniform"},
        "growth": {"control": "fatigue"},
        "fatigue": {"C": C, "m": M, "threshold": threshold},
    }
    history = cfmpm.run(scene_from_dict(scene)).history
    assert history.attrs["run_status"] == "arrested"
    assert history[["cycles_to_fracture", "critical_crack_length"]].isnull().all().all()
    modulus = 70e3 / (1 - 0.33**2)
    arrest = np.sqrt(np.sqrt(3) * modulus * opening * h**1.5 / 4 / threshold) - 0.6728 * h
    grown = history.tip_x[:, 0].values
    assert grown[0] + 5 < arrest
    # To within the segment in which it stops.
    assert arrest - 0.5 < grown[-1] < arrest + 1.5
    assert history.da_dN[-1, 0] == 0.0
    assert float(history.delta_K[-1, 0]) <= threshold < float(history.delta_K[-2, 0])


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
