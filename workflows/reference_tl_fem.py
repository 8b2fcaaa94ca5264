"""An independent reference at large strain: total Lagrangian FEM in plane strain, by scikit-fem.

Nothing of cfmpm's kernels is used: basis and quadrature are scikit-fem's, the laws are written in
the principal stretches of the right Cauchy-Green tensor (cfmpm's in closed form in the left), and
assembly, Newton's method, reactions and J are written here. Only a mesh is given, as arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import SuperLU, splu
from skfem import Basis, ElementTriP1, ElementTriP2, FacetBasis, LinearForm, MeshTri

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

TOLERANCE = 1e-11
ITERATIONS = 25
# Growth of the largest stretch from one accepted state to the next: a solution that jumps past a
# loss of stability has positive pivots only, as before, and shows by its stretch alone.
JUMP = 1.1
SERIES_BELOW = 1e-2


class NotConvergedError(Exception):
    """Newton's method has found no equilibrium."""


class StabilityLostError(Exception):
    """The path of stable equilibria has ended.

    Attributes
    ----------
    last : Equilibrium
        The last stable one.
    factor : float
        The next load factor tried, at which there was none.
    unstable : Equilibrium or None
        The one there, if it has negative pivots; None where Newton's method failed or the
        solution jumped.
    """

    def __init__(self, last: Equilibrium, factor: float, unstable: Equilibrium | None) -> None:
        self.last = last
        self.factor = factor
        self.unstable = unstable
        seen = "no equilibrium near by"
        if unstable is not None:
            seen = f"{unstable.negative_pivots} negative pivots"
        super().__init__(f"stable up to {last.factor:.6g}; at {factor:.6g} {seen}")


@dataclass(frozen=True)
class Law:
    """An isotropic energy w = 2 mu sum_a Gamma(c_a) + U(ln J) of the squared stretches c_a.

    Attributes
    ----------
    shear : callable
        From c - 1 to Gamma, gamma = dGamma/de and dgamma/de, with e = ln(c) / 2.
    shear_slope : callable
        From c_1 - 1 and c_2 - 1 to (gamma_1 - gamma_2) / (c_1 - c_2).
    volume : callable
        From ln J to U, U', U'' for lambda = 1.
    """

    shear: Callable[[Floats], tuple[Floats, Floats, Floats]]
    shear_slope: Callable[[Floats, Floats], Floats]
    volume: Callable[[Floats], tuple[Floats, Floats, Floats]]


def _log_shear(x: Floats) -> tuple[Floats, Floats, Floats]:
    e = 0.5 * np.log1p(x)
    return 0.5 * e * e, e, np.ones_like(e)


def _log_slope(x: Floats, y: Floats) -> Floats:
    """Half of (ln c_1 - ln c_2) / (c_1 - c_2), as artanh(z) / z / (c_1 + c_2)."""
    total = 2.0 + x + y
    z = (x - y) / total
    near = np.abs(z) < SERIES_BELOW
    series = 1.0 + z**2 / 3.0 + z**4 / 5.0 + z**6 / 7.0 + z**8 / 9.0
    far = np.where(near, 0.5, z)
    return np.where(near, series, np.arctanh(far) / far) / total


def _linear_shear(x: Floats) -> tuple[Floats, Floats, Floats]:
    return 0.25 * (x - np.log1p(x)), 0.5 * x, 1.0 + x


def _linear_slope(x: Floats, y: Floats) -> Floats:
    return np.full_like(x, 0.5)


def _log_volume(theta: Floats) -> tuple[Floats, Floats, Floats]:
    return 0.5 * theta**2, theta, np.ones_like(theta)


def _square_volume(theta: Floats) -> tuple[Floats, Floats, Floats]:
    growth = np.expm1(2.0 * theta)
    return 0.25 * (growth - 2.0 * theta), 0.5 * growth, growth + 1.0


LAWS = {
    # mu e:e + lambda/2 tr(e)^2 with e = ln(C) / 2 (Hencky 1928)
    "hencky": Law(_log_shear, _log_slope, _log_volume),
    # mu/2 (I_1 - 2 - 2 ln J) + lambda/2 ln^2 J (Simo and Pister 1984)
    "neo_hookean": Law(_linear_shear, _linear_slope, _log_volume),
    # mu/2 (I_1 - 2 - 2 ln J) + lambda/4 (J^2 - 1 - 2 ln J) (Ciarlet 1988, sec. 4.10)
    "ciarlet": Law(_linear_shear, _linear_slope, _square_volume),
}


@dataclass(frozen=True)
class Response:
    """What a law gives at displacement gradients of any shape (..., 2, 2).

    Attributes
    ----------
    energy : (...) float
        Per reference volume [N mm/mm^3].
    stress : (..., 2, 2) float
        First Piola-Kirchhoff P [MPa].
    tangent : (..., 2, 2, 2, 2) float
        dP_ij/dF_kl [MPa].
    stretch : (...) float
        The larger principal stretch.
    """

    energy: Floats
    stress: Floats
    tangent: Floats
    stretch: Floats


def respond(law: str, lame: tuple[float, float], H: Floats) -> Response:
    """Evaluate a law.

    Parameters
    ----------
    law : {"hencky", "neo_hookean", "ciarlet"}
    lame : tuple of float
        lambda and mu [MPa].
    H : (..., 2, 2) float
        Displacement gradient du_i/dX_j; the determinant of F = 1 + H is positive.

    Returns
    -------
    Response
        S = sum_a S_a n_a n_a in the eigenvectors of C, P = F S, and the derivative of S by that
        of eigenvalues and eigenvectors (Ogden 1984, sec. 6.1.4).
    """
    lam, mu = lame
    rules = LAWS[law]
    Ht = np.swapaxes(H, -1, -2)
    # The eigenvalues of C - 1 keep their digits at small strain.
    x, n = np.linalg.eigh(H + Ht + Ht @ H)
    c = 1.0 + x
    Gamma, gamma, slope = rules.shear(x)
    U, dU, ddU = rules.volume(0.5 * np.log1p(x).sum(axis=-1))
    tau = 2.0 * mu * gamma + lam * dU[..., None]
    S = tau / c
    F = np.eye(2) + H

    # dS_a/dc_b, and (S_1 - S_2) / (c_1 - c_2) without the difference.
    d = 0.5 * lam * ddU[..., None, None] / (c[..., :, None] * c[..., None, :])
    for a in range(2):
        d[..., a, a] += (mu * slope[..., a] - tau[..., a]) / c[..., a] ** 2
    mixed = 2.0 * mu * rules.shear_slope(x[..., 0], x[..., 1])
    g = (mixed * c[..., 1] - tau[..., 1]) / (c[..., 0] * c[..., 1])

    dyads = np.einsum("...ia,...ja->...aij", n, n)
    cross = np.einsum("...i,...j->...ij", n[..., 0], n[..., 1])
    cross = cross + np.swapaxes(cross, -1, -2)
    second = np.einsum("...a,...aij->...ij", S, dyads)
    # F before the dyads: P and A have one leg in space.
    legs = F[..., None, :, :] @ dyads
    cross = F @ cross
    tangent = 2.0 * np.einsum("...ab,...aij,...bkl->...ijkl", d, legs, legs, optimize=True)
    tangent += np.einsum("...,...ij,...kl->...ijkl", g, cross, cross)
    tangent += np.einsum("ik,...jl->...ijkl", np.eye(2), second)
    energy = 2.0 * mu * Gamma.sum(axis=-1) + lam * U
    return Response(energy, F @ second, tangent, np.sqrt(c[..., 1]))


def least_acoustic(law: str, lame: tuple[float, float], H: Floats, directions: int = 180) -> Floats:
    """Return the smallest eigenvalue of the acoustic tensor N_j A_ijkl N_l [MPa], (...).

    Negative where the law is not elliptic. The directions N are evenly spaced, so that the true
    minimum lies lower by a part of second order in their spacing (a degree).
    """
    tangent = respond(law, lame, H).tangent
    least = np.full(H.shape[:-2], np.inf)
    for angle in np.arange(directions) * np.pi / directions:
        N = np.array([np.cos(angle), np.sin(angle)])
        Q = np.einsum("j,...ijkl,l->...ik", N, tangent, N)
        mean, half = 0.5 * (Q[..., 0, 0] + Q[..., 1, 1]), 0.5 * (Q[..., 0, 0] - Q[..., 1, 1])
        np.minimum(least, mean - np.hypot(half, Q[..., 0, 1]), out=least)
    return least


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


@dataclass(frozen=True)
class Equilibrium:
    """A solved state.

    Attributes
    ----------
    factor : float
        Of the loads.
    displacement : (n, 2) float
        [mm].
    reaction : (n, 2) float
        Internal less external force, at prescribed components [N/mm].
    energy : float
        Strain energy [N mm/mm].
    residuals : tuple of float
        Norm of the free residual relative to the internal forces, by iteration.
    negative_pivots : int
        Of the tangent of the free unknowns.
    stretch : float
        The largest.
    """

    factor: float
    displacement: Floats
    reaction: Floats
    energy: float
    residuals: tuple[float, ...]
    negative_pivots: int
    stretch: float


def at_rest(solid: Solid) -> Equilibrium:
    """Return the reference state."""
    zero = np.zeros_like(solid.nodes)
    return Equilibrium(0.0, zero, zero, 0.0, (), 0, 1.0)


@dataclass(frozen=True)
class _Trial:
    """Forces, stiffness and energy at a displacement."""

    force: Floats
    energy: float
    stiffness: csc_array
    stretch: float


def _evaluate(solid: Solid, u: Floats) -> _Trial | None:
    """Assemble at a displacement; None where an element is turned inside out."""
    H = solid.displacement_gradient(u)
    F = np.eye(2) + H
    if (F[..., 0, 0] * F[..., 1, 1] - F[..., 0, 1] * F[..., 1, 0]).min() <= 0.0:
        return None
    response = respond(solid.law, solid.lame, H)
    elements, B, w = solid.elements, solid.gradients, solid.weights
    m, k = elements.shape
    parts = np.einsum("mq,mqij,mqaj->mai", w, response.stress, B, optimize=True)
    dofs = (2 * elements[:, :, None] + np.arange(2)).reshape(m, 2 * k)
    force = np.bincount(dofs.ravel(), parts.ravel(), minlength=solid.nodes.size)
    blocks = np.zeros((m, k, 2, k, 2))
    for q in range(w.shape[1]):
        half = np.einsum("m,mijkl,mbl->mijbk", w[:, q], response.tangent[:, q], B[:, q])
        blocks += np.einsum("maj,mijbk->maibk", B[:, q], half)
    rows = np.broadcast_to(dofs[:, :, None], (m, 2 * k, 2 * k))
    matrix = coo_array(
        (blocks.ravel(), (rows.ravel(), rows.transpose(0, 2, 1).ravel())),
        shape=(solid.nodes.size,) * 2,
    )
    energy = float((w * response.energy).sum())
    return _Trial(force, energy, matrix.tocsc(), float(response.stretch.max()))


def _factor(matrix: csc_array) -> tuple[SuperLU, int]:
    """Factor a symmetric matrix without off-diagonal pivots; count the negative pivots."""
    lu = splu(
        matrix,
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    # By Sylvester's law the signs are those of the eigenvalues only if rows went with columns.
    if not np.array_equal(lu.perm_r, lu.perm_c):
        raise NotConvergedError("a pivot off the diagonal: the stiffness is singular")
    return lu, int((lu.U.diagonal() < 0.0).sum())


def newton(
    solid: Solid, loads: Loads, factor: float, start: Equilibrium, tolerance: float = TOLERANCE
) -> Equilibrium:
    """Find the equilibrium at a load factor from a state near by.

    Parameters
    ----------
    solid : Solid
    loads : Loads
    factor : float
    start : Equilibrium
    tolerance : float
        On the norm of the free residual relative to that of all nodal forces.

    Raises
    ------
    NotConvergedError

    Notes
    -----
    The first iteration moves the prescribed nodes and all others by the tangent of the start.
    Steps are halved until no element is turned inside out and either the residual or the
    potential falls.
    """
    free = ~loads.prescribed.ravel()
    external = factor * loads.force.ravel()
    u = start.displacement.ravel().copy()
    move = np.where(free, 0.0, factor * loads.displacement.ravel() - u)
    trial = _evaluate(solid, u.reshape(-1, 2))
    if trial is None:
        raise NotConvergedError("the start is no admissible state")
    residuals: list[float] = []
    for _ in range(ITERATIONS):
        residual = (trial.force - external)[free]
        scale = max(float(np.linalg.norm(trial.force)), float(np.linalg.norm(external)))
        size = float(np.linalg.norm(residual))
        arrived = not move.any()
        if arrived:
            residuals.append(size / scale if scale else 0.0)
        lu, negative = _factor(trial.stiffness[free][:, free])
        if arrived and size <= tolerance * scale:
            return Equilibrium(
                factor,
                u.reshape(-1, 2),
                np.where(free, 0.0, trial.force - external).reshape(-1, 2),
                trial.energy,
                tuple(residuals),
                negative,
                trial.stretch,
            )
        step = move.copy()
        step[free] = -lu.solve(residual + (trial.stiffness @ move)[free])
        potential = trial.energy - float(external @ u)
        slope = float(residual @ step[free])
        length = 1.0
        while True:
            following = _evaluate(solid, (u + length * step).reshape(-1, 2))
            if following is not None:
                lower = float(np.linalg.norm((following.force - external)[free])) < size
                level = following.energy - float(external @ (u + length * step))
                if not arrived or lower or level < potential + 1e-4 * length * min(slope, 0.0):
                    break
            length *= 0.5
            # The prescribed part is taken whole or not at all: the caller makes the step smaller.
            if not arrived or length < 1e-3:
                raise NotConvergedError(f"no admissible step at factor {factor:.6g}")
        u += length * step
        move = np.zeros_like(u)
        trial = following
    raise NotConvergedError(f"{ITERATIONS} iterations at factor {factor:.6g}")


def follow(
    solid: Solid,
    loads: Loads,
    factors: Sequence[float],
    *,
    first_step: float,
    resolution: float = 0.0,
    start: Equilibrium | None = None,
) -> Iterator[Equilibrium]:
    """Follow the path of stable equilibria through ascending load factors.

    Parameters
    ----------
    solid : Solid
    loads : Loads
    factors : sequence of float
        At which states are wanted.
    first_step : float
        Largest first step; later ones grow by 1.5 after six iterations or fewer, and are halved
        where Newton's method fails, a pivot is negative, or the largest stretch jumps.
    resolution : float
        Step below which the path counts as ended; by default a thousandth of the first.
    start : Equilibrium, optional
        At rest by default.

    Yields
    ------
    Equilibrium

    Raises
    ------
    StabilityLostError
    """
    resolution = resolution or 1e-3 * first_step
    state = start or at_rest(solid)
    step = first_step
    for wanted in factors:
        while state.factor < wanted:
            trial = wanted if wanted - state.factor < 1.001 * step else state.factor + step
            following = None
            with suppress(NotConvergedError):
                following = newton(solid, loads, trial, state)
            near = following is not None and following.stretch <= JUMP * state.stretch
            if near and following.negative_pivots == 0:
                if len(following.residuals) <= 6 and trial < wanted:
                    step *= 1.5
                state = following
                continue
            step = 0.5 * (trial - state.factor)
            if step < resolution:
                raise StabilityLostError(state, trial, following if near else None)
        yield state


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


def hold(loads: Loads, nodes: Ints | int, axis: int, value: float = 0.0) -> Loads:
    """Return the loads with one component prescribed at nodes."""
    prescribed, displacement = loads.prescribed.copy(), loads.displacement.copy()
    prescribed[nodes, axis] = True
    displacement[nodes, axis] = value
    return replace(loads, prescribed=prescribed, displacement=displacement)
