"""Load steps at finite deformation along stable states."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.equilibrium.newton import March
from cfmpm.equilibrium.problem import BoundaryValueProblem
from cfmpm.errors import SolveError
from cfmpm.linear.engine import NotPositiveDefiniteError

# Iterations up to which the next step is longer, and its factor.
FEW_ITERATIONS, LONGER = 6, 1.5
# Halvings of the first step after which the load is taken as a limit.
HALVINGS = 10
# Largest number of steps to a load factor, failed ones included, unless fewer are asked for. The
# shortest strain a body by 1e-5 (`FIRST_STRAIN` halved `HALVINGS` times), and this many of them by
# 0.1.
SUBSTEPS = 10_000


def at_rest(problem: BoundaryValueProblem) -> Equilibrium:
    """Return the undeformed state of a body."""
    nothing = np.zeros((len(problem.grid.nodes), 2))
    return Equilibrium(
        points=problem.points.at_rest(problem.materials.n_internal),
        displacement=nothing,
        internal_force=nothing,
        contact_force=nothing,
        contact_pairs=0,
        residual_norm=0.0,
        residual_floor=0.0,
        solver="",
        n_unknowns=0,
        iterations=0,
        load_factor=0.0,
        finite=True,
        external_work=0.0,
    )


def from_rest(problem: BoundaryValueProblem, target: float, most: int = SUBSTEPS) -> Equilibrium:
    """Load an undeformed body: in steps by its fixed loads first, then by the proportional loads.

    Parameters
    ----------
    problem : BoundaryValueProblem
    target : float
        Load factor to be reached.
    most : int
        Largest number of steps of each part.

    Returns
    -------
    Equilibrium
        As from `advance`.

    Raises
    ------
    SolveError
        As by `advance`, and if there is no stable state under the fixed loads alone.
    """
    start = at_rest(problem)
    if not problem.loading.is_proportional:
        alone = replace(problem, loading=problem.loading.fixed_alone())
        start = advance(alone, start, 1.0, most)
        if start.stopped:
            raise SolveError(f"under the fixed loads alone, times the factor, {start.stopped}")
        unstable_from = start.unstable_from if math.isnan(start.unstable_from) else 0.0
        start = replace(start, load_factor=0.0, unstable_from=unstable_from)
    return advance(problem, start, target, most)


def advance(
    problem: BoundaryValueProblem, last: Equilibrium, target: float, most: int = SUBSTEPS
) -> Equilibrium:
    """Change the load factor in steps of adaptive length along stable states.

    A state is accepted if its forces are balanced, its stiffness is positive definite, no point is
    inverted and no stretch has jumped. Points that have lost ellipticity are counted.

    Parameters
    ----------
    problem : BoundaryValueProblem
    last : Equilibrium
        The start, in equilibrium at its load factor.
    target : float
        Load factor to be reached.
    most : int
        Largest number of steps.

    Returns
    -------
    Equilibrium
        At `target`, or the last stable state, with the reason in `stopped`.

    Raises
    ------
    SolveError
        If no stable state follows `last`, or if `target` takes more than `most` steps.
    """
    march = March(problem, last.points.internal_variables)
    balance, at = last, march.trial(last.displacement)
    march.factor_at(at)
    rate = march.rate(at)
    length = march.first_step(rate, target - last.load_factor)
    shortest = abs(length) * 0.5**HALVINGS
    substeps = 0
    while balance.load_factor != target:
        substeps += 1
        if substeps > most:
            raise SolveError(
                f"load factor {target:.6g} is not reached from {last.load_factor:.6g} in "
                f"{most} substeps, the last at {balance.load_factor:.6g}; add load_steps "
                "in between"
            )
        remaining = target - balance.load_factor
        # This avoids a last step that is much shorter than the others.
        goal = target if abs(remaining) < 1.2 * abs(length) else balance.load_factor + length
        try:
            start = at.displacement + (goal - balance.load_factor) * rate
            found = march.balance(march.trial(march.apart(start)), goal, at.internal_force)
            march.check_jump(at, found.trial)
        except SolveError as failure:
            length = 0.5 * (goal - balance.load_factor)
            if abs(length) >= shortest:
                # The last factorization is that of a rejected state.
                march.factor_at(at)
                continue
            reason = (
                f"no stable state was found between load factors {balance.load_factor:.6g} and "
                f"{goal:.6g}: {_limit(failure) if balance.load_factor else failure}"
            )
            if balance is last:
                raise SolveError(reason) from failure
            return replace(balance, stopped=reason)
        balance = march.accept(balance, at, found, goal)
        at = found.trial
        if balance.load_factor != target:
            rate = march.rate(at)
        if len(found.residuals) - 1 <= FEW_ITERATIONS:
            length *= LONGER
    return balance


def rebalance(problem: BoundaryValueProblem, last: Equilibrium) -> Equilibrium:
    """Find the equilibrium at the same load factor after the grid was changed.

    Parameters
    ----------
    problem : BoundaryValueProblem
    last : Equilibrium
        With its displacement transferred to the new grid.

    Returns
    -------
    Equilibrium

    Raises
    ------
    SolveError
        If there is no stable state nearby.
    """
    march = March(problem, last.points.internal_variables)
    before = march.trial(last.displacement)
    found = march.balance(before, last.load_factor, before.internal_force)
    return march.accept(last, before, found, last.load_factor)


def _limit(failure: SolveError) -> str:
    """Describe the limit of a body that was stable so far and is therefore not a mechanism."""
    if not isinstance(failure, NotPositiveDefiniteError):
        return str(failure)
    return (
        f"the stiffness is no longer positive definite ({failure.seen}): a limit point, buckling, "
        "or softening of the material"
    )
