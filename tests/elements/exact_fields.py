"""Plane elastic fields in equilibrium without body force, and the error of an element for them."""

from __future__ import annotations

import numpy as np
import round_off
from posed import driven, elastic, pose
from scipy.sparse import csc_array, csr_array
from structured import rectangle

from cfmpm.body.grid import Grid, build_grid
from cfmpm.elements.record import Element
from cfmpm.equilibrium import small_strain

LAM, MU = 1.3, 0.9


class Field:
    """2 mu (u + i v) = kappa phi - z conj(phi') - conj(psi) (Kolosov; Muskhelishvili 1953).

    `derivative(k, z)` is the k-th derivative of a function f; phi = (1 + i / 2) f, psi = -f.
    """

    def __init__(self, derivative):
        self.derivative = derivative

    def potentials(self, x):
        z = x[..., 0] + 1j * x[..., 1]
        phi = [(1.0 + 0.5j) * self.derivative(k, z) for k in range(3)]
        psi = [-self.derivative(k, z) for k in range(2)]
        return z, phi, psi, (LAM + 3 * MU) / (LAM + MU), 0.5 / MU

    def displacement(self, x):
        z, phi, psi, kappa, scale = self.potentials(x)
        u = scale * (kappa * phi[0] - z * np.conj(phi[1]) - np.conj(psi[0]))
        return np.stack([u.real, u.imag], axis=-1)

    def gradient(self, x):
        z, phi, psi, kappa, scale = self.potentials(x)
        along, around = kappa * phi[1] - np.conj(phi[1]), z * np.conj(phi[2]) + np.conj(psi[1])
        by_x, by_y = scale * (along - around), scale * 1j * (along + around)
        return np.stack(
            [np.stack([by_x.real, by_y.real], -1), np.stack([by_x.imag, by_y.imag], -1)], -2
        )


def polynomial(degree: int) -> Field:
    def derivative(k, z):
        if k > degree:
            return 0.0 * z
        return np.prod(np.arange(degree, degree - k, -1.0)) * z ** (degree - k)

    return Field(derivative)


SMOOTH = Field(lambda k, z: np.exp(z))


def solve(
    element: Element | str, n: int, field: Field
) -> tuple[Grid, np.ndarray, csr_array | csc_array]:
    """Prescribe a field on the outer boundary of a plate of n by n cells, and solve.

    Returns
    -------
    grid : Grid
    displacement : (n, 2) float
    stiffness : sparse array
    """
    grid = build_grid(rectangle(n, n, shake=0.3, seed=n), element)
    boundary = np.unique(np.concatenate([e.ravel() for e in grid.edges.values()]))
    problem = pose(
        grid, driven(grid, boundary, field.displacement(grid.nodes[boundary])), elastic(LAM, MU)
    )
    stiffness = small_strain.assemble_stiffness(problem)
    balance = small_strain.solve_linear(problem, stiffness)
    return grid, balance.displacement, stiffness


def gradient_error(element: Element | str, n: int, field: Field = SMOOTH) -> float:
    """Relative root mean square error of the displacement gradient."""
    return gradient_and_round_off(element, n, field)[0]


def gradient_and_round_off(element: Element | str, n: int, field: Field) -> tuple[float, float]:
    """Return that error and a bound on its round-off."""
    grid, displacement, stiffness = solve(element, n, field)
    # Places that are no points of any rule: nothing converges faster there.
    inside = np.array([[i, j, 12 - i - j] for i in range(1, 11) for j in range(1, 12 - i)]) / 12
    places = np.einsum("qc,ecd->eqd", inside, grid.nodes[grid.triangles]).reshape(-1, 2)
    of = np.repeat(np.arange(len(grid.elements)), len(inside))
    slopes = grid.basis_gradients(of, places)
    found = np.einsum("pkj,pki->pij", slopes, displacement[grid.elements[of]])
    exact = field.gradient(places)
    share = grid.areas[of][:, None, None]
    size = np.sqrt((share * exact**2).sum())
    error = np.sqrt((share * (found - exact) ** 2).sum()) / size
    steepest = np.abs(slopes).sum(axis=1).max() * np.sqrt(grid.areas.sum())
    return float(error), float(round_off.of_solution(stiffness, displacement) * steepest / size)


def rate(element: Element | str, n: int = 6) -> float:
    """Return the convergence rate of the strain error; the energy converges at twice this rate."""
    return float(np.log2(gradient_error(element, n) / gradient_error(element, 2 * n)))
