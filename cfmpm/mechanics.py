"""How a body deforms: at small strain, or by finite deformation, whichever the scene needs."""

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

# Part of the energy that finite deformation would change, above which `auto` takes it. A tenth of
# that would send steel at half its yield stress (strain 1e-3) there, and take away its K.
NEGLIGIBLE = 1e-2
# Energy, relative to modulus times displacement squared, that is only the round-off of a body whose
# parts move as a whole.
ROUND_OFF = 1e-24


def load_levels(scene: Scene) -> list[float]:
    """Return the load factors that a scene is recorded at, in their order."""
    if isinstance(scene.load_steps, int):
        return [(i + 1) / scene.load_steps for i in range(scene.load_steps)]
    return list(scene.load_steps)


def locate(body: Body) -> tuple[Body, Floats]:
    """Find the triangles of the quadrature points, and evaluate the basis gradients there.

    Returns
    -------
    body : Body
        With the triangles found.
    gradients : (p, k, 2) float
        By the position in the reference configuration [1/mm].
    """
    body = bodies.locate(body)
    grid, points = body.grid, body.integration
    gradients: Floats = grid.basis_gradients(points.element, points.position)
    if body.motion is None:
        return body, gradients
    return body, reference.pull_back(gradients, body.motion.base)


def problem_of(body: Body, gradients: Floats, solver: str = "auto") -> BoundaryValueProblem:
    """Pose what has to be brought into balance.

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
    """Bring a body into balance at a load factor.

    Parameters
    ----------
    scene : Scene
        That says how: kinematics, solver, load steps.
    body : Body
    gradients : (p, k, 2) float
        Basis gradients at its quadrature points [1/mm].
    last : Equilibrium or None
        The balance before, on this grid; None before the first one, and where growth has changed
        the grid at small strain.
    level : float
        Load factor.
    clock : Clock

    Returns
    -------
    Equilibrium
        At small strain under proportional loads for load factor one: its results grow with that.

    Raises
    ------
    SolveError
        Where there is no equilibrium to be found.
    """
    problem = problem_of(body, gradients, scene.solver)
    if scene.kinematics == "finite" or (last is not None and last.finite):
        return _solve_finite(problem, last, level, clock)
    if last is not None and last.proportional:
        return last
    factor = 1.0 if problem.loading.is_proportional else level
    balance = _solve_small(problem, factor, clock)
    if scene.kinematics != "auto":
        return balance
    levels = load_levels(scene)
    # What a run has begun with it goes on with.
    may_be_finite = last is None and _may_be_finite(scene)
    if balance.proportional:
        largest = max(map(abs, levels))
        effect = finite_effect(problem, balance, largest)
        balance = replace(balance, finite_effect=effect / largest)
    else:
        effect = finite_effect(problem, balance)
        balance = replace(balance, finite_effect=effect)
        # The least and the greatest load, and that of the fixed loads alone.
        for end in {min(levels), max(levels), 0.0} if may_be_finite else ():
            other = _solve_small(problem, end, clock)
            effect = max(effect, finite_effect(problem, other))
    if may_be_finite and (min(levels) < 0.0 or effect > NEGLIGIBLE):
        return _solve_finite(problem, None, level, clock)
    return balance


def carry_over(balance: Equilibrium, old: Grid, body: Body) -> Equilibrium | None:
    """Carry a balance over to a body whose grid growth has changed.

    At small strain there is nothing to carry: the next balance is solved for from the start.
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
    """Sum the configurational force at every node of a body in balance [N/mm], (n, 2)."""
    if body.motion is not None:
        return reference.material_force(body, balance)
    body_force = body.loading.at(balance.load_factor).body_force
    summed = cf.finite_nodal_force if balance.finite else cf.nodal_force
    return summed(body.grid, balance.points, gradients, body_force)


def plastic_nodal_force(body: Body, gradients: Floats, balance: Equilibrium) -> Floats | None:
    """Sum what the plastic work adds to the configurational force at every node.

    Parameters
    ----------
    body : Body
    gradients : (p, k, 2) float
    balance : Equilibrium
        Of the body.

    Returns
    -------
    (n, 2) float or None
        - sum_p W_p dS_I/dX V_p with W_p the plastic work per reference volume [N/mm]; None where
        nothing is plastic. With it the force is that of the whole stress work, W_e + W_p, of which
        Rice's J is made; without it that of the stored energy, which depends on the domain.
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
    """Estimate what finite deformation would change of the energy of a small strain solution.

    Parameters
    ----------
    problem : BoundaryValueProblem
        Of elastic materials.
    balance : Equilibrium
        At small strain.
    scale : float
        What the state is multiplied with, greater than zero.

    Returns
    -------
    float
        Of the state so multiplied, |r . u| / (2 W) with r the unbalanced force at finite
        deformation of the displacement u. As r is of second order in u and W is too, the estimate
        is of first order in the load. Where u turns points inside out it is taken from a smaller
        load, in proportion.
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
    """Whether nothing else that a scene asks for needs small strain."""
    return scene.plane == "strain" and scene.growth is None


def _solve_small(problem: BoundaryValueProblem, factor: float, clock: Clock) -> Equilibrium:
    """Solve at small strain; the stiffness is freed with the return."""
    with clock("stiffness"):  # step 3
        stiffness = small_strain.assemble_stiffness(problem)
    with clock("equilibrium"):  # steps 4 to 6: forces, balance, state of the points
        return small_strain.solve_linear(problem, stiffness, factor)


def _solve_finite(
    problem: BoundaryValueProblem, last: Equilibrium | None, level: float, clock: Clock
) -> Equilibrium:
    with clock("equilibrium"):  # steps 3 to 6, iteration by iteration
        if last is None:
            return _turned(problem, stepping.from_rest(problem, level))
        if last.load_factor != level:
            return _turned(problem, stepping.advance(problem, last, level))
        return _turned(problem, _rebalanced(problem, last))


def _rebalanced(problem: BoundaryValueProblem, last: Equilibrium) -> Equilibrium:
    """Find the balance of a body that growth has changed, at the load it is at."""
    try:
        return stepping.rebalance(problem, last)
    except SolveError:
        if last.points.internal_variables.size:
            raise
    # Elastic: the state does not depend on the way to it, which may begin at rest.
    afresh = stepping.from_rest(problem, last.load_factor)
    if afresh.stopped:
        raise SolveError(
            f"as its crack grew, no stable state was found at load factor {last.load_factor:.6g}: "
            f"from rest {afresh.stopped}"
        )
    moved = afresh.displacement - last.displacement
    force = problem.loading.at(last.load_factor).force
    work = np.sum(np.where(problem.loading.prescribed, 0.0, force) * moved)
    return replace(afresh, external_work=last.external_work + float(work))


def _turned(problem: BoundaryValueProblem, balance: Equilibrium) -> Equilibrium:
    """Let a body turn to where the moments of its loads balance as it is deformed.

    Loads without a moment on the body at rest have one when it bends; what the program holds a
    rotation by would carry that. Where the loads are no hold themselves, as in compression, the
    rotation stays held.
    """
    loading = problem.loading
    if not loading.turning.size or balance.stopped:
        return balance
    prescribed = loading.prescribed.copy()
    prescribed[tuple(loading.turning.T)] = False
    try:
        return stepping.rebalance(
            replace(problem, loading=replace(loading, prescribed=prescribed)), balance
        )
    except SolveError:
        return balance
