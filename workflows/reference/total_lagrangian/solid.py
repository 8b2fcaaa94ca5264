"""A meshed body by scikit-fem's basis and quadrature, its loads, and J."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from skfem import Basis, ElementTriP1, ElementTriP2, FacetBasis, LinearForm, MeshTri

from workflows.reference.total_lagrangian.laws import Floats, respond

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


@dataclass(frozen=True)
class Solid:
    """A meshed body of one material.

    Attributes
    ----------
    nodes : (n, 2) float
        [mm], doubled along cracks.
    elements : (m, 3) or (m, 6) int
        Corners anticlockwise, then the middles of the straight sides 01, 12, 20.
    law : str
    lame : tuple of float
        lambda and mu [MPa].
    gradients : (m, q, k, 2) float
        dN_a/dX_j at the quadrature points [1/mm].
    weights : (m, q) float
        Volume of the quadrature points per mm of thickness [mm^2].
    basis : skfem.Basis
    """

    nodes: Floats
    elements: Ints
    law: str
    lame: tuple[float, float]
    gradients: Floats
    weights: Floats
    basis: Basis

    def displacement_gradient(self, u: Floats) -> Floats:
        """Return du_i/dX_j at the quadrature points, (m, q, 2, 2)."""
        return np.einsum("mai,mqaj->mqij", u[self.elements], self.gradients)


def make_solid(
    nodes: Floats, elements: Ints, law: str, E: float, nu: float, order: int | None = None
) -> Solid:
    """Put a solid together.

    Parameters
    ----------
    nodes, elements
        As in `Solid`.
    law : {"hencky", "neo_hookean", "ciarlet"}
    E, nu : float
        Young's modulus [MPa] and Poisson's ratio.
    order : int, optional
        Polynomial degree that scikit-fem's rule integrates exactly; without it one point (T3) and
        the three points (2/3, 1/6, 1/6) (T6).

    Raises
    ------
    ValueError
        If a side of a T6 is not straight with its node in the middle.
    """
    k = elements.shape[1]
    corners = elements[:, :3]
    if k == 6:
        middles = 0.5 * (nodes[corners] + nodes[np.roll(corners, -1, axis=1)])
        if np.abs(middles - nodes[elements[:, 3:]]).max() > 1e-9 * np.ptp(nodes):
            raise ValueError("sides of T6 must be straight, with a node in the middle")
    mesh = MeshTri(
        np.ascontiguousarray(nodes[: corners.max() + 1].T),
        np.ascontiguousarray(corners.T),
        sort_t=False,
    )
    if order is None:
        at = np.full((2, 1), 1.0 / 3.0) if k == 3 else np.array([[1, 4, 1], [1, 1, 4]]) / 6.0
        rule = {"quadrature": (at, np.full(at.shape[1], 0.5 / at.shape[1]))}
    else:
        rule = {"intorder": order}
    basis = Basis(mesh, ElementTriP1() if k == 3 else ElementTriP2(), **rule)
    gradients = np.stack([np.asarray(basis.basis[a][0].grad) for a in range(k)])
    lame = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))
    return Solid(
        nodes,
        elements,
        law,
        lame,
        np.ascontiguousarray(gradients.transpose(2, 3, 0, 1)),
        np.asarray(basis.dx),
        basis,
    )


@dataclass(frozen=True)
class Loads:
    """Loads at factor one: dead forces and prescribed displacements.

    Attributes
    ----------
    prescribed : (n, 2) bool
    displacement : (n, 2) float
        [mm].
    force : (n, 2) float
        [N/mm].
    """

    prescribed: Bools
    displacement: Floats
    force: Floats


def no_loads(solid: Solid) -> Loads:
    """Return loads of nothing, to be filled in."""
    n = len(solid.nodes)
    return Loads(np.zeros((n, 2), bool), np.zeros((n, 2)), np.zeros((n, 2)))


def hold(loads: Loads, nodes: Ints | int, axis: int, value: float = 0.0) -> Loads:
    """Return the loads with one component prescribed at nodes."""
    prescribed, displacement = loads.prescribed.copy(), loads.displacement.copy()
    prescribed[nodes, axis] = True
    displacement[nodes, axis] = value
    return replace(loads, prescribed=prescribed, displacement=displacement)


def traction_force(
    solid: Solid, where: Callable[[Floats], Bools], traction: tuple[float, float]
) -> Floats:
    """Return the nodal forces (n, 2) [N/mm] of a dead traction on a part of the boundary.

    Parameters
    ----------
    solid : Solid
    where : callable
        From coordinates (2, facets) [mm] of the middles of facets to those that are loaded.
    traction : tuple of float
        Force per reference area [MPa].
    """
    mesh = solid.basis.mesh
    facets = mesh.facets_satisfying(where, boundaries_only=True)
    unit = LinearForm(lambda v, w: v).assemble(FacetBasis(mesh, solid.basis.elem, facets=facets))
    share = np.zeros(len(solid.nodes))
    share[solid.elements] = unit[solid.basis.element_dofs.T]
    return share[:, None] * np.array(traction)


def ring_plateau(nodes: Floats, tip: Floats, radius: float) -> Floats:
    """Return q at nodes (n,): 1 to half the radius of the reference distance, 0 from it on."""
    return np.clip(2.0 - 2.0 * np.hypot(*(nodes - tip).T) / radius, 0.0, 1.0)


def j_integral(solid: Solid, u: Floats, q: Floats) -> float:
    """Return the energy release rate for a crack along x [N/mm].

    Parameters
    ----------
    solid : Solid
    u : (n, 2) float
        Displacement [mm].
    q : (n,) float
        Weight; that of corners counts, between which it is linear.

    Returns
    -------
    float
        J = - int (W 1 - F^T P)_1j q,j dV in the reference configuration (Eshelby 1975; Li, Shih
        and Needleman 1985).
    """
    H = solid.displacement_gradient(u)
    response = respond(solid.law, solid.lame, H)
    corners = solid.nodes[solid.elements[:, :3]]
    sides = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=1)
    rise = q[solid.elements[:, 1:3]] - q[solid.elements[:, :1]]
    dq = np.linalg.solve(sides, rise[..., None])[..., 0]
    momentum = -np.einsum("mqi,mqij->mqj", np.eye(2)[0] + H[..., 0], response.stress)
    momentum[..., 0] += response.energy
    return -float(np.einsum("mq,mqj,mj->", solid.weights, momentum, dq))
