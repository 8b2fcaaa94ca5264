"""The direction of the largest hoop stress (Erdogan and Sih 1963, J. Basic Eng. 85, 519-527)."""

from __future__ import annotations

import math

from cfmpm.fracture.criteria.protocols import DirectionByAngle, TipValues, is_closed


class MaxHoop(DirectionByAngle):
    """Direction in which the hoop stress at the tip is largest."""

    def angle(self, values: TipValues) -> float:
        """Return `max_hoop_angle` of K_I and K_II."""
        return max_hoop_angle(values["K_I"], values["K_II"])

    def kink_factor(self, values: TipValues) -> float:
        """Return the square of the hoop stress intensity factor over K_I^2 + K_II^2.

        At the angle a this factor is (K_I cos^2(a/2) - 3/2 K_II sin(a)) cos(a/2) (Erdogan and Sih).
        """
        k_1, k_2 = values["K_I"], values["K_II"]
        turn = math.radians(max_hoop_angle(k_1, k_2))
        hoop = k_1 * math.cos(0.5 * turn) ** 2 - 1.5 * k_2 * math.sin(turn)
        return float((hoop * math.cos(0.5 * turn)) ** 2 / (k_1 * k_1 + k_2 * k_2))


def max_hoop_angle(k_1: float, k_2: float) -> float:
    """Return the kink angle of the largest hoop stress.

    Parameters
    ----------
    k_1, k_2 : float
        Stress intensity factors, in any one unit.

    Returns
    -------
    float
        From the tangent of the tip, anticlockwise [deg]; nan where the tip is closed by more
        compression than shear, K_I <= -abs(K_II): the angle would exceed 90 degrees.

    Examples
    --------
    >>> round(max_hoop_angle(0.0, 1.0), 1)  # pure shear
    -70.5
    >>> max_hoop_angle(-1.0, 0.5)
    nan
    """
    if is_closed(k_1, k_2):
        return math.nan
    return math.degrees(2.0 * math.atan2(-2.0 * k_2, k_1 + math.hypot(k_1, math.sqrt(8.0) * k_2)))
