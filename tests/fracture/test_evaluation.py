"""Values of a tip: load at fracture, kink, rings at a bend; each tip has its own."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import xarray as xr
from outlines import named_rectangle

import cfmpm
from cfmpm.body.crack_faces import face_pairs, smallest_openings
from cfmpm.fracture import cf, evaluation
from cfmpm.fracture.criteria.max_hoop import max_hoop_angle
from cfmpm.fracture.criteria.protocols import direction_by
from cfmpm.fracture.interaction import IntensityFactors
from cfmpm.scene import scene_from_dict


def plate(**changes: Any) -> dict[str, Any]:
    """A plate of 40 mm x 60 mm under tension, with a crack of 12 mm from the left edge."""
    return {
        "name": "plate",
        "geometry": {
            "outline": named_rectangle(40, 60),
            "cracks": [{"name": "crack", "points": [[0, 30], [12, 30]]}],
        },
        "material": {"E": 1e4, "nu": 0.3, "g_c": 0.5},
        "loads": [
            {"edge": "bottom", "traction": [0, -10]},
            {"edge": "top", "traction": [0, 10]},
        ],
        "mesh": {"element": "T3", "size": 4, "grading": {"tip_size": 0.5, "growth": 0.3}},
    } | changes


def solved(**changes: Any) -> xr.Dataset:
    return cfmpm.run(scene_from_dict(plate(**changes))).history


def with_factors(
    monkeypatch: pytest.MonkeyPatch, k_1: float, k_2: float, **more: Any
) -> xr.Dataset:
    """Values that follow from given stress intensity factors at a tip with G = 2 N/mm."""
    found = IntensityFactors(K_I=k_1, K_II=k_2, T_stress=0.0, G=2.0)
    monkeypatch.setattr(evaluation, "intensity_factors", lambda *arguments: found)
    return solved(**more).isel(step=0, tip=0)


@pytest.mark.parametrize(
    ("k_1", "k_2"), [(-1.0, 0.0), (-1.0, 0.5), (-1.0, -0.99), (-1.0, 1.0), (-1.0, -1.0), (0.0, 0.0)]
)
def test_a_closed_tip_has_no_load_at_fracture(
    monkeypatch: pytest.MonkeyPatch, k_1: float, k_2: float
) -> None:
    """With more compression than shear no load makes the tip grow, and no
    infinite value is stated.
    """
    tip = with_factors(monkeypatch, k_1, k_2)
    assert math.isnan(tip.critical_load_factor)
    assert math.isnan(tip.kink_angle)
    if (k_1, k_2) != (0.0, 0.0):
        assert math.isnan(tip.G_kink)


@pytest.mark.parametrize(
    ("k_1", "k_2"), [(1.0, 0.0), (0.5, 1.0), (0.5, -1.0), (0.0, 1.0), (-0.99, 1.0), (-0.99, -1.0)]
)
def test_a_tip_that_opens_or_is_sheared_more_than_pressed_has_one(
    monkeypatch: pytest.MonkeyPatch, k_1: float, k_2: float
) -> None:
    """sqrt(g_c / G_kink); the kink angle is negative for positive K_II."""
    tip = with_factors(monkeypatch, k_1, k_2)
    driving = 2.0 * direction_by("max_hoop").kink_factor({"K_I": k_1, "K_II": k_2})
    assert float(tip.G_kink) == pytest.approx(driving, rel=1e-14)
    assert float(tip.critical_load_factor) == pytest.approx(math.sqrt(0.5 / driving), rel=1e-14)
    assert float(tip.kink_angle) == max_hoop_angle(k_1, k_2)
    assert np.sign(tip.kink_angle) == -np.sign(k_2)


def test_nothing_that_opens_it_needs_an_infinite_load(monkeypatch: pytest.MonkeyPatch) -> None:
    found = IntensityFactors(K_I=1.0, K_II=0.0, T_stress=0.0, G=0.0)
    monkeypatch.setattr(evaluation, "intensity_factors", lambda *arguments: found)
    assert float(solved().critical_load_factor[0, 0]) == math.inf


@pytest.mark.parametrize("direction", ["max_hoop", "max_energy", "cf"])
def test_the_kink_is_that_of_the_direction_of_growth(
    monkeypatch: pytest.MonkeyPatch, direction: str
) -> None:
    growth = {"control": "crack", "increments": 1, "direction": direction}
    tip = with_factors(monkeypatch, 1.0, 0.8, growth=growth)
    factor = direction_by(direction).kink_factor({"K_I": 1.0, "K_II": 0.8})
    assert float(tip.G_kink) == pytest.approx(factor * float(tip.G), rel=1e-9)
    # The load of the step is the one at fracture.
    assert float(tip.critical_load_factor) == pytest.approx(float(tip.load_factor), rel=1e-12)


def test_without_a_toughness_there_is_no_load_at_fracture(monkeypatch: pytest.MonkeyPatch) -> None:
    history = solved(material={"E": 1e4, "nu": 0.3})
    assert np.isfinite(history.G_kink).all()
    assert np.isnan(history.critical_load_factor).all()
    # Nor one of infinity where nothing drives the tip.
    found = IntensityFactors(K_I=1.0, K_II=0.0, T_stress=0.0, G=0.0)
    monkeypatch.setattr(evaluation, "intensity_factors", lambda *arguments: found)
    assert np.isnan(solved(material={"E": 1e4, "nu": 0.3}).critical_load_factor).all()


def test_values_are_those_of_the_largest_radius() -> None:
    history = solved(fracture={"radii": [3.0, 9.0, 6.0]}).isel(step=0, tip=0)
    np.testing.assert_array_equal(history.domain_radius, [3.0, 9.0, 6.0])
    for name in ("J", "G", "K_I", "K_II", "T_stress", "cf_norm", "cf_angle"):
        values = history[f"{name}_radius"].values
        assert float(history[name]) == values[1]
        assert len(set(values)) == 3
    force = math.hypot(float(history.cf_x), float(history.cf_y))
    assert force == pytest.approx(float(history.cf_norm), rel=1e-14)


def test_j_of_a_ring_ends_at_a_sharp_bend_of_the_crack() -> None:
    """It ends at 0.9 of the distance; domains of a growing tip may contain the bend."""
    geometry = plate()["geometry"]
    points = [[0, 28], [12, 28], [12 + 3 * math.cos(0.7), 28 + 3 * math.sin(0.7)]]
    geometry = geometry | {"cracks": [{"points": points}]}
    growth = {"control": "crack", "increments": 1}
    mesh = {"element": "T3", "size": 2, "grading": {"tip_size": 0.25, "growth": 0.2}}
    radii = [0.9 * 3.0, 2.0, 5.0, 8.0]
    history = solved(geometry=geometry, growth=growth, mesh=mesh, fracture={"radii": radii})
    j, force = (history[f"{name}_radius"].values[0, 0] for name in ("J", "cf_norm"))
    np.testing.assert_allclose(j[2:], j[0], rtol=1e-12)
    assert abs(j[1] / j[0] - 1.0) > 1e-6
    assert len(set(force)) == 4


def test_each_tip_has_the_opening_and_the_material_of_its_own_crack(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Two cracks in halves with different stiffness and toughness."""
    smallest = {"right": -2.0, "left": -1.0}
    monkeypatch.setattr(evaluation, "smallest_openings", lambda *arguments: smallest)
    geometry = plate()["geometry"] | {
        "cracks": [
            {"name": "left", "points": [[0, 30], [6, 30]]},
            {"name": "right", "points": [[40, 30], [34, 30]]},
        ],
        "regions": [
            {
                "name": "half",
                "polygon": [[20, 0], [40, 0], [40, 60], [20, 60]],
                "material": {"E": 4e4, "nu": 0.3, "g_c": 2.0},
            }
        ],
    }
    history = solved(geometry=geometry, kinematics="small").isel(step=0)
    modulus = np.array([1e4, 4e4]) / (1.0 - 0.3**2)
    g = (history.K_I**2 + history.K_II**2) / modulus
    np.testing.assert_allclose(history.G, g, rtol=1e-12)
    np.testing.assert_allclose(history.J, g, rtol=0.1)
    np.testing.assert_array_equal(history.min_opening, [-1.0, -2.0])
    expected = np.sqrt(np.array([0.5, 2.0]) / history.G_kink.values)
    np.testing.assert_allclose(history.critical_load_factor, expected, rtol=1e-12)


def test_contact_is_summed_over_the_whole_grid() -> None:
    """A closed sheared crack: contact forces enter K_II at both tips."""
    geometry = plate()["geometry"] | {"cracks": [{"points": [[14, 22], [26, 38]]}]}
    loads = [
        {"edge": "bottom", "traction": [0, 10]},
        {"edge": "top", "traction": [0, -10]},
    ]
    mesh = {"element": "T6", "size": 4, "grading": {"tip_size": 0.3, "growth": 0.3}}
    history = solved(geometry=geometry, loads=loads, mesh=mesh).isel(step=0)
    assert int(history.contact_pairs) > 5
    assert (np.abs(history.K_I) < 0.02 * np.abs(history.K_II)).all()
    np.testing.assert_allclose(history.J, history.G, rtol=0.01)


def test_g_is_j_at_finite_deformation() -> None:
    history = solved(kinematics="finite", fracture={"radii": 3}).isel(step=0, tip=0)
    np.testing.assert_array_equal(history.G_radius, history.J_radius)
    assert np.isnan(history["critical_load_factor"]).all()  # what is not linear has none


def test_openings_have_the_sign_of_the_gap() -> None:
    """Zero where the crack is open, negative by the overlap of its faces."""

    result = cfmpm.run(scene_from_dict(plate()))
    grid, motion = result.grid, result.displacement
    gap = face_pairs(grid, "crack").opening(motion)
    assert gap.min() > 0.0
    assert smallest_openings(grid, motion) == {"crack": 0.0}
    assert smallest_openings(grid, -motion)["crack"] == pytest.approx(-gap.max(), rel=1e-14)
    assert float(result.history.min_opening[0, 0]) == 0.0


@pytest.mark.parametrize(("j", "g"), [(-1e-30, 0.0), (0.0, 0.0), (0.5, 0.5), (-0.5, math.nan)])
def test_j_below_zero_by_round_off_is_no_energy_release_rate(
    monkeypatch: pytest.MonkeyPatch, j: float, g: float
) -> None:
    """At finite deformation, where G is J."""
    monkeypatch.setattr(cf, "j_integral", lambda *_: j)
    values = solved(kinematics="finite")
    np.testing.assert_array_equal(values["G"], np.full_like(values["G"], g))
