"""How far a body has come from its reference configuration on a grid that is reset."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.grid import Floats, Grid, Ints
from cfmpm.body.loads import Loading
from cfmpm.body.springs import Springs


@dataclass(frozen=True)
class Reset:
    """How a grid is reset after a load step.

    Attributes
    ----------
    fixed : bool
        Back to where it was; else it follows the material.
    by_domains : bool
        Whether the parts of particle domains are summed over; else the points where they are.
    smooth_below : float
        Quality of a triangle of a following grid below which it is smoothed.
    ghost : float
        Stabilisation of triangles that hold little material, over their largest modulus.
    """

    fixed: bool
    by_domains: bool
    smooth_below: float
    ghost: float


@dataclass(frozen=True)
class Motion:
    """What an updated Lagrangian body keeps of its reference configuration, and how it moved.

    The nodes of the grid that the points were seeded in go on as tracers: they move with the
    material, carry the loads, and are the corners of the particle domains.

    Attributes
    ----------
    reset : Reset
    reference : Grid
        In which the points were seeded.
    loading : Loading
        On its nodes.
    position : (p, 2) float
        Of the material points in the reference configuration [mm].
    element : (p,) int
        Their triangles there.
    gradients : (p, k, 2) float
        Basis gradients there [1/mm].
    displacement : (n, 2) float
        Of the tracers when the grid was reset last [mm].
    triangle : (n,) int
        Of the present grid, in which each tracer lies.
    carrier : (n,) int
        With which it moves: the nearest one that holds material.
    base : (q, 2, 2) float
        Displacement gradient of the quadrature points when the grid was reset last.
    smoothed : (m,) bool
        Nodes of a following grid that are not with their tracer any more.
    forces : tuple of Springs
        On the present grid: supports in which it moves, and its stabilisation.
    resets : int
        How often the grid was moved under the points.
    fill : float
        Least part of a triangle that material fills, of those that hold any.
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
        """Where the tracers were when the grid was reset last [mm], (n, 2)."""
        return self.reference.nodes + self.displacement

    def traced(self, grid: Grid, displacement: Floats) -> Floats:
        """Return the displacement of the tracers from the reference [mm], (n, 2).

        Parameters
        ----------
        grid : Grid
            The present one.
        displacement : (m, 2) float
            Of its nodes since the reset [mm].
        """
        return self.displacement + interpolate(grid, displacement, self.carrier, self.tracers)


def interpolate(grid: Grid, values: Floats, element: Ints, position: Floats) -> Floats:
    """Evaluate a nodal field, (n, d), at places in or near given triangles, (k, d)."""
    shape = grid.basis_values(element, position)
    return np.einsum("pk,pki->pi", shape, values[grid.elements[element]])


def nearest_filled(grid: Grid, filled: NDArray[np.bool_]) -> Ints:
    """Find for each triangle the one with material that is the fewest sides away.

    Parameters
    ----------
    grid : Grid
    filled : (m,) bool
        Which triangles hold material.

    Returns
    -------
    (m,) int
        Itself where it is filled; never across a crack; -1 where no way leads to material.
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
