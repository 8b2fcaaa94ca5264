from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cfmpm.fracture.criteria.kinked_factors import kinked_factors
from cfmpm.fracture.criteria.max_energy import max_energy_angle
from cfmpm.fracture.criteria.max_hoop import max_hoop_angle
from cfmpm.fracture.criteria.protocols import direction_by, load_factor_at_fracture


def kink_factor(word, k_1, k_2):
    return direction_by(word).kink_factor({"K_I": k_1, "K_II": k_2})


@given(k_1=st.floats(0, 100), k_2=st.floats(-100, 100))
def test_hoop_stress_is_largest_at_the_kink(k_1, k_2):
    if math.hypot(k_1, k_2) < 1e-3:
        return
    theta = np.radians(np.linspace(-120, 120, 48001))
    hoop = np.cos(theta / 2) ** 3 * k_1 - 3 * np.cos(theta / 2) ** 2 * np.sin(theta / 2) * k_2
    assert max_hoop_angle(k_1, k_2) == pytest.approx(np.degrees(theta[np.argmax(hoop)]), abs=0.02)


def test_limits():
    assert max_hoop_angle(1, 0) == 0
    assert max_hoop_angle(0, 1) == pytest.approx(-70.529, abs=1e-3)
    assert max_hoop_angle(0, -1) == pytest.approx(70.529, abs=1e-3)
    assert math.isnan(max_hoop_angle(0, 0))
    assert math.isnan(max_hoop_angle(-1, 0))
    assert math.isnan(max_hoop_angle(-1, 0.5))
    assert max_hoop_angle(-1, 1.0001) == pytest.approx(-90, abs=0.01)


def test_load_at_fracture():
    assert load_factor_at_fracture(0.25, 1.0) == 2.0
    assert load_factor_at_fracture(0.0, 1.0) == math.inf
    assert load_factor_at_fracture(-1e-20, 1.0) == math.inf


@pytest.mark.parametrize(("k_1", "k_2"), [(1.0, 0.0), (1.0, 0.05), (1.0, -0.4), (0.2, 1.0)])
def test_kinked_factors_for_small_and_large_angles(k_1, k_2):
    """To first order in the angle: Cotterell and Rice (1980); F_11 for a straight kink is one."""
    assert kinked_factors(k_1, k_2, 0.0) == pytest.approx((k_1, k_2))
    small = 0.5
    half = math.radians(small) / 2
    c_11 = (3 * math.cos(half) + math.cos(3 * half)) / 4
    c_12 = -3 * (math.sin(half) + math.sin(3 * half)) / 4
    c_21 = (math.sin(half) + math.sin(3 * half)) / 4
    c_22 = (math.cos(half) + 3 * math.cos(3 * half)) / 4
    expected = (c_11 * k_1 + c_12 * k_2, c_21 * k_1 + c_22 * k_2)
    assert kinked_factors(k_1, k_2, small) == pytest.approx(expected, abs=2e-4)


def test_largest_energy_in_pure_shear():
    """75.8 deg and 1.52 G of straight growth (Amestoy and Leblond 1992, section 5)."""
    angle = max_energy_angle(0.0, 1.0)
    assert angle == pytest.approx(-75.8, abs=0.2)
    assert np.hypot(*kinked_factors(0.0, 1.0, angle)) ** 2 == pytest.approx(1.52, abs=0.01)
    assert max_energy_angle(0.0, -1.0) == pytest.approx(-angle)
    assert max_energy_angle(1.0, 0.0) == 0.0


@given(k_2=st.floats(-0.2, 0.2))
def test_rules_agree_for_little_shear(k_2):
    assert max_energy_angle(1.0, k_2) == pytest.approx(max_hoop_angle(1.0, k_2), abs=0.45)


def test_what_drives_a_kink():
    """Pure shear: hoop stress 4/3 K_II^2 (Erdogan and Sih); max_energy gives the largest G."""
    assert kink_factor("max_hoop", 0.0, -3.0) == pytest.approx(4 / 3, rel=1e-12)
    assert kink_factor("cf", 1.0, 2.0) == 1.0
    angles = np.linspace(-80, 80, 801)
    most = max(np.hypot(*kinked_factors(1.0, 2.0, angle)) ** 2 / 5.0 for angle in angles)
    assert kink_factor("max_energy", 1.0, 2.0) == pytest.approx(most, rel=1e-5)
    for rule in ("max_hoop", "max_energy", "cf"):
        assert kink_factor(rule, 2.0, 0.0) == pytest.approx(1.0, rel=1e-12)
    assert math.isnan(kink_factor("max_hoop", -1.0, 0.5))
