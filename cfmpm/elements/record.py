"""Triangular elements: order, material points, and the tables that follow from them.

Positions in a triangle are area (barycentric) coordinates, one column for each corner. The sides
are 01, 12 and 20.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from cfmpm.registry.elements import ELEMENTS
from cfmpm.registry.table import load

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Element:
    """A triangle with straight sides, Lagrange basis functions and material points.

    Attributes
    ----------
    order : int
        Degree p of the displacement; the strain has degree p - 1.
    points : (q, 3) float
        Area coordinates of the material points, all inside the triangle: a quadrature rule that is
        exact for degree 2 (p - 1), the degree of the strain energy.
    weights : (q,) float
        Area of each point, up to a common factor; positive.
    locks : bool
        Whether the element locks near incompressibility, so that the volume change is averaged
        over patches of triangles.
    domains : tuple of (v, 3) float, or None
        Polygon of material that each point represents: its corners, anticlockwise, each up to a
        factor. Crack growth needs the domains: integrals are taken over them where nodes have
        moved relative to the points.
    """

    order: int
    points: Floats
    weights: Floats
    locks: bool
    domains: tuple[Floats, ...] | None = None

    @property
    def constant_gradients(self) -> bool:
        """Whether the gradients of the basis functions are constant in a triangle."""
        return self.order == 1

    @property
    def moves_as_one_domain(self) -> bool:
        """Whether a deformed triangle is the domain of its only point: its sides stay straight."""
        return self.constant_gradients and len(self.points) == 1

    @cached_property
    def nodes(self) -> Ints:
        """Area coordinates of the nodes times the order, (k, 3).

        In the order: corners, inner nodes of each side from its first to its second end, nodes
        inside the triangle.
        """
        p = self.order
        corners = p * np.eye(3, dtype=np.int64)
        steps = [(p - j, j, 0) for j in range(1, p)]
        sides = [np.roll(step, k) for k in range(3) for step in steps]
        inside = [(i, j, p - i - j) for i in range(p - 2, 0, -1) for j in range(p - i - 1, 0, -1)]
        return np.array([*corners, *sides, *inside], np.int64)

    @cached_property
    def factors(self) -> Floats:
        """Coefficients of the factors of the basis functions, (p + 1, p + 1).

        The basis function of node (a, b, c) is P_a(L_0) P_b(L_1) P_c(L_2) with the area coordinates
        L and P_i(L) = prod_{j < i} (p L - j) / (j + 1) (Silvester 1969). Row i contains the
        coefficients of P_i in ascending powers.
        """
        p = self.order
        rows = [[Fraction(1)]]
        for i in range(p):
            # P_{i+1} = P_i (p L - i) / (i + 1).
            rows.append(_times_linear(rows[-1], Fraction(-i, i + 1), Fraction(p, i + 1)))
        return np.array([[float(c) for c in row] + [0.0] * (p + 1 - len(row)) for row in rows])

    @cached_property
    def sides(self) -> Ints:
        """Local numbers of the nodes of each side: both ends, then inner nodes, (3, p + 1)."""
        inner = 3 + np.arange(3 * (self.order - 1)).reshape(3, self.order - 1)
        return np.column_stack([np.arange(3), np.roll(np.arange(3), -1), inner])

    @cached_property
    def along(self) -> Ints:
        """Permutation of the nodes of a side to their order along it, (p + 1,)."""
        return np.array([0, *range(2, self.order + 1), 1])

    @cached_property
    def turned(self) -> Ints:
        """Permutation of the nodes of a side to their order in the adjacent triangle, (p + 1,)."""
        return np.array([1, 0, *range(self.order, 1, -1)])

    @cached_property
    def side_integrals(self) -> Floats:
        """Coefficients of the integrals of the basis functions along a side, (p + 1, p + 2).

        Row i contains, in ascending powers of s, the integral of the basis function of node i of
        the side from 0 to s, for a side of length one.
        """
        return np.array([[float(c) for c in row] for row in self._exact_side_integrals])

    @cached_property
    def side_weights(self) -> Floats:
        """Integrals of the basis functions along a whole side of length one, (p + 1,)."""
        return np.array([float(sum(row)) for row in self._exact_side_integrals])

    @cached_property
    def _exact_side_integrals(self) -> list[list[Fraction]]:
        p = self.order
        place = [Fraction(0), Fraction(1), *(Fraction(j, p) for j in range(1, p))]
        rows = []
        for i, own in enumerate(place):
            row = [Fraction(1)]
            for j, other in enumerate(place):
                if j != i:
                    row = _times_linear(row, -other / (own - other), 1 / (own - other))
            rows.append([Fraction(0), *(c / (k + 1) for k, c in enumerate(row))])
        return rows

    @cached_property
    def faces(self) -> Ints:
        """Subdivision of the element into linear triangles between its nodes, (p^2, 3).

        Triangles with the orientation of the element come first, from corner 0 on, then those
        turned by 180 degrees.
        """
        number = {tuple(node): i for i, node in enumerate(self.nodes.tolist())}
        upright, turned = (
            [(i, j, n - i - j) for i in range(n, -1, -1) for j in range(n - i, -1, -1)]
            for n in (self.order - 1, self.order - 2)
        )
        first = [((a + 1, b, c), (a, b + 1, c), (a, b, c + 1)) for a, b, c in upright]
        last = [((a + 1, b + 1, c), (a, b + 1, c + 1), (a + 1, b, c + 1)) for a, b, c in turned]
        return np.array([[number[node] for node in face] for face in first + last])

    @cached_property
    def face_weights(self) -> Floats:
        """Weights that extrapolate values from the points to the centre of each face, (p^2, q).

        The values are fitted by a polynomial of the degree of the strain, p - 1; by least squares
        if there are more points than coefficients.
        """
        middle = self.nodes[self.faces].mean(axis=1) / self.order
        degree = self.order - 1
        at_points, at_faces = (_monomials(x, degree) for x in (self.points, middle))
        weights = at_faces @ np.linalg.pinv(at_points)
        # Without round-off, a face whose centre is a material point has the value of this point.
        weights = np.round(weights, 14) + 0.0
        return np.asarray(weights / weights.sum(axis=1, keepdims=True))


@cache
def find_element(word: str) -> Element:
    """Return the element of a word of ``mesh.element``.

    Parameters
    ----------
    word : str

    Returns
    -------
    Element

    Raises
    ------
    KeyError
        If the word is not in `registry.elements.ELEMENTS`.
    """
    element: Element = load(ELEMENTS[word].place)
    return element


def _times_linear(row: list[Fraction], constant: Fraction, slope: Fraction) -> list[Fraction]:
    """Multiply a polynomial, given by coefficients in ascending powers, by constant + slope x."""
    shifted = [Fraction(0), *row]
    return [constant * c + slope * d for c, d in zip([*row, Fraction(0)], shifted, strict=True)]


def _monomials(place: Floats, degree: int) -> Floats:
    """Evaluate all monomials of a degree in area coordinates; they span all lower degrees too."""
    a, b, c = place.T
    return np.column_stack(
        [
            a**i * b**j * c ** (degree - i - j)
            for i in range(degree + 1)
            for j in range(degree + 1 - i)
        ]
    )
