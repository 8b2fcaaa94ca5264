"""Patches of triangles with a common mean volume change, for nearly incompressible materials.

T3 with one point per triangle has as many constraints as degrees of freedom and locks; with pairs
of triangles it has half as many (de Souza Neto, Pires and Owen 2005). T6 averages over the points
of each triangle, which is the stable P2-P0 element (Boffi, Brezzi and Fortin 2013, section 8.4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cfmpm.body.grid import Grid, Ints
from cfmpm.body.points import MaterialPoints
from cfmpm.kernels import patches as kernels


@dataclass(frozen=True)
class Patches:
    """Patches of the triangles of a grid; each triangle is in one patch.

    Attributes
    ----------
    of_triangle : (m,) int
        Patch of each triangle; that of a point is the patch of its triangle.
    nodes : (n_patches, w) int
        Nodes of each patch, with the last one repeated if there are fewer than w. These are the
        elements of the sparsity pattern of the stiffness.
    """

    of_triangle: Ints
    nodes: Ints


def build_patches(grid: Grid) -> Patches:
    """Join triangles in pairs if single ones lock; else each triangle is a patch.

    Parameters
    ----------
    grid : Grid

    Returns
    -------
    Patches
        Never across a crack or an interface of regions.
    """
    if not grid.element.locks:
        return Patches(np.arange(len(grid.elements)), grid.elements)
    of_triangle = kernels.pair_triangles(
        grid.nodes, np.ascontiguousarray(grid.triangles), grid.twins, grid.regions
    )
    n_nodes = len(grid.nodes)
    patch, node = np.divmod(np.unique(of_triangle[:, None] * n_nodes + grid.elements), n_nodes)
    start = np.searchsorted(patch, np.arange(of_triangle.max() + 2))
    count = np.diff(start)
    column = np.minimum(np.arange(count.max()), count[:, None] - 1)
    return Patches(of_triangle, node[start[:-1, None] + column])


def patch_of(patches: Patches | None, points: MaterialPoints) -> Ints:
    """Return the patch of each point, (p,); empty without patches."""
    return np.empty(0, np.int64) if patches is None else patches.of_triangle[points.element]
