"""Where a crack turns to and at which load it runs."""

from __future__ import annotations

import math


def max_hoop_angle(k_1: float, k_2: float) -> float:
    """Return the kink angle of the largest hoop stress (Erdogan and Sih 1963).

    Parameters
    ----------
    k_1, k_2 : float
        Stress intensity factors, in any one unit.

    Returns
    -------
    float
        From the tangent of the tip, anticlockwise [deg]; nan where the hoop stress is nowhere
        tensile because both factors vanish.
    """
    if k_1 == 0.0 and k_2 == 0.0:
        return math.nan
    return math.degrees(2.0 * math.atan2(-2.0 * k_2, k_1 + math.hypot(k_1, math.sqrt(8.0) * k_2)))


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
