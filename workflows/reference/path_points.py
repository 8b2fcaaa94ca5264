"""Paths of cracks that are known otherwise."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cfmpm.body.grid import Floats

FOLDER = Path(__file__).parent


def reference(name: str) -> Floats:
    """Return points of a path that is known otherwise, (k, 2) [mm]; their file says from where."""
    return np.loadtxt(FOLDER / f"{name}.csv", delimiter=",", comments="#")
