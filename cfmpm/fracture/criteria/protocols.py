"""Interfaces of criteria, and their lookup by the words of a scene."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from cfmpm.registry.criteria import DIRECTIONS, DRIVING_FORCES
from cfmpm.registry.table import load

Floats = NDArray[np.float64]
# Values of one tip by their names in the history: K_I, K_II, T_stress, J, G, cf_x, cf_y ...
TipValues = Mapping[str, Any]


class Direction(Protocol):
    """A criterion for the direction of crack growth."""

    def heading(self, values: TipValues, tangent: Floats) -> Floats:
        """Return the unit vector of the direction of growth.

        Parameters
        ----------
        values : mapping of str to float
            Values of the tip by their names in the history.
        tangent : (2,) float
            Unit vector along the crack at its tip, pointing ahead.

        Returns
        -------
        (2,) float
            nan where the criterion gives no direction: such a tip does not grow.
        """

    def kink_factor(self, values: TipValues) -> float:
        """Return the ratio of the energy release rate of a kink to that before kinking.

        It is called only where K_I and K_II are defined and not both zero; nan where the criterion
        gives no direction.
        """


class DrivingForce(Protocol):
    """The quantity that is compared with the critical energy release rate [N/mm]."""

    def __call__(self, values: TipValues) -> float:
        """Return the driving force of a tip [N/mm]; it is proportional to the load squared."""


class DirectionByAngle(ABC):
    """A direction that is given by an angle from the tangent."""

    @abstractmethod
    def angle(self, values: TipValues) -> float:
        """Return the angle from the tangent, anticlockwise [deg]; nan where there is none."""

    def heading(self, values: TipValues, tangent: Floats) -> Floats:
        """Return the tangent turned by the angle, (2,)."""
        turned = np.exp(1j * np.radians(self.angle(values))) * complex(*tangent)
        return np.array([turned.real, turned.imag])

    @abstractmethod
    def kink_factor(self, values: TipValues) -> float:
        """As in `Direction`."""


def direction_by(word: str) -> Direction:
    """Return the criterion for a word of ``growth.direction``."""
    return cast(Direction, load(DIRECTIONS[word].place)())


def driving_force_by(word: str) -> DrivingForce:
    """Return the driving force for a word of ``growth.criterion``."""
    return cast(DrivingForce, load(DRIVING_FORCES[word].place))


def is_closed(k_1: Any, k_2: Any) -> Any:
    """Whether a tip is closed by more compression than shear, so that it cannot grow.

    Parameters
    ----------
    k_1, k_2 : float or (tip,) float
        Stress intensity factors, in any one unit.

    Returns
    -------
    bool or (tip,) bool
        False where they are nan.
    """
    return k_1 <= -abs(k_2)


def load_factor_at_fracture(driving: float, toughness: float) -> float:
    """Return the factor on the present load at which a linear scene reaches its toughness.

    Parameters
    ----------
    driving, toughness : float
        Driving force at the present load, and toughness, in the same unit. The driving force is
        proportional to the load squared.

    Returns
    -------
    float
        Infinite without a driving force.

    Examples
    --------
    >>> load_factor_at_fracture(driving=0.25, toughness=1.0)
    2.0
    >>> load_factor_at_fracture(driving=0.0, toughness=1.0)
    inf
    """
    return math.sqrt(toughness / driving) if driving > 0.0 else math.inf
