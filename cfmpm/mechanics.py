"""Choice between small strain and finite deformation, and the solve."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from cfmpm.body import body as bodies
from cfmpm.body import transfer
from cfmpm.body.body import Body
from cfmpm.body.grid import Floats, Grid
from cfmpm.clock import Clock
from cfmpm.equilibrium import small_strain, stepping
from cfmpm.equilibrium.balance import Equilibrium, FiniteEffect
from cfmpm.equilibrium.problem import BoundaryValueProblem
from cfmpm.errors import SolveError
from cfmpm.fracture import cf, finite_effect
from cfmpm.scene.model import Scene
from cfmpm.updated import reference


def load_levels(scene: Scene) -> list[float]:
    """Return the load factors of the load steps of a scene, in their order."""
    if isinstance(scene.load_steps, int):
        return [(i + 1) / scene.load_steps for i in range(scene.load_steps)]
    return list(scene.load_steps)


def locate(body: Body) -> tuple[Body, Floats]:
    """Find the triangles of the quadrature points, and evaluate the basis gradients there.

    Returns
    -------
    body : Body
        With the triangles of its points.
    gradients : (p, k, 2) float
        With respect to the position in the reference configuration [1/mm].
    """
    body = bodies.locate(body)
    grid, points = body.grid, body.integration
    gradients: Floats = grid.basis_gradients(points.element, points.position)
    if body.motion is None:
        return body, gradients
    return body, reference.pull_back(gradients, body.motion.base)


def problem_of(body: Body, gradients: Floats, solver: str = "auto") -> BoundaryValueProblem:
    """Pose the boundary value problem of a body.

    Parameters
    ----------
    body : Body
    gradients : (p, k, 2) float
        Basis gradients at its quadrature points [1/mm].
    solver : str
        A word of `registry.solvers`.
    """
    problem = BoundaryValueProblem(
        grid=body.grid,
        points=body.integration,
        gradients=gradients,
        materials=body.materials,
        loading=body.loading,
        solver=solver,
        patches=body.patches,
    )
    if body.motion is None:
        return problem
    return replace(
        problem,
        base=body.motion.base,
        faces=reference.closed_faces(body, body.motion),
        forces=body.motion.forces,
    )


def solve(
    scene: Scene,
    body: Body,
    gradients: Floats,
    last: Equilibrium | None,
    level: float,
    clock: Clock,
    reach: float | None = None,
) -> Equilibrium:
    """Solve for equilibrium of a body at a load factor.

    Parameters
    ----------
    scene : Scene
        With kinematics, solver and load steps.
    body : Body
    gradients : (p, k, 2) float
        Basis gradients at its quadrature points [1/mm].
    last : Equilibrium or None
        The equilibrium before, on this grid; None before the first one, and at small strain after
        growth has changed the grid.
    level : float
        Load factor.
    clock : Clock
    reach : float, optional
        Load factor at which the state is of interest, near enough to judge whether finite
        deformation may be felt; by default the largest of the load steps.

    Returns
    -------
    Equilibrium
        At small strain under proportional loads it is that at load factor one, to be scaled.

    Raises
    ------
    SolveError
        If no equilibrium is found.
    """
    problem = problem_of(body, gradients, scene.solver)
    if last is not None and last.finite:
        found = _solve_finite(problem, last, level, clock)
        return replace(found, finite_effect=last.finite_effect)
    if scene.kinematics == "finite":
        return _solve_finite(problem, None, level, clock)
    if last is not None and last.proportional:
        return last
    levels = load_levels(scene)
    largest = max(map(abs, levels))
    proportional = problem.loading.is_proportional
    at_small = partial(_solve_small, body, problem, clock, once=scene.growth is None)
    states = [at_small(1.0, largest, reach or largest)] if proportional else [at_small(level)]
    # The kinematics do not change within a run.
    if last is not None or not _may_be_finite(scene):
        return states[0]
    if not proportional:
        # The smallest and the largest load, and the fixed loads alone.
        ends = {min(levels), max(levels), 0.0}
        states += [at_small(end) for end in ends]
    effect = _largest_effect(states)
    reached = levels if proportional else [1.0]
    if min(levels) >= 0.0 and effect.largest(reached) <= finite_effect.NEGLIGIBLE:
        return states[0]
    try:
        found = _solve_finite(problem, None, level, clock)
    except SolveError as failure:
        raise SolveError(
            f"{failure}. Finite deformation was chosen by kinematics: auto; kinematics: small does "
            "without it, and warns of what it neglects"
        ) from failure
    return replace(found, finite_effect=effect)


def carry_over(balance: Equilibrium, old: Grid, body: Body) -> Equilibrium | None:
    """Transfer an equilibrium to a body whose grid was changed by growth.

    At small strain nothing is transferred: the next solve does not need a start.
    """
    if not balance.finite:
        return None
    nothing = np.zeros((len(body.grid.nodes), 2))
    return replace(
        balance,
        points=body.integration.at_rest(body.materials.n_internal),
        displacement=transfer.interpolate_displacement(old, balance.displacement, body.grid),
        internal_force=nothing,
        contact_force=nothing,
    )


def nodal_force(body: Body, gradients: Floats, balance: Equilibrium) -> Floats:
    """Sum the configurational force at every node of a body in equilibrium [N/mm], (n, 2).

    CF_I = - sum_p (W I - H^T P) dS_I/dX V_p with the displacement gradient H. With F in its place
    the internal force is added, which is zero in equilibrium. On the reference of a grid that is
    reset it is of the order of the configurational force even at small strain.
    """
    body_force = body.loading.at(balance.load_factor).body_force
    summed = cf.finite_nodal_force if balance.finite else cf.nodal_force
    return summed(body.grid, balance.points, gradients, body_force)


def plastic_nodal_force(body: Body, gradients: Floats, balance: Equilibrium) -> Floats | None:
    """Sum the contribution of plastic work to the configurational force at every node.

    Parameters
    ----------
    body : Body
    gradients : (p, k, 2) float
    balance : Equilibrium
        Equilibrium of the body.

    Returns
    -------
    (n, 2) float or None
        - sum_p W_p dS_I/dX V_p with W_p the plastic work per reference volume [N/mm]; None without
        plastic materials. With this contribution the force is that of the whole stress work,
        W_e + W_p, as in Rice's J; without it that of the stored energy, which depends on the
        domain.
    """
    points = balance.points
    if not points.internal_variables.size:
        return None
    work = replace(
        points,
        stress=np.zeros_like(points.stress),
        energy=body.materials.plastic_work(points),
    )
    return cf.finite_nodal_force(body.grid, work, gradients, np.zeros(2))


def effects(body: Body, balance: Equilibrium, factor: float) -> tuple[float, Floats]:
    """What finite deformation changes at a load factor: in the energy, and in J of each tip.

    Under proportional loads it is judged once for all load factors. Where some loads are fixed it
    is judged at each load at small strain, and before a run at finite deformation at the largest.
    """
    if balance.finite_effect is None:
        return math.nan, np.zeros(0)
    at = factor if body.loading.is_proportional else 1.0
    return balance.finite_effect.on_energy(at), balance.finite_effect.on_j(at)


def _may_be_finite(scene: Scene) -> bool:
    """Whether the kinematics of a scene may turn out to be finite deformation."""
    return scene.kinematics == "auto" and scene.plane == "strain" and scene.growth is None


def _solve_small(
    body: Body,
    problem: BoundaryValueProblem,
    clock: Clock,
    factor: float,
    largest: float = 1.0,
    reach: float = 1.0,
    *,
    once: bool,
) -> Equilibrium:
    """Solve at small strain, and judge what finite deformation changes: see `finite_effect.judge`.

    The stiffness matrix is freed on return.
    """
    with clock("stiffness"):  # step 3
        stiffness = small_strain.assemble_stiffness(problem)
    with clock("equilibrium"):  # steps 4 to 6: forces, solve, update of the points
        tangent = small_strain.factored(problem, stiffness)
        balance = small_strain.solve_linear(problem, stiffness, factor, tangent)
    with clock("fracture"):
        small = finite_effect.Judged(body, problem, balance, tangent)
        effect = finite_effect.judge(small, largest, reach, once=once)
    return replace(balance, finite_effect=effect)


def _largest_effect(states: Sequence[Equilibrium]) -> FiniteEffect:
    """The largest effect of finite deformation in states: on the energy, and on J of each tip."""
    found = [state.finite_effect for state in states if state.finite_effect is not None]
    tips = zip(*(effect.J for effect in found if effect.J), strict=True)
    return FiniteEffect(
        max((effect.energy for effect in found), key=_size),
        tuple(max(tip, key=_size) for tip in tips),
        min(effect.least for effect in found),
    )


def _size(coefficients: tuple[float, float]) -> float:
    """Size of an effect at a factor of one; 0 where there is none."""
    return abs(float(np.nan_to_num(sum(coefficients))))


def _solve_finite(
    problem: BoundaryValueProblem, last: Equilibrium | None, level: float, clock: Clock
) -> Equilibrium:
    with clock("equilibrium"):  # steps 3 to 6 in each iteration
        if last is None:
            return _turned(problem, stepping.from_rest(problem, level))
        if last.load_factor != level:
            return _turned(problem, stepping.advance(problem, last, level))
        return _turned(problem, _rebalanced(problem, last))


def _rebalanced(problem: BoundaryValueProblem, last: Equilibrium) -> Equilibrium:
    """Find the equilibrium after growth at the same load factor."""
    try:
        return stepping.rebalance(problem, last)
    except SolveError:
        if last.points.internal_variables.size or problem.base is not None:
            raise
    # An elastic state does not depend on the load path; it may start at zero load.
    afresh = stepping.from_rest(problem, last.load_factor)
    if afresh.stopped:
        raise SolveError(
            f"no stable state was found after growth at load factor {last.load_factor:.6g}; "
            f"from zero load {afresh.stopped}"
        )
    moved = afresh.displacement - last.displacement
    force = problem.loading.at(last.load_factor).force
    work = np.sum(np.where(problem.loading.prescribed, 0.0, force) * moved)
    return replace(afresh, external_work=last.external_work + float(work))


def _turned(problem: BoundaryValueProblem, balance: Equilibrium) -> Equilibrium:
    """Release a held rigid rotation, so that the loads have no moment on the deformed body.

    Loads without a moment on the undeformed body can have one on the deformed body. It would be a
    reaction at the nodes that hold the rotation. If the loads do not stabilise the rotation, as
    under compression, it remains held.
    """
    loading = problem.loading
    if not loading.holds.turning.size or balance.stopped:
        return balance
    prescribed = loading.prescribed.copy()
    prescribed[tuple(loading.holds.turning.T)] = False
    try:
        return stepping.rebalance(
            replace(problem, loading=replace(loading, prescribed=prescribed)), balance
        )
    except SolveError:
        return balance


def leans(body: Body, balance: Equilibrium) -> bool:
    """Whether a rotation that the program holds carries a force at finite deformation."""
    return held_turning(body, balance) > 1e-6


def held_turning(body: Body, balance: Equilibrium) -> float:
    """Force by which the program holds a rotation at finite deformation, over the largest one."""
    places = tuple(body.loading.holds.turning.T)
    if not balance.finite or not body.loading.holds.turning.size:
        return 0.0
    force = balance.internal_force - body.loading.at(balance.load_factor).force
    largest = float(np.abs(balance.internal_force).max(initial=0.0))
    return float(np.abs(force[places]).max()) / largest if largest > 0.0 else 0.0
