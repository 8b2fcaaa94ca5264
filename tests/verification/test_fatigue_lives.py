"""Lives of cracks in fatigue: Paris' law with the K of handbooks, and arrest at the threshold."""

from __future__ import annotations

import numpy as np
import pytest
from fatigue_strip import G_C, NU, TENSION, WIDTH, C, E, M, strip
from outlines import named_rectangle
from scipy.integrate import quad

import cfmpm
from cfmpm.scene import scene_from_dict


def handbook_k(a):
    """Single edge crack in tension, ends free to turn (Tada, Paris and Irwin 2000, 2.11): 0.5 %."""
    x = 0.5 * np.pi * a / WIDTH
    shape = 0.752 + 2.02 * a / WIDTH + 0.37 * (1.0 - np.sin(x)) ** 3
    return TENSION * np.sqrt(np.pi * a) * np.sqrt(np.tan(x) / x) * shape / np.cos(x)


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
