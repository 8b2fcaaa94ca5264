"""Where a crack turns to and at which load it runs."""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial import Polynomial
from scipy.optimize import minimize_scalar

_PI2, _PI3, _PI4, _PI5, _PI6 = (math.pi**k for k in range(2, 7))
# Factors of an infinitesimal kink: k_i = F_ij K_j with m = angle / pi (Amestoy and Leblond 1992,
# Int. J. Solids Struct. 29, 465-501, eqs 66-69); F_11 and F_22 are even, F_12 and F_21 odd in m.
_F11 = Polynomial(
    [
        1,
        -3 * _PI2 / 8,
        _PI2 - 5 * _PI4 / 128,
        _PI2 / 9 - 11 * _PI4 / 72 + 119 * _PI6 / 15360,
        *(5.07790, -2.88312, -0.0925, 2.996, -4.059, 1.63, 4.1),
    ]
)
_F22 = Polynomial(
    [
        1,
        -(4 + 3 * _PI2 / 8),
        8 / 3 + 29 * _PI2 / 18 - 5 * _PI4 / 128,
        -32 / 15 - 4 * _PI2 / 9 - 1159 * _PI4 / 7200 + 119 * _PI6 / 15360,
        *(10.58254, -4.78511, -1.8804, 7.280, -7.591, 0.25, 12.5),
    ]
)
_F12 = Polynomial(
    [
        -3 * math.pi / 2,
        10 * math.pi / 3 + _PI3 / 16,
        -2 * math.pi - 133 * _PI3 / 180 + 59 * _PI5 / 1280,
        *(12.313906, -7.32433, 1.5793, 4.0216, -6.915, 4.21, 4.56),
    ]
)
_F21 = Polynomial(
    [
        math.pi / 2,
        -(4 * math.pi / 3 + _PI3 / 48),
        -2 * math.pi / 3 + 13 * _PI3 / 30 - 59 * _PI5 / 3840,
        *(-6.176023, 4.44112, -1.5340, -2.0700, 4.684, -3.95, -1.32),
    ]
)


def max_hoop_angle(k_1: float, k_2: float) -> float:
    """Return the kink angle of the largest hoop stress (Erdogan and Sih 1963).

    Parameters
    ----------
    k_1, k_2 : float
        Stress intensity factors, in any one unit.

    Returns
    -------
    float
        From the tangent of the tip, anticlockwise [deg]; nan where the crack is pressed shut more
        than sheared, K_I <= -abs(K_II): the angle would be above 90 degrees.
    """
    if k_1 <= -abs(k_2):
        return math.nan
    return math.degrees(2.0 * math.atan2(-2.0 * k_2, k_1 + math.hypot(k_1, math.sqrt(8.0) * k_2)))


def kinked_factors(k_1: float, k_2: float, angle: float) -> tuple[float, float]:
    """Return the stress intensity factors at the tip of an infinitesimal kink.

    Parameters
    ----------
    k_1, k_2 : float
        Before kinking, in any one unit.
    angle : float
        Of the kink, anticlockwise from the tangent, within +-80 [deg].

    Returns
    -------
    k_1, k_2 : float
        Amestoy and Leblond (1992).
    """
    m = angle / 180.0
    even = m * m
    return (
        float(_F11(even) * k_1 + m * _F12(even) * k_2),
        float(m * _F21(even) * k_1 + _F22(even) * k_2),
    )


def max_energy_angle(k_1: float, k_2: float) -> float:
    """Return the kink angle of the largest energy release rate.

    Parameters
    ----------
    k_1, k_2 : float
        Stress intensity factors, in any one unit.

    Returns
    -------
    float
        From the tangent of the tip, anticlockwise [deg]; nan as in `max_hoop_angle`.
    """
    if k_1 <= -abs(k_2):
        return math.nan

    def released(angle: float) -> float:
        return -float(np.hypot(*kinked_factors(k_1, k_2, angle)) ** 2)

    low, high = (-80.0, 0.0) if k_2 > 0.0 else (0.0, 80.0)
    return (
        0.0
        if k_2 == 0.0
        else float(
            minimize_scalar(
                released, bounds=(low, high), method="bounded", options={"xatol": 1e-4}
            ).x
        )
    )


def kink_factor(rule: str, k_1: float, k_2: float) -> float:
    """Return what drives a tip that kinks, as a factor on its energy release rate before.

    Parameters
    ----------
    rule : {"max_hoop", "max_energy", "cf"}
        Which tells the direction.
    k_1, k_2 : float
        Stress intensity factors, in any one unit.

    Returns
    -------
    float
        max_hoop: the square of the stress intensity of the largest hoop stress, (K_I cos^2(a/2) -
        3/2 K_II sin(a)) cos(a/2) (Erdogan and Sih 1963); max_energy: the energy release rate of the
        kink (Amestoy and Leblond 1992); cf: 1. Also 1 where the crack runs straight on; nan where
        it is pressed shut more than sheared.
    """
    before = k_1 * k_1 + k_2 * k_2
    if rule == "cf" or before == 0.0:
        return 1.0
    if rule == "max_energy":
        angle = max_energy_angle(k_1, k_2)
        return (
            math.nan
            if math.isnan(angle)
            else math.hypot(*kinked_factors(k_1, k_2, angle)) ** 2 / before
        )
    turn = math.radians(max_hoop_angle(k_1, k_2))
    hoop = k_1 * math.cos(0.5 * turn) ** 2 - 1.5 * k_2 * math.sin(turn)
    return (hoop * math.cos(0.5 * turn)) ** 2 / before


def critical_load_factor(energy_release_rate: float, g_c: float) -> float:
    """Return the factor on the present load at which a linear scene reaches g_c.

    Parameters
    ----------
    energy_release_rate : float
        G at the present load [N/mm]; it grows with the square of the load.
    g_c : float
        Critical energy release rate [N/mm].

    Returns
    -------
    float
        Infinite where nothing is released.
    """
    return math.sqrt(g_c / energy_release_rate) if energy_release_rate > 0.0 else math.inf
