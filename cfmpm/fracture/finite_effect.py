"""What finite deformation would change in a state of small strain, estimated to first order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cfmpm.body.body import Body
from cfmpm.body.grid import Floats
from cfmpm.equilibrium import newton
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.equilibrium.problem import BoundaryValueProblem
from cfmpm.fracture import cf
from cfmpm.fracture.evaluation import evaluate_tips, j_of_tips
from cfmpm.kernels import departure
from cfmpm.linear.solvers import Factor

# Energy over modulus times displacement squared below which it is round-off of a rigid motion.
ROUND_OFF = 1e-24
# Effect on the energy, and mean displacement gradient times slenderness of the body, up to which
# the effect on J is not looked for: with both, it is at most 0.6 % in columns and edge-cracked
# plates up to 20 times as long as wide, and in 670 random scenes.
FELT_ENERGY, FELT, FELT_BY_CLOSED = 5e-4, 1e-3, 3e-4
# Largest displacement gradient of the state at which the change of J is taken: so small that it is
# the derivative in slender arms too, where terms of second order are large by their rotation.
SMALL = 1e-7
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


def on_j(body: Body, problem: BoundaryValueProblem, balance: Equilibrium, factor: Factor) -> Floats:
    """Estimate the relative change of J by finite deformation at every tip.

    Parameters
    ----------
    body : Body
    problem : BoundaryValueProblem
        Of the body, with elastic materials.
    balance : Equilibrium
        At small strain.
    factor : Factor
        Of the stiffness of small strain.

    Returns
    -------
    (tip,) float
        The derivative by a factor on the state, at zero; nan of a tip without J.

    Notes
    -----
    The displacement of small strain leaves a force of second order unbalanced at finite
    deformation. One correction by the stiffness of small strain, with contact of crack faces,
    makes the displacement right to second order, and J of the finite Eshelby stress to third
    order: as J is of second order, its relative change is right to first order.
    """
    values, density = _j_of(body, problem.gradients, balance)
    largest = np.abs(balance.points.displacement_gradient).max(initial=0.0)
    if not (largest > 0.0 and np.isfinite(values).any()):
        return np.full(len(values), np.nan)
    part = SMALL / largest
    corrected = _corrected(problem, balance, factor, part)
    nodal = cf.finite_nodal_force(body.grid, corrected.points, problem.gradients, part * density)
    found = j_of_tips(body, corrected, nodal) / part**2
    return (found / values - 1.0) / part


def _j_of(body: Body, gradients: Floats, balance: Equilibrium) -> tuple[Floats, Floats]:
    """J at small strain, nan where there is none, and the body force [N/mm], [N/mm^3]."""
    density = body.loading.at(balance.load_factor).body_force
    nodal = cf.nodal_force(body.grid, balance.points, gradients, density)
    energy = balance.points.energy @ balance.points.volume
    least = np.array([NO_J * energy / domain.clearance for domain in body.tip_domains])
    if not balance.contact_pairs:
        values = j_of_tips(body, balance, nodal)
    else:
        # Of closed tips J has an error, which the evaluation tells.
        tips = evaluate_tips(body, gradients, balance, nodal)
        values, least = tips["J"], np.fmax(least, tips["G_floor"])
    return np.where(values > least, values, np.nan), density


def _corrected(
    problem: BoundaryValueProblem, balance: Equilibrium, factor: Factor, part: float
) -> Equilibrium:
    """A part of a state of small strain with one correction towards finite deformation."""
    march = newton.March(problem, np.zeros((len(problem.points), problem.materials.n_internal)))
    free = ~problem.loading.prescribed
    start = march.trial(part * balance.displacement)
    # What is left of balance at small strain is in both: it is not the effect to be found.
    unbalanced = part * (balance.internal_force - balance.contact_force) - start.internal_force
    moved = start.displacement.copy()
    moved[free] += factor.solve(unbalanced[free]).x
    contact_force = balance.contact_force
    # Faces that are open remain so in a small enough part of the state.
    if balance.contact_pairs:
        closed = march.closed(moved, start.displacement, factor)
        moved, contact_force = closed.displacement, closed.force
    trial = march.trial(moved)
    return replace(
        balance,
        points=trial.points,
        displacement=moved,
        internal_force=trial.internal_force,
        contact_force=contact_force,
        finite=True,
    )
