"""Force at a point of the body, which is a node of the grid."""

from __future__ import annotations

import numpy as np

from cfmpm.body.applied import Applied, Place
from cfmpm.body.grid import Grid


def apply(value: tuple[float, float], place: Place, grid: Grid) -> Applied:
    """Return the force at the node [N/mm]."""
    return Applied(force=np.array([value], float))
