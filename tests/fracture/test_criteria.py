from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cfmpm.fracture.criteria import critical_load_factor, max_hoop_angle


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


def test_load_at_fracture():
    assert critical_load_factor(0.25, 1.0) == 2.0
    assert critical_load_factor(0.0, 1.0) == math.inf
    assert critical_load_factor(-1e-20, 1.0) == math.inf
