"""Linear springs on a grid: supports in a fixed grid, and stabilisation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array

from cfmpm.body.grid import Floats, Grid, Ints


@dataclass(frozen=True)
class Springs:
    """Springs between nodes of a grid, and between nodes and points of prescribed displacement.

    Attributes
    ----------
    matrix : (2 n, 2 n) csr_array
        Stiffness of the springs [N/mm^2: N/mm per mm of thickness], symmetric; rows in the order
        of the displacement.
    force : (n, 2) float
        Resisting force at zero displacement [N/mm].
    pull : (n, 2) float
        Force per load factor [N/mm].
    """

    matrix: csr_array
    force: Floats
    pull: Floats

    def resistance(self, displacement: Floats) -> Floats:
        """Return the resisting force at a displacement, without `pull` [N/mm], (n, 2)."""
        return self.force + (self.matrix @ displacement.ravel()).reshape(-1, 2)

    def stiffness(self, displacement: Floats) -> csr_array:
        """Return the stiffness, which does not depend on the displacement."""
        return self.matrix


def supports(
    grid: Grid,
    element: Ints,
    position: Floats,
    axis: Ints,
    stiffness: float,
    displacement: Floats,
    target: Floats,
) -> Springs:
    """Springs that prescribe one displacement component at each of some points in a grid.

    Parameters
    ----------
    grid : Grid
    element : (k,) int
        The triangle with which each point moves.
    position : (k, 2) float
        [mm].
    axis : (k,) int
        The component.
    stiffness : float
        Stiffness of each spring [N/mm^2: N/mm per mm of thickness].
    displacement : (k,) float
        Displacement of each point so far [mm].
    target : (k,) float
        Prescribed displacement per load factor [mm].

    Returns
    -------
    Springs
    """
    shape = grid.basis_values(element, position)
    columns = 2 * grid.elements[element] + axis[:, None]
    rows = np.broadcast_to(np.arange(len(element))[:, None], columns.shape)
    n = 2 * len(grid.nodes)
    to_place = csr_array((shape.ravel(), (rows.ravel(), columns.ravel())), shape=(len(element), n))
    back = csr_array(stiffness * to_place.T)
    return Springs(
        csr_array(back @ to_place),
        (back @ displacement).reshape(-1, 2),
        (back @ target).reshape(-1, 2),
    )


def ghost(grid: Grid, fill: Floats, least: float, weight: float) -> Springs | None:
    """Ghost penalty on the jump of the gradient between triangles, one of them with small fill.

    Parameters
    ----------
    grid : Grid
        With three-node triangles.
    fill : (m,) float
        Filled fraction of each triangle.
    least : float
        Fraction below which a triangle is stabilised.
    weight : float
        Energy per squared jump of the gradient and squared side: gamma E [MPa].

    Returns
    -------
    Springs or None
        With the energy gamma E h^2 [grad du . n]^2 / 2 of each side of length h between two
        triangles with material (Burman 2010); None if there is no such side. Sides on crack faces
        have a triangle on one side only.
    """
    element, side = np.nonzero(grid.twins >= 0)
    other = grid.twins[element, side] // 3
    wanted = (element < other) & (np.minimum(fill[element], fill[other]) > 0.0)
    wanted &= np.minimum(fill[element], fill[other]) < least
    element, side, other = element[wanted], side[wanted], other[wanted]
    if element.size == 0:
        return None
    along = (
        grid.nodes[grid.triangles[element, (side + 1) % 3]]
        - grid.nodes[grid.triangles[element, side]]
    )
    h = np.hypot(*along.T)
    normal = np.column_stack([along[:, 1], -along[:, 0]]) / h[:, None]
    middle = grid.nodes[grid.triangles[element, side]] + 0.5 * along
    jump = np.hstack(
        [
            sign
            * np.einsum(
                "fkj,fj->fk",
                grid.basis_gradients(found, middle),
                normal,
            )
            for sign, found in ((1.0, element), (-1.0, other))
        ]
    )
    nodes = np.hstack([grid.triangles[element], grid.triangles[other]])
    blocks = weight * h[:, None, None] ** 2 * jump[:, :, None] * jump[:, None, :]
    n = 2 * len(grid.nodes)
    matrix = csr_array((n, n))
    for axis in (0, 1):
        dofs = 2 * nodes + axis
        rows = np.broadcast_to(dofs[:, :, None], blocks.shape).ravel()
        columns = np.broadcast_to(dofs[:, None, :], blocks.shape).ravel()
        matrix = matrix + csr_array(coo_array((blocks.ravel(), (rows, columns)), shape=(n, n)))
    nothing = np.zeros_like(grid.nodes)
    return Springs(csr_array(matrix), nothing, nothing)
