"""From a state of small strain to finite deformation by the factored stiffness of small strain."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.grid import Floats
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.equilibrium.contact import Contact
from cfmpm.equilibrium.newton import March, Trial
from cfmpm.equilibrium.problem import BoundaryValueProblem
from cfmpm.errors import SolveError
from cfmpm.linear.solvers import Factor, Solution

Flags = NDArray[np.bool_]

# Work of a correction over twice the strain energy below which the state has settled: the
# displacement is then right to 1e-5 in the norm of the energy.
SETTLED = 1e-10
# Corrections after which a state is given up, without and with crack faces in contact, each of
# which costs as much as ten of the former; tries of a line search. A cantilever of 80 times its
# height takes 55 corrections where its strain energy changes by 0.5 %.
MOST_CORRECTIONS, MOST_IN_CONTACT, MOST_TRIES = 60, 25, 8
# The work along a correction is to decrease to this part (as in `newton`); bounds on the next try
# over the last one.
LINE_SEARCH, SHORTER, LONGER = 0.8, (0.1, 0.5), 2.0


@dataclass(frozen=True)
class Learning:
    """A factored stiffness that learns from the changes of force along corrections.

    Attributes
    ----------
    factor : Factor
        Of the free components, to start from.
    learned : list of ((n,) float, (n,) float)
        Corrections [mm], and the force that the body has put up against each [N/mm].
    """

    factor: Factor
    learned: list[tuple[Floats, Floats]] = field(default_factory=list)

    def solve(self, b: Floats) -> Solution:
        """Solve for the free components by the two loops of Nocedal (Math. Comput. 35, 1980)."""
        rest, parts = b.copy(), []
        for moved, resisted in reversed(self.learned):
            parts.append((moved @ rest) / (moved @ resisted))
            rest -= parts[-1] * resisted
        plain = self.factor.solve(rest)
        found = plain.x
        for (moved, resisted), part in zip(self.learned, reversed(parts), strict=True):
            found = found + moved * (part - (resisted @ found) / (moved @ resisted))
        return replace(plain, x=found)


def first_correction(
    problem: BoundaryValueProblem, balance: Equilibrium, factor: Factor, part: float
) -> Equilibrium:
    """Correct a part of a state of small strain once towards finite deformation.

    Parameters
    ----------
    problem : BoundaryValueProblem
    balance : Equilibrium
        At small strain.
    factor : Factor
        Of the stiffness of small strain.
    part : float
        Factor on the state, small.

    Returns
    -------
    Equilibrium
        At finite deformation.
    """
    march = _march(problem)
    free = ~problem.loading.prescribed
    start = march.trial(part * balance.displacement)
    # What is left of balance at small strain is in both: it is not the effect to be found.
    unbalanced = part * (balance.internal_force - balance.contact_force) - start.internal_force
    moved = start.displacement.copy()
    moved[free] += factor.solve(unbalanced[free]).x
    if not balance.contact_pairs:
        # Faces that are open remain so in a small enough part of the state.
        return _state(balance, march.trial(moved))
    contact = march.closed(moved, start.displacement, factor)
    return _state(balance, march.trial(contact.displacement), contact.force, contact.pairs)


def settled(
    problem: BoundaryValueProblem, balance: Equilibrium, factor: Factor, scale: float
) -> Equilibrium:
    """Find the state of finite deformation that a state of small strain stands for.

    Parameters
    ----------
    problem : BoundaryValueProblem
        With elastic materials.
    balance : Equilibrium
        At small strain.
    factor : Factor
        Of the stiffness of small strain.
    scale : float
        Factor on the state and, under proportional loads, on the loads.

    Returns
    -------
    Equilibrium
        At finite deformation.

    Raises
    ------
    SolveError
        If the corrections do not settle, or if points would be inverted.

    Notes
    -----
    Newton's method with the stiffness K of small strain alone diverges in slender arms: that along
    an arm is larger than that across it by the square of its slenderness, and turns with it. It
    has the wrong sense in a few motions only. From the changes of the unbalanced force along the
    last corrections the method of Broyden, Fletcher, Goldfarb and Shanno learns those, with K^-1
    as the matrix to start from (Matthies and Strang, Int. J. Num. Meth. Eng. 14, 1979).
    """
    march = _march(problem)
    free = ~problem.loading.prescribed
    level = scale * balance.load_factor
    acting = problem.loading.at(level).force + level * problem.pull
    at = march.trial(scale * balance.displacement)
    energy = 2.0 * scale**2 * (balance.points.energy @ balance.points.volume)
    tangent = Learning(factor)
    touches = balance.contact_pairs > 0
    contact = Contact(at.displacement, np.zeros_like(acting), np.zeros(0))
    most = MOST_IN_CONTACT if touches else MOST_CORRECTIONS
    while most > 0:
        most -= 1
        goal = at.displacement.copy()
        goal[free] += tangent.solve((acting - at.resistance)[free]).x
        if touches:
            contact = march.closed(goal, at.displacement, tangent)
            goal = contact.displacement
        along = (goal - at.displacement)[free]
        left = (acting + contact.force - at.resistance)[free]
        if abs(left @ along) <= SETTLED * energy:
            if touches or not march.closed(goal, at.displacement, factor).pairs:
                return _state(balance, at, contact.force, contact.pairs)
            touches, most = True, MOST_IN_CONTACT
            continue
        at, step, after = _searched(march, at, along, left, acting + contact.force, free)
        tangent.learned.append((step * along, left - after))
    raise SolveError("corrections of a state of small strain do not settle it")


def _march(problem: BoundaryValueProblem) -> March:
    return March(problem, np.zeros((len(problem.points), problem.materials.n_internal)))


def _state(
    balance: Equilibrium, at: Trial, contact_force: Floats | None = None, pairs: int = 0
) -> Equilibrium:
    """The state of finite deformation in place of one of small strain."""
    return replace(
        balance,
        points=at.points,
        displacement=at.displacement,
        internal_force=at.internal_force,
        contact_force=np.zeros_like(at.displacement) if contact_force is None else contact_force,
        contact_pairs=pairs,
        finite=True,
    )


def _searched(
    march: March, at: Trial, along: Floats, left: Floats, acting: Floats, free: Flags
) -> tuple[Trial, float, Floats]:
    """Find the step along a correction after which the force left does little work along it."""
    work, step = left @ along, 1.0
    for _ in range(MOST_TRIES):
        moved = at.displacement.copy()
        moved[free] += step * along
        try:
            trial = march.trial(moved)
        except SolveError:
            step *= SHORTER[1]
            continue
        after = (acting - trial.resistance)[free]
        if abs(after @ along) <= LINE_SEARCH * abs(work):
            return trial, step, after
        # By the secant if the step is too long.
        slope = work / (work - after @ along)
        step *= float(np.clip(slope, *SHORTER)) if after @ along < 0.0 else LONGER
    raise SolveError("the line search along a correction by the stiffness of small strain failed")
