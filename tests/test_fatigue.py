"""Cycles of fatigue, against closed forms."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.typing import ArrayLike

from cfmpm.errors import SceneError
from cfmpm.fatigue import paris_cycles
from cfmpm.scene import scene_from_dict
from cfmpm.simulation import run

C, M = 1e-12, 3.0


def history_of(
    length: ArrayLike, k_1: ArrayLike, k_2: ArrayLike = 0.0, load_factor: ArrayLike = 1.0
) -> xr.Dataset:
    """One tip on the x axis; K at the load factor of its step."""
    length = np.asarray(length, float)[:, None]
    full = np.zeros_like(length)
    return xr.Dataset(
        {
            "tip_x": (("step", "tip"), length),
            "tip_y": (("step", "tip"), full),
            "K_I": (("step", "tip"), full + np.reshape(k_1, (-1, 1))),
            "K_II": (("step", "tip"), full + np.reshape(k_2, (-1, 1))),
        },
        {"load_factor": ("step", full[:, 0] + load_factor), "tip": ["end"]},
    )


def test_constant_range() -> None:
    cycles = paris_cycles(history_of([1, 2, 4], 100.0), C, M)
    assert cycles.dims == ("step", "tip")
    np.testing.assert_allclose(cycles[:, 0], np.array([0, 1, 3]) / (C * 100.0**M), rtol=1e-14)


def test_exact_where_the_inverse_rate_is_linear_in_the_length() -> None:
    """dN/da = 1e6 (3 - a): N = 1e6 (3 a - a^2 / 2)."""
    length = np.array([0.0, 0.1, 0.7, 1.0, 2.0])
    k = (C * 1e6 * (3.0 - length)) ** (-1.0 / M)
    cycles = paris_cycles(history_of(length, k), C, M)
    np.testing.assert_allclose(cycles[:, 0], 1e6 * (3 * length - length**2 / 2), rtol=1e-13)


def test_crack_control_states_k_at_another_load() -> None:
    factor = np.array([2.0, 1.5, 0.5])
    at_scene = paris_cycles(history_of([1, 2, 4], [100, 120, 300]), C, M)
    along = paris_cycles(history_of([1, 2, 4], factor * [100, 120, 300], 0.0, factor), C, M)
    np.testing.assert_allclose(along, at_scene, rtol=1e-14)


@pytest.mark.parametrize(
    ("more", "k"),
    [({"load_ratio": 0.4}, 60.0), ({"maximum_load": 3.0}, 300.0), ({"threshold": 99.0}, 100.0)],
)
def test_the_range_of_a_cycle(more: dict[str, float], k: float) -> None:
    cycles = paris_cycles(history_of([1, 2], 100.0), C, M, **more)
    assert float(cycles[-1, 0]) == pytest.approx(1.0 / (C * k**M), rel=1e-14)


def test_both_modes_count_and_compression_does_not() -> None:
    mixed = paris_cycles(history_of([1, 2], 3.0, 4.0), C, M)
    assert float(mixed[-1, 0]) == pytest.approx(1.0 / (C * 5.0**M))
    closed = paris_cycles(history_of([1, 2], -3.0, 4.0), C, M)
    assert float(closed[-1, 0]) == pytest.approx(1.0 / (C * 4.0**M))


def test_a_crack_arrests_at_the_threshold() -> None:
    cycles = paris_cycles(history_of([1, 2, 3, 4], [50, 40, 30, 50]), C, M, threshold=30.0)
    assert np.isfinite(cycles[:2, 0]).all()
    assert np.isinf(cycles[2:, 0]).all()


def test_a_tip_that_waits_spends_no_cycles() -> None:
    """Not even below the threshold: another tip runs there."""
    cycles = paris_cycles(history_of([1, 2, 2, 3], [50, 50, 0, 50]), C, M)
    assert cycles[1, 0] == cycles[2, 0] == 1.0 / (C * 50.0**M)
    assert np.isinf(cycles[3, 0])  # from a state without any range it would not have gone on
    steady = paris_cycles(history_of([1, 2, 2, 3], 50.0), C, M)
    np.testing.assert_allclose(steady[:, 0] * C * 50.0**M, [0, 1, 1, 2], rtol=1e-14)


def test_on_arrival_the_last_range_counts() -> None:
    history = history_of([1, 2, 3, 3], [50, 60, np.nan, np.nan], 0.0, [1, 1, 1, np.nan])
    cycles = paris_cycles(history, C, M)[:, 0] * C
    half = 0.5 * (50.0**-M + 60.0**-M)
    expected = [0, half, half + 60.0**-M, half + 60.0**-M]
    np.testing.assert_allclose(cycles, expected, rtol=1e-14)


# The right half of a plate of 200 x 200 mm with a crack of 8 mm: one tip.
CENTRE: dict[str, Any] = {
    "name": "wide",
    "geometry": {
        "outline": [
            {"at": [0, 0], "edge": "bottom"},
            {"at": [100, 0], "edge": "right"},
            {"at": [100, 200], "edge": "top"},
            {"at": [0, 200], "edge": "symmetry"},
        ],
        "cracks": [{"points": [[0, 100], [4, 100]]}],
    },
    "material": {"E": 210e3, "nu": 0.3, "g_c": 1.0},
    "loads": [
        {"edge": "symmetry", "displacement": {"x": 0}},
        {"edge": "bottom", "traction": [0, -50]},
        {"edge": "top", "traction": [0, 50]},
    ],
    "mesh": {"element": "T6", "size": 20, "grading": {"tip_size": 0.2, "growth": 0.3}},
    "fracture": {"refine": 0.3},
    "growth": {"control": "crack", "increments": 12},
}


@pytest.mark.parametrize("m", [2.5, 3.5])
def test_centre_crack_in_a_wide_plate(m: float) -> None:
    """K = S sqrt(pi a): N = (a1^(1-m/2) - a0^(1-m/2)) / (C (S sqrt pi)^m (1-m/2)).

    The plate of finite width has a K that is 0.1 to 0.4 % larger (Feddersen's secant).
    """
    history = run(scene_from_dict(CENTRE | {"fatigue": {"C": C, "m": m}})).history
    a_0, a_1 = (float(history["tip_x"][k, 0]) for k in (0, -1))
    assert a_1 > 1.4 * a_0
    power = 1.0 - m / 2.0
    exact = (a_1**power - a_0**power) / (C * (50.0 * np.sqrt(np.pi)) ** m * power)
    assert float(history["cycles"][-1, 0]) == pytest.approx(exact, rel=0.02)
    assert history["cycles"].attrs["units"] == "1"


def test_only_when_asked_for(tmp_path: Path) -> None:
    scene = CENTRE | {"growth": {"control": "crack", "increments": 1}}
    assert "cycles" not in run(scene_from_dict(scene)).history


@pytest.mark.parametrize("growth", [None, {"control": "load"}])
def test_fatigue_needs_a_path(growth: dict[str, Any] | None) -> None:
    with pytest.raises(SceneError, match=r"fatigue: .*needs growth with control: crack"):
        scene_from_dict(CENTRE | {"growth": growth, "fatigue": {"C": C, "m": 3}})


@pytest.mark.parametrize(("key", "value"), [("C", 0), ("m", -1), ("load_ratio", 1)])
def test_values_that_mean_nothing_are_refused(key: str, value: float) -> None:
    with pytest.raises(SceneError, match=rf"fatigue\.{key}"):
        scene_from_dict(CENTRE | {"fatigue": {"C": C, "m": 3, key: value}})
