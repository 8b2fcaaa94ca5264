"""The material points: arrays, initial positions, location in the grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cfmpm.body.grid import Floats, Grid, Ints
from cfmpm.errors import SolveError
from cfmpm.kernels import location

# Cause and remedy for points outside the grid.
MOVED_OFF = "growth has moved the grid away from them; refine it there"


@dataclass(frozen=True)
class MaterialPoints:
    """Material points as a structure of arrays, one row for each point.

    Attributes
    ----------
    position : (p, 2) float
        [mm].
    volume : (p,) float
        Volume per mm of thickness [mm^2].
    element : (p,) int
        Triangle that contains the point.
    material : (p,) int
        Row of the material table.
    """

    position: Floats
    volume: Floats
    element: Ints
    material: Ints

    def __len__(self) -> int:
        return len(self.volume)

    def deformed(
        self,
        displacement_gradient: Floats,
        stress: Floats,
        energy: Floats,
        internal_variables: Floats | None = None,
    ) -> DeformedPoints:
        """Return these points with a state, as in `DeformedPoints`; the arrays are shared."""
        if internal_variables is None:
            internal_variables = np.zeros((len(self), 0))
        return DeformedPoints(
            position=self.position,
            volume=self.volume,
            element=self.element,
            material=self.material,
            displacement_gradient=displacement_gradient,
            stress=stress,
            energy=energy,
            internal_variables=internal_variables,
        )

    def at_rest(self, n_internal: int = 0) -> DeformedPoints:
        """Return these points undeformed, with `n_internal` internal variables of value zero."""
        n = len(self)
        return self.deformed(
            np.zeros((n, 2, 2)), np.zeros((n, 3)), np.zeros(n), np.zeros((n, n_internal))
        )


@dataclass(frozen=True)
class DeformedPoints(MaterialPoints):
    """Material points with their state at a displacement of the grid.

    Attributes
    ----------
    displacement_gradient : (p, 2, 2) float
    stress : (p, 3) float
        sigma_xx, sigma_yy, sigma_xy [MPa].
    energy : (p,) float
        Strain energy density [N mm/mm^3].
    internal_variables : (p, h) float
        Internal variables of plastic materials at finite deformation; else h = 0.
    """

    displacement_gradient: Floats
    stress: Floats
    energy: Floats
    internal_variables: Floats


def seed(grid: Grid) -> MaterialPoints:
    """Create the material points of a grid.

    Parameters
    ----------
    grid : Grid

    Returns
    -------
    MaterialPoints
        At the points of the element's quadrature rule. The volumes of the points of a triangle add
        up to its area.
    """
    element = grid.element
    corners = grid.nodes[grid.triangles]
    per_element = len(element.points)
    n = per_element * len(corners)
    return MaterialPoints(
        position=np.einsum("qk,ekd->eqd", element.points, corners).reshape(n, 2),
        volume=(grid.areas[:, None] * element.weights / element.weights.sum()).ravel(),
        element=np.repeat(np.arange(len(corners)), per_element),
        material=np.repeat(grid.regions, per_element),
    )


def locate(grid: Grid, position: Floats, hints: Ints | None = None) -> Ints:
    """Find the triangle that contains each point.

    Parameters
    ----------
    grid : Grid
    position : (p, 2) float
        [mm].
    hints : (p,) int, optional
        A triangle near each point, from which a walk over neighbours starts. The walk never
        crosses a crack; a point on a crack stays on the side of its hint.

    Returns
    -------
    (p,) int
        The triangle; `location.OUTSIDE` (-1) for points outside the body.

    Notes
    -----
    It replaces the paper's search over all triangles (section 2.3; step 2 of section 4.2),
    whose rule is wrong behind corners (docs/theory.md, misprints).
    """
    position = np.ascontiguousarray(position, float)
    triangles = np.ascontiguousarray(grid.triangles)
    if hints is None:
        found = np.full(len(position), location.OUTSIDE)
        hints = found
    else:
        found = location.walk_from_hints(grid.nodes, triangles, grid.twins, hints, position)
    lost = np.flatnonzero(found == location.OUTSIDE)
    if lost.size == 0:
        return found
    origin, highest = grid.extent
    extent = highest - origin
    cell = np.sqrt(extent.prod() / len(triangles))
    shape = np.maximum(1, (extent / cell).astype(np.int64))
    size = extent / shape
    offsets, items = location.fill_buckets(grid.nodes, triangles, origin, size, shape)
    found[lost] = location.search_buckets(
        grid.nodes,
        triangles,
        grid.twins,
        origin,
        size,
        shape,
        offsets,
        items,
        hints[lost],
        position[lost],
    )
    return found


def relocate(grid: Grid, points: MaterialPoints, reason: str = MOVED_OFF) -> Ints:
    """Find the triangle that contains each material point, starting from the previous one.

    Parameters
    ----------
    grid : Grid
    points : MaterialPoints
    reason : str
        Cause and remedy for points outside the grid, for the error message.

    Returns
    -------
    (p,) int

    Raises
    ------
    SolveError
        If points lie outside the grid; kernels would take -1 as its last triangle.
    """
    found = locate(grid, points.position, points.element)
    lost = np.flatnonzero(found == location.OUTSIDE)
    if lost.size:
        x, y = points.position[lost[0]]
        raise SolveError(
            f"{lost.size} of {len(points)} material points have left the grid, the first at "
            f"({x:.6g}, {y:.6g}) mm: {reason}"
        )
    return found
