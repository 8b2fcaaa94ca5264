"""Bends of lines of nodes: the angle at a node, and the angles above which a bend matters."""

from __future__ import annotations

import numpy as np

from cfmpm.body.grid import Floats

# Crack faces have a corner at a bend by more than this [rad]: the faces press on each other along
# the normals of both sides, and closed faces cannot slide past it. A smaller bend is that of a
# curve divided into edges, along which faces slide.
CORNER = np.radians(9.0)
# A kink of a crack by more than this [rad] is sharp: the fields at it are singular so strongly
# that the domain of a tip must not contain it.
SHARP = np.radians(20.0)


def turn(before: Floats, after: Floats) -> Floats:
    """Return the angles from some directions to others.

    Parameters
    ----------
    before, after : (..., 2) float
        Vectors of any length.

    Returns
    -------
    (...) float
        Anticlockwise positive, from -pi to pi [rad].
    """
    cross = before[..., 0] * after[..., 1] - before[..., 1] * after[..., 0]
    return np.asarray(np.arctan2(cross, (before * after).sum(axis=-1)))
