"""What a criterion has to provide, and how the rest of the program gets it by its word."""

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
# Of one tip, by their names in the history: K_I, K_II, T_stress, J, G, cf_x, cf_y ...
TipValues = Mapping[str, Any]


class Direction(Protocol):
    """A criterion for where a crack turns to."""

    def heading(self, values: TipValues, tangent: Floats) -> Floats:
        """Return the unit vector in which a tip runs.

        Parameters
        ----------
        values : mapping of str to float
            Of the tip, by their names in the history.
        tangent : (2,) float
            Unit vector along the crack, out of its tip.

        Returns
        -------
        (2,) float
            nan where the criterion has no answer: such a tip does not run.
        """

    def kink_factor(self, values: TipValues) -> float:
        """Return what drives a tip that kinks, as a factor on its energy release rate before.

        Asked only where there are stress intensity factors that are not both zero; nan where the
        criterion has no answer.
        """


class DrivingForce(Protocol):
    """What is compared with the critical energy release rate [N/mm]."""

    def __call__(self, values: TipValues) -> float:
        """Return the driving force of a tip [N/mm]; it grows with the square of the load."""


class DirectionByAngle(ABC):
    """A direction that is told by an angle from the tangent."""

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
    """Return the criterion of a word of ``growth.direction``."""
    return cast(Direction, load(DIRECTIONS[word].place)())


def driving_force_by(word: str) -> DrivingForce:
    """Return what a word of ``growth.criterion`` compares with g_c."""
    return cast(DrivingForce, load(DRIVING_FORCES[word].place))


def is_closed(k_1: Any, k_2: Any) -> Any:
    """Whether a tip is pressed shut more than sheared: it has no direction to run in.

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
        Driving force at the present load, and what it is compared with, in any one unit; the
        driving force grows with the square of the load.

    Returns
    -------
    float
        Infinite where nothing drives.

    Examples
    --------
    >>> load_factor_at_fracture(driving=0.25, toughness=1.0)
    2.0
    >>> load_factor_at_fracture(driving=0.0, toughness=1.0)
    inf
    """
    return math.sqrt(toughness / driving) if driving > 0.0 else math.inf
