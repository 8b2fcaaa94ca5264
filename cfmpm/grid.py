"""The background grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Triangulation:
    """A plane triangulation in which cracks are still closed lines of edges.

    Attributes
    ----------
    nodes : (n, 2) float
        Coordinates [mm]; every node belongs to a triangle.
    triangles : (m, 3) int
        Corner nodes, anticlockwise.
    regions : (m,) int
        Index into `region_names`.
    region_names : tuple of str
        ``"body"`` first, then the scene's regions.
    edges : dict of str to (k, 2) int
        Node pairs of each named part of the boundary (outline and holes).
    cracks : dict of str to (k, 2) int
        Node pairs of each crack line, consecutive from its first point to its last.
    points : dict of str to int
        The node at each point load or point support, by the load's name.
    """

    nodes: Floats
    triangles: Ints
    regions: Ints
    region_names: tuple[str, ...]
    edges: dict[str, Ints]
    cracks: dict[str, Ints]
    points: dict[str, int]
