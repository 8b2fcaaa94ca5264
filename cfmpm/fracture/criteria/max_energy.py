"""The direction of the largest energy release rate, by the factors of an infinitesimal kink."""

from __future__ import annotations

import math

import numpy as np

from cfmpm.fracture.criteria.kinked_factors import kinked_factors
from cfmpm.fracture.criteria.protocols import DirectionByAngle, TipValues, is_closed


class MaxEnergy(DirectionByAngle):
    """Direction in which a kink releases the most energy (Amestoy and Leblond 1992)."""

    def angle(self, values: TipValues) -> float:
        """Return `max_energy_angle` of K_I and K_II."""
        return max_energy_angle(values["K_I"], values["K_II"])

    def kink_factor(self, values: TipValues) -> float:
        """Return the energy release rate of the kink over that before kinking."""
        k_1, k_2 = values["K_I"], values["K_II"]
        angle = max_energy_angle(k_1, k_2)
        if math.isnan(angle):
            return math.nan
        return math.hypot(*kinked_factors(k_1, k_2, angle)) ** 2 / (k_1 * k_1 + k_2 * k_2)


def max_energy_angle(k_1: float, k_2: float) -> float:
    """Return the kink angle of the largest energy release rate [deg].

    Arguments, sign, and where the angle is nan are those of `max_hoop.max_hoop_angle`.
    """
    if is_closed(k_1, k_2):
        return math.nan
    from scipy.optimize import minimize_scalar  # takes long, and few scenes need it

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
