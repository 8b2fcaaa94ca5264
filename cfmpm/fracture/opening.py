"""The opening of crack faces."""

from __future__ import annotations

import numpy as np

from cfmpm.grid import Floats, Grid


def smallest_openings(grid: Grid, displacement: Floats) -> dict[str, float]:
    """Find the smallest opening of the faces of each crack.

    Parameters
    ----------
    grid : Grid
    displacement : (n, 2) float
        Of the nodes [mm].

    Returns
    -------
    dict of str to float
        By crack [mm]; negative where the faces overlap, which they do freely: contact is not
        modelled, and K_I and the configurational force then mean nothing.
    """
    openings = {}
    for name, faces in grid.crack_faces.items():
        left = grid.edge_nodes(faces[:, 0])
        right = grid.edge_nodes(faces[:, 1])
        # The right face runs the other way: its ends change places.
        right[:, [0, 1]] = right[:, [1, 0]]
        along = grid.nodes[left[:, 1]] - grid.nodes[left[:, 0]]
        normal = np.column_stack([-along[:, 1], along[:, 0]]) / np.hypot(*along.T)[:, None]
        jump = displacement[left] - displacement[right]
        openings[name] = float(np.einsum("kni,ki->kn", jump, normal).min())
    return openings
