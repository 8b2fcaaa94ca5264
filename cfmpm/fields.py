"""The last state of a run as one UGRID file."""

from __future__ import annotations

import numpy as np

from cfmpm.grid import Grid, Ints

# Linear faces of a six-node triangle: the three corners, then the middle.
_PARTS = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])


def linear_faces(grid: Grid) -> tuple[Ints, Ints]:
    """Return linear triangles that use every node of a grid, and the element of each.

    Parameters
    ----------
    grid : Grid

    Returns
    -------
    faces : (f, 3) int
        T3: the elements. T6: four for each element, the corners 0, 1, 2 and then the middle.
    element : (f,) int
    """
    elements = grid.elements
    parts = _PARTS if elements.shape[1] == 6 else np.array([[0, 1, 2]])
    faces = elements[:, parts].reshape(-1, 3)
    return faces, np.repeat(np.arange(len(elements)), len(parts))
