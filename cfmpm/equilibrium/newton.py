"""Newton's method at finite deformation, and acceptance of its states."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array

from cfmpm.body.grid import Floats
from cfmpm.body.points import DeformedPoints
from cfmpm.equilibrium.balance import RESIDUAL_AT_FLOOR, Equilibrium, round_off
from cfmpm.equilibrium.contact import Contact, Faces, Solver, TurningStiffness, close_faces
from cfmpm.equilibrium.problem import BoundaryValueProblem
from cfmpm.errors import SolveError
from cfmpm.kernels import acoustic, constitutive, finite, stretch
from cfmpm.kernels import patches as patch_kernels
from cfmpm.linear import solvers
from cfmpm.linear.solvers import Factor

# Largest accepted unbalanced force relative to the nodal forces, unless round-off is larger.
RESIDUAL = 1e-9
# Strain of a linear body (root mean square, weighted with its stiffness) in the first step.
FIRST_STRAIN = 0.01
# Iterations after which a step is halved.
MOST_ITERATIONS = 15
# Largest factor on the largest stretch, or on the inverse of the smallest, in a step: Newton's
# method can jump past a limit point to a torn state, which is in equilibrium too.
STRETCH_JUMP = 1.5
# Line search: a correction is halved until the unbalanced force decreases, or its work along the
# correction decreases to the first factor; the second is the smallest step length.
LINE_SEARCH, SHORTEST = 0.8, 1.0 / 128.0
# Displacement, relative to the size of the smallest triangle, of the finite difference for the
# effect of prescribed displacements; it is also the relative error of the prediction by it.
PROBE = 1e-6


@dataclass(frozen=True)
class Trial:
    """The state of a body at a displacement of the grid, in equilibrium or not.

    Attributes
    ----------
    displacement : (n, 2) float
        [mm].
    points : DeformedPoints
    internal_force : (n, 2) float
        [N/mm].
    other_resistance : (n, 2) float or 0
        Resistance of the additional forces of the problem [N/mm].
    """

    displacement: Floats
    points: DeformedPoints
    internal_force: Floats
    other_resistance: Floats | float

    @property
    def resistance(self) -> Floats:
        """Internal force plus resistance of the additional forces [N/mm], (n, 2)."""
        return self.internal_force + self.other_resistance


@dataclass(frozen=True)
class Balanced:
    """The converged state of Newton's method."""

    trial: Trial
    contact_force: Floats
    contact_pairs: int
    residuals: tuple[float, ...]
    floor: float


class March:
    """Follows the stable states of a problem.

    Parameters
    ----------
    problem : BoundaryValueProblem
    internal_variables : (p, h) float
        Internal variables of the last accepted state.
    """

    def __init__(self, problem: BoundaryValueProblem, internal_variables: Floats) -> None:
        self._problem = problem
        self._internal_variables = internal_variables
        self._free = ~problem.loading.prescribed
        self._chosen = solvers.select(problem.n_unknowns, problem.solver)
        self._factor: Factor | None = None

    def trial(self, displacement: Floats) -> Trial:
        """Evaluate the points; SolveError if det F of a point is not positive."""
        problem = self._problem
        points, det_F = deform(problem, displacement, self._internal_variables)
        if not det_F.min() > 0.0:
            raise SolveError(
                f"{int((~(det_F > 0.0)).sum())} material points would be inverted (det F <= 0)"
            )
        force = internal_force(problem, points)
        return Trial(displacement, points, force, problem.resistance(displacement))

    def factor_at(self, trial: Trial) -> csr_array:
        """Factor the tangent stiffness of a state; SolveError if it is not positive definite."""
        stiffness = assemble_stiffness(self._problem, trial, self._internal_variables)
        if self._factor is None:
            grid, chosen = self._problem.grid, self._chosen
            modes = None if chosen.direct else solvers.rigid_body_modes(grid.nodes, self._free)
            self._factor = chosen.factor(stiffness, modes)
        else:
            self._factor.refactor(stiffness)
        return stiffness

    def rate(self, trial: Trial) -> Floats:
        """Return the derivative of displacement by load factor, from the last factorization."""
        loads = self._problem.loading.proportional
        rate = loads.displacement.copy()
        unbalanced = loads.force + self._problem.pull
        reach = np.abs(rate).max(initial=0.0)
        if reach > 0.0:
            step = PROBE * np.sqrt(self._problem.grid.areas.min()) / reach
            probed = self.trial(trial.displacement + step * rate)
            unbalanced = unbalanced - (probed.resistance - trial.resistance) / step
        rate[self._free] += self._solve(unbalanced[self._free])
        return rate

    def first_step(self, rate: Floats, total: float) -> float:
        """Return the change of load factor for which the strain is `FIRST_STRAIN`."""
        grid, points = self._problem.grid, self._problem.points
        elastic = self._problem.materials.elastic
        energy = constitutive.linear_elastic(
            grid.elements, points.element, self._problem.gradients, points.material, elastic, rate
        )[2]
        modulus = elastic[:, 0, 0][points.material]
        strain = math.sqrt(2.0 * (energy @ points.volume) / (modulus @ points.volume))
        if strain * abs(total) <= FIRST_STRAIN:
            return total
        return math.copysign(FIRST_STRAIN / strain, total)

    def apart(self, displacement: Floats) -> Floats:
        """Remove overlap of crack faces from a displacement, by the last factorization."""
        assert self._factor is not None
        return self.closed(displacement, displacement, self._factor).displacement

    def balance(self, trial: Trial, load_factor: float, force_before: Floats) -> Balanced:
        """Newton's method, from a state with the prescribed displacement of a load factor.

        Each iteration solves K delta = f_ext - f_int (paper eq 13, sign corrected), adds the
        contact forces of overlapping faces, and does a line search along this correction. Normals
        of the faces, and the contact forces along them, turn with the faces. If the forces vanish
        in the solution, the forces before are the scale of the unbalanced force.
        """
        external = self._problem.loading.at(load_factor).force
        # The pull and the resistance of springs are large and opposite; their sum acts on the body.
        pull = load_factor * self._problem.pull
        scale = max(np.abs(force).max(initial=0.0) for force in (force_before, external))
        residuals: list[float] = []
        pressed = np.zeros(0)
        while True:
            stiffness = self.factor_at(trial)
            tangent = self._tangent(trial, pressed)
            unbalanced = external + pull - trial.resistance
            corrected = trial.displacement.copy()
            corrected[self._free] += tangent.solve(unbalanced[self._free]).x
            closed = self.closed(corrected, trial.displacement, tangent)
            pressed = closed.pressed
            left = (unbalanced + closed.force)[self._free]
            scale = max(scale, np.abs(trial.internal_force).max(initial=0.0))
            residuals.append(float(np.abs(left).max(initial=0.0) / scale) if scale > 0.0 else 0.0)
            floor = 0.0
            if residuals[-1] > RESIDUAL:
                floor = round_off(stiffness, trial.displacement[self._free], scale)
            if residuals[-1] <= max(RESIDUAL, min(floor, RESIDUAL_AT_FLOOR)):
                return Balanced(trial, closed.force, closed.pairs, tuple(residuals), floor)
            if len(residuals) > MOST_ITERATIONS:
                raise SolveError(
                    f"after {MOST_ITERATIONS} iterations the unbalanced force is "
                    f"{residuals[-1]:.1e} of the largest nodal force (allowed {RESIDUAL:.0e}; "
                    f"round-off {floor:.1e})"
                )
            trial = self._searched(trial, closed.displacement, external + pull, pressed)

    def check_jump(self, before: Trial, after: Trial) -> None:
        """SolveError if a stretch of a point has changed by more than a factor `STRETCH_JUMP`."""
        jump = stretch.largest_jump(
            before.points.displacement_gradient, after.points.displacement_gradient
        )
        if not jump <= STRETCH_JUMP:
            raise SolveError(f"a stretch of a point would jump by a factor of {jump:.2g}")

    def accept(
        self, last: Equilibrium, before: Trial, found: Balanced, load_factor: float
    ) -> Equilibrium:
        """Accept a state as the start of the next step, and return it."""
        trial = found.trial
        lost, known = self._unstable_points(trial), last.unstable_points > 0
        self._internal_variables = trial.points.internal_variables
        return Equilibrium(
            points=trial.points,
            displacement=trial.displacement,
            internal_force=trial.internal_force,
            contact_force=found.contact_force,
            contact_pairs=found.contact_pairs,
            residual_norm=found.residuals[-1],
            residual_floor=found.floor,
            solver=self._chosen.name,
            n_unknowns=self._problem.n_unknowns,
            iterations=0,
            load_factor=load_factor,
            finite=True,
            external_work=last.external_work + self._work(last, before, trial, load_factor),
            newton_iterations=last.newton_iterations + len(found.residuals) - 1,
            substeps=last.substeps + 1,
            residuals=found.residuals,
            unstable_points=lost,
            unstable_from=load_factor if lost and not known else last.unstable_from,
        )

    def _work(self, last: Equilibrium, before: Trial, after: Trial, load_factor: float) -> float:
        """Work of loads, prescribed displacements and springs in a step, trapezoidal rule [N]."""
        motion = after.displacement - before.displacement
        middle = 0.5 * (load_factor + last.load_factor)
        mean = self._problem.loading.at(middle).force + middle * self._problem.pull
        mean -= 0.5 * (before.other_resistance + after.other_resistance)
        mean[~self._free] = 0.5 * (before.internal_force + after.internal_force)[~self._free]
        return float(np.sum(mean * motion))

    def _unstable_points(self, trial: Trial) -> int:
        """Count the points that have lost ellipticity."""
        points, materials = trial.points, self._problem.materials
        lowest = acoustic.ellipticity(
            points.volume,
            points.material,
            materials.law,
            materials.constants,
            self._internal_variables,
            points.displacement_gradient,
            self._problem.patch,
        )
        return int(np.count_nonzero(~(lowest > 0.0)))

    def _solve(self, force: Floats) -> Floats:
        assert self._factor is not None
        return self._factor.solve(force).x

    def _tangent(self, trial: Trial, pressed: Floats) -> Solver:
        """Tangent of Newton's method: the stiffness with that of the contact forces."""
        assert self._factor is not None
        if not pressed.any():
            return self._factor
        faces = self._faces(trial.displacement)
        return TurningStiffness(self._factor, faces, self._problem.loading.prescribed, pressed)

    def _faces(self, displacement: Floats) -> Faces:
        problem = self._problem
        return problem.crack_faces.turned(problem.loading, displacement)

    def closed(self, displacement: Floats, shape: Floats, tangent: Solver) -> Contact:
        """Solve for contact, with the normals of a nearby shape of the body.

        Parameters
        ----------
        displacement : (n, 2) float
            Displacement without contact [mm].
        shape : (n, 2) float
            Displacement of that shape [mm].
        tangent : Solver
            The factored stiffness of the free components.
        """
        problem = self._problem
        cracks = problem.crack_faces
        if not cracks.grid.crack_faces:
            return Contact(displacement, np.zeros_like(displacement), np.zeros(0))
        total = cracks.carried + displacement
        contact = close_faces(self._faces(shape), problem.loading.prescribed, total, tangent)
        if contact.displacement is total:
            return replace(contact, displacement=displacement)
        return replace(contact, displacement=contact.displacement - cracks.carried)

    def _searched(self, trial: Trial, goal: Floats, external: Floats, pressed: Floats) -> Trial:
        """Line search from a state towards a displacement."""
        along = goal - trial.displacement

        def unbalanced(at: Trial) -> Floats:
            pushed = self._faces(at.displacement).force(pressed) if pressed.any() else 0.0
            return np.where(self._free, external + pushed - at.resistance, 0.0)

        left = unbalanced(trial)
        size, work = np.linalg.norm(left), np.vdot(left, along)
        part = 1.0
        while part >= SHORTEST:
            try:
                shorter = self.trial(trial.displacement + part * along)
            except SolveError:
                part *= 0.5
                continue
            left = unbalanced(shorter)
            smaller = np.linalg.norm(left) < size
            if smaller or abs(np.vdot(left, along)) <= LINE_SEARCH * abs(work):
                return shorter
            part *= 0.5
        raise SolveError("the line search along Newton's correction has failed")


def deform(
    problem: BoundaryValueProblem, displacement: Floats, internal_variables: Floats
) -> tuple[DeformedPoints, Floats]:
    """Return the state of the points at a displacement.

    Parameters
    ----------
    problem : BoundaryValueProblem
    displacement : (n, 2) float
        Displacement of the nodes [mm].
    internal_variables : (p, h) float
        At the start of the step.

    Returns
    -------
    points : DeformedPoints
    det_F : (p,) float
        Stress is not evaluated where it is not positive.
    """
    points, materials = problem.points, problem.materials
    *state, det_F = finite.update_points(
        problem.grid.elements,
        points.element,
        problem.gradients,
        problem.base_gradient,
        points.volume,
        points.material,
        materials.law,
        materials.constants,
        internal_variables,
        displacement,
        problem.patch,
    )
    return points.deformed(*state), det_F


def internal_force(problem: BoundaryValueProblem, points: DeformedPoints) -> Floats:
    """Sum the internal force of deformed points at every node [N/mm], (n, 2)."""
    force: Floats = finite.internal_force(
        problem.grid.elements,
        len(problem.grid.nodes),
        points.element,
        problem.gradients,
        points.volume,
        points.displacement_gradient,
        points.stress,
    )
    return force


def assemble_stiffness(
    problem: BoundaryValueProblem, trial: Trial, internal_variables: Floats
) -> csr_array:
    """Assemble the tangent stiffness of a state for the free degrees of freedom.

    Parameters
    ----------
    problem : BoundaryValueProblem
    trial : Trial
    internal_variables : (p, h) float
        At the start of the step.

    Returns
    -------
    csr_array
        Symmetric, both triangles [N/mm^2: N/mm per mm of thickness].
    """
    points, materials = trial.points, problem.materials
    summed = points.element, problem.gradients, points.volume, points.material
    laws = materials.law, materials.constants
    n_entries = len(problem.pattern[1])
    gradient, patch = points.displacement_gradient, problem.patch
    data = finite.stiffness(
        problem.slots, n_entries, *summed, *laws, internal_variables, gradient, patch
    )
    if problem.patches is not None:
        nodes = problem.patches.nodes
        bulk = patch_kernels.bulk_moduli(
            len(nodes), points.volume, points.material, *laws, gradient, patch
        )
        data += patch_kernels.coupling(
            problem.patch_slots,
            n_entries,
            nodes,
            problem.grid.elements,
            points.element,
            problem.gradients,
            points.volume,
            bulk,
            gradient,
            patch,
        )
    return problem.matrix(data, trial.displacement)
