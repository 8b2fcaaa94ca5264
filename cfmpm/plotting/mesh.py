"""Figures of the background grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from cfmpm.body.grid import Floats, Grid, Ints
from cfmpm.output.fields import linear_faces
from cfmpm.plotting.style import BLACK, GREY, VERMILLION, length_axes


@dataclass(frozen=True)
class Mesh:
    """The parts of a grid that are drawn.

    Attributes
    ----------
    nodes : (n, 2) float
        [mm].
    faces : (f, 3) int
        Linear triangles.
    element : (f,) int
        Element of each face.
    """

    nodes: Floats
    faces: Ints
    element: Ints

    @classmethod
    def of_grid(cls, grid: Grid) -> Mesh:
        """The linear faces of a grid."""
        return cls(grid.nodes, *linear_faces(grid))

    @classmethod
    def of_fields(cls, fields: xr.Dataset) -> Mesh:
        """The faces of a dataset made by :func:`cfmpm.output.fields.build_fields`."""
        nodes = np.column_stack([fields["node_x"], fields["node_y"]])
        return cls(nodes, fields["face_nodes"].values.astype(np.int64), fields["element"].values)

    def edges(self) -> tuple[Ints, Ints]:
        """Node pairs between two elements, and on the boundary and crack faces; (k, 2) each."""
        pairs = self.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
        owner = np.repeat(self.element, 3)
        unique, first, inverse, count = np.unique(
            np.sort(pairs, axis=1),
            axis=0,
            return_index=True,
            return_inverse=True,
            return_counts=True,
        )
        inverse = inverse.ravel()
        inside = np.zeros(len(unique), bool)  # between two faces of one element
        inside[inverse] = owner != owner[first][inverse]
        return unique[inside & (count == 2)], unique[count == 1]


def draw_grid(axes: Axes, grid: Grid | Mesh, *, colour: str = GREY, width: float = 0.4) -> Axes:
    """Draw the element edges of a grid, its boundary and its cracks (paper Fig. 4).

    Parameters
    ----------
    axes : Axes
    grid : Grid or Mesh
    colour : str
        Colour of the edges between elements.
    width : float
        Line width of these edges [pt].

    Returns
    -------
    Axes
    """
    mesh = Mesh.of_grid(grid) if isinstance(grid, Grid) else grid
    inner, outer = mesh.edges()
    axes.add_collection(LineCollection(list(mesh.nodes[inner]), colors=colour, linewidths=width))
    axes.add_collection(
        LineCollection(list(mesh.nodes[outer]), colors=BLACK, linewidths=2.0 * width)
    )
    if isinstance(grid, Grid):
        draw_cracks(axes, grid)
    axes.autoscale_view()
    length_axes(axes)
    return axes


def draw_cracks(axes: Axes, grid: Grid) -> Axes:
    """Draw the crack lines of a grid, with a dot at each tip."""
    lines = [grid.nodes[grid.edge_nodes(faces[:, 0])[:, :2]] for faces in grid.crack_faces.values()]
    if lines:
        axes.add_collection(
            LineCollection(list(np.concatenate(lines)), colors=VERMILLION, linewidths=1.6, zorder=3)
        )
    tips = grid.nodes[[tip.node for tip in grid.tips]]
    axes.plot(*tips.T, "o", color=VERMILLION, markersize=3.5, zorder=3)
    return axes
