"""Stress intensity factors at the tip of an infinitesimal kink."""

from __future__ import annotations

import math

from numpy.polynomial import Polynomial

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


def kinked_factors(k_1: float, k_2: float, angle: float) -> tuple[float, float]:
    """Return the stress intensity factors at the tip of an infinitesimal kink.

    Parameters
    ----------
    k_1, k_2 : float
        Before kinking, in any one unit.
    angle : float
        Kink angle, anticlockwise from the tangent, within +-80 [deg].

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
