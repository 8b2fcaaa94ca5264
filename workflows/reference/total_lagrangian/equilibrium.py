"""Equilibria by Newton's method, and the path of the stable ones."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import SuperLU, splu

from workflows.reference.total_lagrangian.laws import Floats, respond
from workflows.reference.total_lagrangian.solid import Bools, Loads, Solid

TOLERANCE = 1e-11
ITERATIONS = 25
# Growth of the largest stretch from one accepted state to the next: a solution that jumps past a
# loss of stability has positive pivots only, as before, and shows by its stretch alone.
JUMP = 1.1


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


def _admissible(
    solid: Solid,
    external: Floats,
    free: Bools,
    u: Floats,
    trial: _Trial,
    step: Floats,
    *,
    arrived: bool,
) -> tuple[float, _Trial]:
    """Halve a correction of Newton's method until the state at its end is admissible.

    Parameters
    ----------
    solid : Solid
    external, u, step : (2 n,) float
        Forces [N/mm], displacement and its correction [mm].
    free : (2 n,) bool
    trial : _Trial
        At `u`.
    arrived : bool
        Whether prescribed components have their values. Else the correction moves them, and is
        taken whole or not at all: the caller makes the step of the load smaller.

    Returns
    -------
    length : float
        Part of the correction that is taken.
    following : _Trial
        At its end.

    Raises
    ------
    NotConvergedError
    """
    residual = (trial.force - external)[free]
    size = float(np.linalg.norm(residual))
    potential = trial.energy - float(external @ u)
    slope = float(residual @ step[free])
    length = 1.0
    while True:
        following = _evaluate(solid, (u + length * step).reshape(-1, 2))
        if following is not None:
            lower = float(np.linalg.norm((following.force - external)[free])) < size
            level = following.energy - float(external @ (u + length * step))
            if not arrived or lower or level < potential + 1e-4 * length * min(slope, 0.0):
                return length, following
        length *= 0.5
        if not arrived or length < 1e-3:
            raise NotConvergedError("no admissible step")


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
        length, trial = _admissible(solid, external, free, u, trial, step, arrived=arrived)
        u += length * step
        move = np.zeros_like(u)
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
