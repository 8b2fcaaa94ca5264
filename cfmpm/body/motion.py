"""Motion of a body from its reference configuration, on a grid that is reset."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.grid import Floats, Grid, Ints
from cfmpm.body.loads import Loading
from cfmpm.body.springs import Springs


@dataclass(frozen=True)
class Reset:
    """Settings of the reset of a grid after a load step.

    Attributes
    ----------
    fixed : bool
        Whether the grid returns to its initial position; else it follows the material.
    by_domains : bool
        Whether to integrate over particle domains; else over the material points.
    smooth_below : float
        Quality of a triangle of a following grid below which it is smoothed.
    ghost : float
        Stabilisation of triangles with little material, over the largest Young's modulus.
    """

    fixed: bool
    by_domains: bool
    smooth_below: float
    ghost: float


@dataclass(frozen=True)
class Motion:
    """Reference configuration and motion of an updated Lagrangian body.

    The nodes of the initial grid are kept as tracers: they move with the material, carry the
    loads, and are the corners of the particle domains.

    Attributes
    ----------
    reset : Reset
    reference : Grid
        The initial grid.
    loading : Loading
        Loads on its nodes.
    position : (p, 2) float
        Positions of the material points in the reference configuration [mm].
    element : (p,) int
        Triangles of the points in the initial grid.
    gradients : (p, k, 2) float
        Basis gradients at the points in the initial grid [1/mm].
    displacement : (n, 2) float
        Displacement of the tracers at the last reset [mm].
    triangle : (n,) int
        Triangle of the current grid that contains each tracer.
    carrier : (n,) int
        Triangle with which each tracer moves: the nearest one with material.
    base : (q, 2, 2) float
        Displacement gradient of the quadrature points at the last reset.
    smoothed : (m,) bool
        Nodes of a following grid that no longer coincide with their tracers.
    forces : tuple of Springs
        On the current grid: springs of supports, and stabilisation.
    resets : int
        Number of times the grid was moved relative to the points.
    fill : float
        Smallest filled fraction of a triangle, of those with material on all sides.
    """

    reset: Reset
    reference: Grid
    loading: Loading
    position: Floats
    element: Ints
    gradients: Floats
    displacement: Floats
    triangle: Ints
    carrier: Ints
    base: Floats
    smoothed: NDArray[np.bool_]
    forces: tuple[Springs, ...]
    resets: int
    fill: float

    @property
    def tracers(self) -> Floats:
        """Positions of the tracers at the last reset [mm], (n, 2)."""
        return self.reference.nodes + self.displacement

    def traced(self, grid: Grid, displacement: Floats) -> Floats:
        """Return the displacement of the tracers from the reference [mm], (n, 2).

        Parameters
        ----------
        grid : Grid
            The current grid.
        displacement : (m, 2) float
            Displacement of its nodes since the reset [mm].
        """
        return self.displacement + interpolate(grid, displacement, self.carrier, self.tracers)


def interpolate(grid: Grid, values: Floats, element: Ints, position: Floats) -> Floats:
    """Evaluate a nodal field, (n, d), at positions in or near given triangles, (k, d)."""
    shape = grid.basis_values(element, position)
    return np.einsum("pk,pki->pi", shape, values[grid.elements[element]])


def nearest_filled(grid: Grid, filled: NDArray[np.bool_]) -> Ints:
    """Find for each triangle the nearest one with material, by the number of sides between them.

    Parameters
    ----------
    grid : Grid
    filled : (m,) bool
        Whether a triangle contains material.

    Returns
    -------
    (m,) int
        The triangle itself if it is filled; never across a crack; -1 if none can be reached.
    """
    found = np.where(filled, np.arange(len(filled)), -1)
    while True:
        empty = np.flatnonzero(found < 0)
        across = grid.twins[empty]
        beyond = np.where(across >= 0, found[across // 3], -1)
        reached = beyond.max(axis=1, initial=-1)
        if (reached < 0).all():
            return found
        found[empty] = reached
