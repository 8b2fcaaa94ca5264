"""Factors of an infinitesimal kink: against the published series and an independent solution."""

from __future__ import annotations

import math

import numpy as np
import pytest
from kink_problem import kinked_by_mapping

from cfmpm.fracture.criteria.kinked_factors import kinked_factors

PI2, PI3, PI4, PI5, PI6 = (math.pi**k for k in range(2, 7))
# Amestoy and Leblond (1992), eqs 66-69: by power of m = angle / 180 deg, as printed.
SERIES = {
    "F_11": {
        0: 1.0,
        2: -3 / 8 * PI2,
        4: PI2 - 5 / 128 * PI4,
        6: PI2 / 9 - 11 / 72 * PI4 + 119 / 15360 * PI6,
        8: 5.07790,
        10: -2.88312,
        12: -0.0925,
        14: 2.996,
        16: -4.059,
        18: 1.63,
        20: 4.1,
    },
    "F_12": {
        1: -3 / 2 * math.pi,
        3: 10 / 3 * math.pi + PI3 / 16,
        5: -2 * math.pi - 133 / 180 * PI3 + 59 / 1280 * PI5,
        7: 12.313906,
        9: -7.32433,
        11: 1.5793,
        13: 4.0216,
        15: -6.915,
        17: 4.21,
        19: 4.56,
    },
    "F_21": {
        1: math.pi / 2,
        3: -4 / 3 * math.pi - PI3 / 48,
        5: -2 / 3 * math.pi + 13 / 30 * PI3 - 59 / 3840 * PI5,
        7: -6.176023,
        9: 4.44112,
        11: -1.5340,
        13: -2.0700,
        15: 4.684,
        17: -3.95,
        19: -1.32,
    },
    "F_22": {
        0: 1.0,
        2: -4 - 3 / 8 * PI2,
        4: 8 / 3 + 29 / 18 * PI2 - 5 / 128 * PI4,
        6: -32 / 15 - 4 / 9 * PI2 - 1159 / 7200 * PI4 + 119 / 15360 * PI6,
        8: 10.58254,
        10: -4.78511,
        12: -1.8804,
        14: 7.280,
        16: -7.591,
        18: 0.25,
        20: 12.5,
    },
}
NAMES = ("F_11", "F_12", "F_21", "F_22")
ANGLES = [-80.0, -35.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0]


def of_series(angle: float) -> dict[str, float]:
    """F_11, F_12, F_21, F_22 from `kinked_factors`."""
    (f_11, f_21), (f_12, f_22) = kinked_factors(1.0, 0.0, angle), kinked_factors(0.0, 1.0, angle)
    return dict(zip(NAMES, (f_11, f_12, f_21, f_22), strict=True))


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("name", NAMES)
def test_every_printed_digit_of_the_series_counts(name: str, angle: float) -> None:
    """At 80 deg the last digit of the last coefficient, 0.1 m^20, is still 9e-9."""
    m = angle / 180.0
    expected = sum(factor * m**power for power, factor in SERIES[name].items())
    assert of_series(angle)[name] == pytest.approx(expected, rel=0, abs=1e-14)


@pytest.mark.parametrize("angle", ANGLES)
def test_the_series_is_that_of_the_kink(angle: float) -> None:
    """Within the rounding of the coefficients (from 5e-6 m^8 on) and the omitted powers.

    Measured: 5e-11 below 40 deg, 1.6e-9 at 60 and 4.8e-7 at 80 deg.
    """
    m = abs(angle) / 180.0
    tolerance = 1e-14 + 6e-6 * m**8 + 6e-7 * (abs(angle) / 80.0) ** 20
    exact = dict(zip(NAMES, kinked_by_mapping(angle), strict=True))
    assert of_series(angle) == pytest.approx(exact, rel=0, abs=tolerance)


def test_what_shear_and_opening_make_at_the_kink_add() -> None:
    factors = of_series(37.0)
    k_1, k_2 = kinked_factors(2.0, -3.0, 37.0)
    assert k_1 == pytest.approx(2.0 * factors["F_11"] - 3.0 * factors["F_12"], rel=1e-15)
    assert k_2 == pytest.approx(2.0 * factors["F_21"] - 3.0 * factors["F_22"], rel=1e-15)


def test_the_mapping_finds_a_crack_that_runs_straight_on() -> None:
    np.testing.assert_allclose(kinked_by_mapping(0.0), [1.0, 0.0, 0.0, 1.0], atol=1e-15)
