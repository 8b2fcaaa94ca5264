"""The holes of the beam of section 5.5, and how near a crack comes to them."""

from __future__ import annotations

import numpy as np

from cfmpm.body.grid import Floats

INCH = 25.4
# Centres of the holes, and their radius [mm].
BOTTOM, MIDDLE, TOP = (np.array([6.0, y]) * INCH for y in (2.75, 4.75, 6.75))
HOLE = 0.25 * INCH
# The specimens by a and x in inches, as variants are named.
SPECIMENS = {
    "15_5": "case I (a = 1.5 in, x = 5 in)",
    "10_6": "case II as a = 1 in, x = 6 in",
    "10_4": "case II as a = 1 in, x = 4 in",
}


def distance_to_path(path: Floats, point: Floats) -> float:
    """Return the smallest distance from a point to a path [mm]."""
    start, along = path[:-1], np.diff(path, axis=0)
    part = np.clip(((point - start) * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
    return float(np.hypot(*(start + part[:, None] * along - point).T).min())


def gap_to_hole(path: Floats, hole: Floats) -> float:
    """Return the distance of a path from the edge of a hole, negative inside it [mm]."""
    return distance_to_path(path, hole) - HOLE
