"""Carrying the motion of a body over to the grid that growth has changed."""

from __future__ import annotations

import numpy as np

from cfmpm.body.grid import Floats, Grid
from cfmpm.body.points import locate
from cfmpm.kernels import location

# How far from a node, towards the middle of a triangle that it belongs to, the old grid is asked:
# the faces of a crack lie on each other, those of the triangle do not.
INSIDE = 1e-6


def interpolate_displacement(old: Grid, displacement: Floats, new: Grid) -> Floats:
    """Interpolate the displacement of one grid at the nodes of another.

    Parameters
    ----------
    old, new : Grid
        Of the same body; the new one has longer cracks, and nodes elsewhere.
    displacement : (n, 2) float
        Of the nodes of the old grid [mm].

    Returns
    -------
    (m, 2) float
        Of the nodes of the new one [mm]; a face that has just opened is still closed.
    """
    element = np.empty(len(new.nodes), np.int64)
    element[new.elements] = np.arange(len(new.elements))[:, None]
    middle = new.nodes[new.triangles].mean(axis=1)[element]
    place = new.nodes + INSIDE * (middle - new.nodes)
    found = locate(old, place)
    # Next to an arc the new grid may cut a corner that the old one did not reach.
    lost = found == location.OUTSIDE
    if lost.any():
        found[lost] = locate(old, middle[lost])
    values = old.basis_values(found, new.nodes)
    return np.einsum("pk,pki->pi", values, displacement[old.elements[found]])
