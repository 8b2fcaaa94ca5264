"""Transfer of the displacement to a grid that was changed by growth."""

from __future__ import annotations

import numpy as np

from cfmpm.body.grid import Floats, Grid
from cfmpm.body.points import locate
from cfmpm.kernels import location

# Offset of the point of evaluation from a node towards the centroid of one of its triangles, as a
# fraction of their distance: crack faces coincide, but such points do not.
INSIDE = 1e-6


def interpolate_displacement(old: Grid, displacement: Floats, new: Grid) -> Floats:
    """Interpolate the displacement of one grid at the nodes of another.

    Parameters
    ----------
    old, new : Grid
        Grids of the same body; the new one has longer cracks, and moved and new nodes.
    displacement : (n, 2) float
        Displacement of the nodes of the old grid [mm].

    Returns
    -------
    (m, 2) float
        Displacement of the nodes of the new grid [mm]; newly released faces are closed.
    """
    element = np.empty(len(new.nodes), np.int64)
    element[new.elements] = np.arange(len(new.elements))[:, None]
    middle = new.nodes[new.triangles].mean(axis=1)[element]
    place = new.nodes + INSIDE * (middle - new.nodes)
    found = locate(old, place)
    # Along an arc the new grid may cover a small area outside the old one.
    lost = found == location.OUTSIDE
    if lost.any():
        found[lost] = locate(old, middle[lost])
    values = old.basis_values(found, new.nodes)
    return np.einsum("pk,pki->pi", values, displacement[old.elements[found]])
