"""Body force, such as weight: uniform in the body."""

from __future__ import annotations

import numpy as np

from cfmpm.body.applied import Applied, Place
from cfmpm.body.grid import Grid


def apply(value: tuple[float, float], place: Place, grid: Grid) -> Applied:
    """Return the density of the force [N/mm^3]; `body.loads` sums it over the points."""
    return Applied(density=np.array(value, float))
