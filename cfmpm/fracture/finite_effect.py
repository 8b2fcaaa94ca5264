"""What finite deformation would change in a state of small strain."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cfmpm.body.body import Body
from cfmpm.body.grid import Floats
from cfmpm.equilibrium import correction, small_strain, stepping
from cfmpm.equilibrium.balance import Equilibrium, FiniteEffect
from cfmpm.equilibrium.problem import BoundaryValueProblem
from cfmpm.errors import SolveError
from cfmpm.fracture import cf
from cfmpm.fracture.evaluation import evaluate_tips, j_of_tips
from cfmpm.kernels import departure
from cfmpm.linear.solvers import Factor

# Relative change of the energy or of J by finite deformation above which it is found out by
# corrections of the state, `auto` takes it into account, and else it is told. A tenth of this would
# be exceeded by steel at half its yield stress (strain 1e-3), which would then have no K.
NEGLIGIBLE = 1e-2
# Estimate of first order above which that is found out. Under dead loads it is 3/4 of the change,
# where displacements are prescribed 3/2.
LOOKED_AT = 0.75 * NEGLIGIBLE
# Energy over modulus times displacement squared below which it is round-off of a rigid motion.
ROUND_OFF = 1e-24
# Effect on the energy, and mean displacement gradient times slenderness of the body, up to which
# the effect on J is not looked for: with both, it is at most 0.6 % in columns and edge-cracked
# plates up to 20 times as long as wide, and in 670 random scenes.
FELT_ENERGY, FELT, FELT_BY_CLOSED = 5e-4, 1e-3, 3e-4
# Largest displacement gradient of the state at which the change of J is taken: so small that it is
# the derivative in slender arms too, where terms of second order are large by their rotation.
SMALL = 1e-7
# Lame's constant lambda over mu from which a state that has not settled is looked at with this one
# (nu 0.4995), and the largest relative change of the strain energy by that: what is left over of
# compressibility. The effect of finite deformation changes by mu / lambda.
ALMOST, SAME_ENERGY = 1e3, 1e-2
# Load steps of Newton's method, of 1 % strain and then more, after which a size is given up.
MOST_STEPS = 30
# J below this part of the strain energy over the clearance of the tip is no J to compare with.
NO_J = 1e-6


def on_energy(
    problem: BoundaryValueProblem, balance: Equilibrium, scale: float = 1.0
) -> tuple[float, float]:
    """Estimate the relative change of the strain energy by finite deformation.

    Parameters
    ----------
    problem : BoundaryValueProblem
        With elastic materials.
    balance : Equilibrium
        At small strain.
    scale : float
        Factor on the state, greater than zero.

    Returns
    -------
    effect : float
        |sum_p (P - sigma) : H V_p| / (2 W) of the scaled state: the work of the force r that its
        displacement u leaves unbalanced at finite deformation, |r . u| / (2 W). As both r and W are
        of second order in u, the estimate is of first order in the load. If det F of a point is
        not positive, the estimate at a smaller load is extrapolated linearly.
    gradient : float
        Mean norm of the displacement gradient of `balance`, weighted with the energy.
    """
    points, materials = balance.points, problem.materials
    energy = points.energy @ points.volume
    if not energy > ROUND_OFF * materials.elastic.max() * np.square(balance.displacement).max():
        return 0.0, 0.0
    nothing = np.zeros((len(points), materials.n_internal))
    factor = scale
    while True:
        work, linear, size = departure.departure(
            points.volume,
            points.material,
            materials.law,
            materials.constants,
            nothing,
            factor * points.displacement_gradient,
            factor * points.stress,
            problem.patch,
        )
        if not np.isnan(work):
            return abs(work) / linear * scale / factor, size / factor
        factor *= 0.5


def may_be_felt(body: Body, balance: Equilibrium, energy: float, gradient: float) -> bool:
    """Whether finite deformation may change J by a few per mille.

    Parameters
    ----------
    body : Body
    balance : Equilibrium
        At small strain.
    energy, gradient : float
        From `on_energy`.

    Notes
    -----
    Sums of work have parts of opposite sign, which cancel while J changes: in an edge-cracked plate
    at a crack length of 0.3 widths. The mean norm of the displacement gradient has not; it counts
    times the square of the diagonal of the body over its area. At tips that are almost closed J is
    small, and changes by more.
    """
    slenderness = body.grid.diagonal**2 / body.integration.volume.sum()
    limit = FELT_BY_CLOSED if balance.contact_pairs else FELT
    return bool(energy > FELT_ENERGY or slenderness * gradient > limit)


@dataclass(frozen=True)
class Judged:
    """A state of small strain that is judged.

    Attributes
    ----------
    body : Body
    problem : BoundaryValueProblem
        Of the body, with elastic materials.
    balance : Equilibrium
        At small strain.
    factor : Factor
        Of the stiffness of small strain.
    """

    body: Body
    problem: BoundaryValueProblem
    balance: Equilibrium
    factor: Factor

    @cached_property
    def energy(self) -> float:
        """Strain energy [N]."""
        return float(self.balance.points.energy @ self.balance.points.volume)

    @cached_property
    def density(self) -> Floats:
        """Body force [N/mm^3], (2,)."""
        return self.body.loading.at(self.balance.load_factor).body_force

    @cached_property
    def release_rate(self) -> Floats:
        """J of each tip [N/mm], nan where there is none, (tip,)."""
        body, balance, gradients = self.body, self.balance, self.problem.gradients
        nodal = cf.nodal_force(body.grid, balance.points, gradients, self.density)
        least = np.array([NO_J * self.energy / domain.clearance for domain in body.tip_domains])
        if not (balance.contact_pairs and body.grid.tips):
            values = j_of_tips(body, balance, nodal)
        else:
            # Of closed tips J has an error, which the evaluation tells.
            tips = evaluate_tips(body, gradients, balance, nodal)
            values, least = tips["J"], np.fmax(least, tips["G_floor"])
        return np.where(values > least, values, np.nan)

    @cached_property
    def slopes(self) -> Floats:
        """Relative change of the energy, and of J at every tip, by finite deformation, (1 + tip,).

        The derivative by a factor on the state, at zero; nan of a tip without J.

        Notes
        -----
        The displacement of small strain leaves a force of second order unbalanced at finite
        deformation. One correction by the stiffness of small strain, with contact of crack faces,
        makes the displacement right to second order, and J of the finite Eshelby stress to third
        order: as J is of second order, its relative change is right to first order. So is that of
        the energy.
        """
        largest = np.abs(self.balance.points.displacement_gradient).max(initial=0.0)
        if not largest > 0.0:
            return np.full(1 + len(self.body.tip_domains), np.nan)
        part = SMALL / largest
        state = correction.first_correction(self.problem, self.balance, self.factor, part)
        return self.changes(state, part) / part

    def changes(self, state: Equilibrium, scale: float) -> Floats:
        """Relative change of the energy, and of J of each tip, (1 + tip,).

        Parameters
        ----------
        state : Equilibrium
            At finite deformation.
        scale : float
            Factor on the state of small strain that it is compared with.
        """
        stored = state.points.energy @ state.points.volume
        J = self.release_rate
        if np.isfinite(J).any():
            of, density = self.problem.gradients, scale * self.density
            nodal = cf.finite_nodal_force(self.body.grid, state.points, of, density)
            J = j_of_tips(self.body, state, nodal) / (scale**2 * self.release_rate)
        return np.append(stored / (scale**2 * self.energy), J) - 1.0

    def by(self, state: Equilibrium, at: float) -> FiniteEffect:
        """What finite deformation changes, from the state at a factor and the slope at zero."""
        second = (self.changes(state, at) / at - self.slopes) / at
        energy, *J = zip(self.slopes.tolist(), second.tolist(), strict=True)
        return FiniteEffect(energy, tuple(J))

    @property
    def load_of_growth(self) -> float:
        """Factor on the state at which J of a tip reaches the least toughness; 0 if none does."""
        toughness = self.body.materials.g_c[np.isfinite(self.body.materials.g_c)]
        driving = np.nanmax(self.release_rate, initial=0.0)
        return math.sqrt(toughness.min() / driving) if toughness.size and driving > 0.0 else 0.0


def judge(
    small: Judged,
    largest: float = 1.0,
    reach: float = 1.0,
    *,
    once: bool = False,
) -> FiniteEffect:
    """Judge what finite deformation changes in a state of small strain.

    Parameters
    ----------
    small : Judged
    largest : float
        Largest factor on the state, greater than zero.
    reach : float
        Factor on the state at which it is of interest, as at growth; infinite if none is known.
    once : bool
        Whether no state of a grown crack follows: Newton's method can then be afforded.

    Returns
    -------
    FiniteEffect
        Of first order where that is at most `LOOKED_AT` at `reach`. Else the state at `reach` is
        found: the change is that there, and has the right slope at zero. If it is not found, a
        change above `LOOKED_AT` is infinite.
    """
    at = reach if 0.0 < reach < math.inf else small.load_of_growth or largest
    energy, gradient = on_energy(small.problem, small.balance, at)
    energy /= at
    J: Floats = np.zeros(0)
    sizes = reach * energy, reach * gradient
    if small.body.grid.tips and may_be_felt(small.body, small.balance, *sizes):
        try:
            J = small.slopes[1:]
        except SolveError:  # of an estimate: the solution is there without it
            J = np.full(len(small.body.tip_domains), np.nan)
    found = FiniteEffect((energy, 0.0), tuple((slope, 0.0) for slope in J.tolist()))
    if found.largest([at]) <= LOOKED_AT:
        return found
    # With faces in contact Newton's method can cost a hundred times as much as the solution.
    afforded = 3 if once and not small.balance.contact_pairs else 2
    for way in (_by_corrections, _by_less_incompressibility, _by_newton)[:afforded]:
        try:
            return way(small, at)
        except SolveError:
            continue
    return replace(found, least=LOOKED_AT)


def _by_corrections(small: Judged, at: float) -> FiniteEffect:
    """The effect from corrections by the stiffness; SolveError if they do not settle."""
    return small.by(correction.settled(small.problem, small.balance, small.factor, at), at)


def _by_less_incompressibility(small: Judged, at: float) -> FiniteEffect:
    """As `_by_corrections` with lambda of at most `ALMOST` mu; SolveError if that is another body.

    A rotation of a nearly incompressible point by small strain leaves a pressure that hinders the
    corrections, while the effect hardly depends on what is left of compressibility.
    """
    materials = small.problem.materials
    lam = np.minimum(materials.volumetric, ALMOST * materials.lame[:, 1])
    less = lam - materials.volumetric
    if not less.any():
        raise SolveError("the materials are compressible")
    lame, constants, elastic = materials.lame.copy(), materials.constants.copy(), materials.elastic
    lame[:, 0] = constants[:, 0] = lam
    elastic = elastic + less[:, None, None] * np.pad(np.ones((2, 2)), (0, 1))
    softer = replace(materials, volumetric=lam, lame=lame, constants=constants, elastic=elastic)
    problem = replace(small.problem, materials=softer)
    stiffness = small_strain.assemble_stiffness(problem)
    factor = small_strain.factored(problem, stiffness)
    balance = small_strain.solve_linear(problem, stiffness, small.balance.load_factor, factor)
    alike = Judged(small.body, problem, balance, factor)
    if abs(alike.energy / small.energy - 1.0) > SAME_ENERGY:
        raise SolveError("compressibility is felt")
    return _by_corrections(alike, at)


def _by_newton(small: Judged, at: float) -> FiniteEffect:
    """The effect from the state itself; SolveError if it takes too many steps."""
    state = stepping.from_rest(small.problem, at * small.balance.load_factor, MOST_STEPS)
    if state.stopped:
        raise SolveError(state.stopped)
    return small.by(state, at)
