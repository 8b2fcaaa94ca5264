"""What a triangular element is: its order, its material points, and all that follows from them.

Places in a triangle are barycentric coordinates, one column a corner. Sides are 01, 12 and 20.
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
        Degree p of the displacement; strain is of degree p - 1.
    points : (q, 3) float
        Places of the material points, all inside: a rule that is exact for degree 2 (p - 1), the
        degree of the strain energy.
    weights : (q,) float
        Parts of the area that the points stand for, in any one unit; positive.
    locks : bool
        Whether it is too stiff near incompressibility, so that patches of triangles share their
        change of volume.
    domains : tuple of (v, 3) float, or None
        The polygon of material that each point stands for, corners anticlockwise, each in any one
        unit. A crack that grows needs them: they are what is integrated over when the grid is moved
        under the points.
    """

    order: int
    points: Floats
    weights: Floats
    locks: bool
    domains: tuple[Floats, ...] | None = None

    @property
    def constant_gradients(self) -> bool:
        """Whether basis gradients are constant in a triangle."""
        return self.order == 1

    @property
    def moves_as_one_domain(self) -> bool:
        """Whether a triangle stays the one domain of its one point, with straight sides, as its
        nodes move."""
        return self.constant_gradients and len(self.points) == 1

    @cached_property
    def nodes(self) -> Ints:
        """Places of the nodes times the order, (k, 3).

        The corners, the nodes inside each side from its first end to its second, and those inside
        the triangle.
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

        The basis function of the node (a, b, c) is P_a(L_0) P_b(L_1) P_c(L_2) of the area
        coordinates L, with P_i(L) = prod_{j < i} (p L - j) / (j + 1) (Silvester 1969). Row i has
        the coefficients of P_i by ascending power.
        """
        p = self.order
        rows = [[Fraction(1)]]
        for i in range(p):
            # Times (p L - i) / (i + 1).
            rows.append(_times_linear(rows[-1], Fraction(-i, i + 1), Fraction(p, i + 1)))
        return np.array([[float(c) for c in row] + [0.0] * (p + 1 - len(row)) for row in rows])

    @cached_property
    def sides(self) -> Ints:
        """Numbers of the nodes of each side: both ends, then those between them, (3, p + 1)."""
        inner = 3 + np.arange(3 * (self.order - 1)).reshape(3, self.order - 1)
        return np.column_stack([np.arange(3), np.roll(np.arange(3), -1), inner])

    @cached_property
    def along(self) -> Ints:
        """Order in which the nodes of a side follow each other from end to end, (p + 1,)."""
        return np.array([0, *range(2, self.order + 1), 1])

    @cached_property
    def turned(self) -> Ints:
        """Order in which the triangle across a side has the nodes of it, (p + 1,)."""
        return np.array([1, 0, *range(self.order, 1, -1)])

    @cached_property
    def side_integrals(self) -> Floats:
        """Coefficients of the integrals of the basis functions along a side, (p + 1, p + 2).

        Row i has, by ascending power of s, the integral from the first end of a side of length one
        to s of the basis function of its node i.
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
        """Linear triangles between neighbouring nodes that fill the element, (p^2, 3).

        Those that stand as the element does come first, from corner 0 on.
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
        """Parts of the values at the material points in that at the middle of each face, (p^2, q).

        By the polynomial of the degree of the strain through, or nearest to, the points.
        """
        middle = self.nodes[self.faces].mean(axis=1) / self.order
        degree = self.order - 1
        at_points, at_faces = (_monomials(x, degree) for x in (self.points, middle))
        weights = at_faces @ np.linalg.pinv(at_points)
        # A face whose middle is a point has the value of that and of no other.
        weights = np.round(weights, 14) + 0.0
        return np.asarray(weights / weights.sum(axis=1, keepdims=True))


@cache
def find_element(word: str) -> Element:
    """Return the element that a word of ``mesh.element`` stands for."""
    element: Element = load(ELEMENTS[word].place)
    return element


def _times_linear(row: list[Fraction], constant: Fraction, slope: Fraction) -> list[Fraction]:
    """Multiply a polynomial, coefficients by ascending power, by a linear one."""
    shifted = [Fraction(0), *row]
    return [constant * c + slope * d for c, d in zip([*row, Fraction(0)], shifted, strict=True)]


def _monomials(place: Floats, degree: int) -> Floats:
    """All monomials of the degree in barycentric coordinates, which span the lower ones too."""
    a, b, c = place.T
    return np.column_stack(
        [
            a**i * b**j * c ** (degree - i - j)
            for i in range(degree + 1)
            for j in range(degree + 1 - i)
        ]
    )
