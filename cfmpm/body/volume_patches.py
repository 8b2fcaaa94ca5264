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


def build_patches(grid: Grid, paired: Ints | None = None) -> Patches:
    """Join triangles in pairs if single ones lock; else each triangle is a patch.

    Parameters
    ----------
    grid : Grid
    paired : (m,) int, optional
        Patch of each triangle, from `paired_triangles`, by default without a grid before.

    Returns
    -------
    Patches
        Never across a crack or an interface of regions.
    """
    if not grid.element.locks:
        return Patches(np.arange(len(grid.elements)), grid.elements)
    of_triangle = paired_triangles(grid) if paired is None else paired
    n_nodes = len(grid.nodes)
    patch, node = np.divmod(np.unique(of_triangle[:, None] * n_nodes + grid.elements), n_nodes)
    start = np.searchsorted(patch, np.arange(of_triangle.max() + 2))
    count = np.diff(start)
    column = np.minimum(np.arange(count.max()), count[:, None] - 1)
    return Patches(of_triangle, node[start[:-1, None] + column])


def paired_triangles(grid: Grid, before: Ints | None = None) -> Ints:
    """Join triangles in pairs, and what is left over with a pair.

    Parameters
    ----------
    grid : Grid
    before : (k,) int, optional
        Patches of the first triangles of the grid, as before a crack has grown. What of a patch is
        still connected stays together: else a cut would pair triangles anew all over the body,
        which changes the strain energy by up to a per cent on a coarse grid.

    Returns
    -------
    (m,) int
        Patch of each triangle, numbered by their first triangles.
    """
    patch = np.full(len(grid.triangles), -1)
    if before is not None:
        patch[: len(before)] = _connected(grid, before)
    kernels.pair_triangles(
        grid.nodes, np.ascontiguousarray(grid.triangles), grid.twins, grid.regions, patch
    )
    _, first = np.unique(patch, return_index=True)
    return np.argsort(np.argsort(first))[patch]


def _connected(grid: Grid, before: Ints) -> Ints:
    """Patches of which two or more triangles are connected, numbered anew; -1 elsewhere, (k,)."""
    k = len(before)
    joined = (grid.twins[:k] >= 0) & (grid.twins[:k] < 3 * k)
    other = np.where(joined, grid.twins[:k] // 3, 0)
    joined &= (before[other] == before[:, None]) & (grid.regions[other] == grid.regions[:k, None])
    least, moving = np.arange(k), True
    while moving:
        across = np.where(joined, least[other], k).min(axis=1)
        moving = bool((across < least).any())
        least = np.minimum(least, across)
    patch = np.full(k, -1)
    kept = np.bincount(least, minlength=k)[least] > 1
    patch[kept] = np.unique(least[kept], return_inverse=True)[1]
    return patch


def patch_of(patches: Patches | None, points: MaterialPoints) -> Ints:
    """Return the patch of each point, (p,); empty without patches."""
    return np.empty(0, np.int64) if patches is None else patches.of_triangle[points.element]
