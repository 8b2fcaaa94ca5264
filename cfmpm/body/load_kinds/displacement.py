"""Prescribed displacement: of an edge, the nodes in a box, or a point."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from cfmpm.body.applied import Applied, Place
from cfmpm.body.grid import Grid


class Components(Protocol):
    """Prescribed components [mm]; None for a free component."""

    x: float | None
    y: float | None


def apply(value: Components, place: Place, grid: Grid) -> Applied:
    """Prescribe the given components [mm]; the others are free."""
    components = [np.nan if part is None else part for part in (value.x, value.y)]
    return Applied(displacement=np.tile(np.array(components, float), (len(place.nodes), 1)))
