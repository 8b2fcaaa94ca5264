"""Choice between small strain and finite deformation, and the solve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cfmpm.body import body as bodies
from cfmpm.body import transfer
from cfmpm.body.body import Body
from cfmpm.body.grid import Floats, Grid
from cfmpm.clock import Clock
from cfmpm.equilibrium import newton, small_strain, stepping
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.equilibrium.problem import BoundaryValueProblem
from cfmpm.errors import SolveError
from cfmpm.fracture import cf
from cfmpm.scene.model import Scene
from cfmpm.updated import reference

# Relative change of the energy by finite deformation above which `auto` takes it into account. A
# tenth of this would be exceeded by steel at half its yield stress (strain 1e-3), which would then
# have no K.
NEGLIGIBLE = 1e-2
# Energy over modulus times displacement squared below which it is round-off of a rigid motion.
ROUND_OFF = 1e-24


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
    balance = _solve_small(problem, 1.0 if problem.loading.is_proportional else level, clock)
    # The kinematics do not change within a run.
    may_be_finite = last is None and _may_be_finite(scene)
    if balance.proportional:
        effect = finite_effect(problem, balance, largest)
        balance = replace(balance, finite_effect=effect / largest)
    else:
        effect = finite_effect(problem, balance)
        balance = replace(balance, finite_effect=effect)
        # The smallest and the largest load, and the fixed loads alone.
        for end in {min(levels), max(levels), 0.0} if may_be_finite else ():
            other = _solve_small(problem, end, clock)
            effect = max(effect, finite_effect(problem, other))
    if may_be_finite and (min(levels) < 0.0 or effect > NEGLIGIBLE):
        found = _solve_finite(problem, None, level, clock)
        return replace(found, finite_effect=effect / largest)
    return balance


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
    """Sum the configurational force at every node of a body in equilibrium [N/mm], (n, 2)."""
    if body.motion is not None:
        return reference.material_force(body, balance)
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


def finite_effect(problem: BoundaryValueProblem, balance: Equilibrium, scale: float = 1.0) -> float:
    """Estimate the relative change of the energy of a small strain solution by finite deformation.

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
    float
        |r . u| / (2 W) of the scaled state, with the unbalanced force r of its displacement u at
        finite deformation. As both r and W are of second order in u, the estimate is of first
        order in the load. If det F of a point is not positive, the estimate at a smaller load is
        extrapolated linearly.
    """
    points, loading = balance.points, problem.loading
    energy = points.energy @ points.volume
    stiffest = problem.materials.elastic.max()
    if not energy > ROUND_OFF * stiffest * np.square(balance.displacement).max():
        return 0.0
    factor = scale
    nothing = np.zeros((len(points), problem.materials.n_internal))
    while True:
        u = factor * balance.displacement
        moved, det_F = newton.deform(problem, u, nothing)
        if det_F.min() > 0.0:
            break
        factor *= 0.5
    acting = loading.at(balance.load_factor).force
    external = factor * acting + factor * balance.contact_force
    unbalanced = external - newton.internal_force(problem, moved)
    work = np.sum(np.where(loading.prescribed, 0.0, unbalanced * u))
    return float(abs(work) / (2.0 * factor**2 * energy) * scale / factor)


def _may_be_finite(scene: Scene) -> bool:
    """Whether the kinematics of a scene may turn out to be finite deformation."""
    return scene.kinematics == "auto" and scene.plane == "strain" and scene.growth is None


def _solve_small(problem: BoundaryValueProblem, factor: float, clock: Clock) -> Equilibrium:
    """Solve at small strain; the stiffness matrix is freed on return."""
    with clock("stiffness"):  # step 3
        stiffness = small_strain.assemble_stiffness(problem)
    with clock("equilibrium"):  # steps 4 to 6: forces, solve, update of the points
        return small_strain.solve_linear(problem, stiffness, factor)


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
        if last.points.internal_variables.size:
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
    places = tuple(body.loading.holds.turning.T)
    if not balance.finite or not body.loading.holds.turning.size:
        return False
    force = balance.internal_force - body.loading.at(balance.load_factor).force
    largest = np.abs(balance.internal_force).max(initial=0.0)
    return bool(np.abs(force[places]).max() > 1e-6 * largest)
