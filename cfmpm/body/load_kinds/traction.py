"""Traction: a dead load per length of the boundary, consistent with the basis functions."""

from __future__ import annotations

import numpy as np

from cfmpm.body.applied import Applied, Place
from cfmpm.body.grid import Grid


def apply(value: tuple[float, float], place: Place, grid: Grid) -> Applied:
    """Return f_I = t times the integral of S_I along the boundary [N/mm], with t in MPa."""
    return Applied(force=place.weights[:, None] * np.array(value))
