"""Newton's method at finite deformation, and which states may be accepted."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

from cfmpm.body.grid import Floats, Grid, Ints
from cfmpm.body.loads import Loading
from cfmpm.body.materials import Materials
from cfmpm.body.points import MaterialPoints
from cfmpm.body.springs import Springs
from cfmpm.body.volume_patches import Patches, patch_of
from cfmpm.equilibrium.balance import RESIDUAL_AT_FLOOR, Equilibrium, round_off, sparsity
from cfmpm.equilibrium.contact import (
    Contact,
    Faces,
    Solver,
    TurningStiffness,
    close_faces,
    turned_faces,
)
from cfmpm.errors import SolveError
from cfmpm.kernels import acoustic, constitutive, finite, stretch
from cfmpm.kernels import patches as patch_kernels
from cfmpm.linear import solvers
from cfmpm.linear.solvers import Factor

# Largest unbalanced force relative to the nodal forces, where round-off does not leave more.
RESIDUAL = 1e-9
# Strain of a linear body (root mean square, weighted with its stiffness) in the first step.
FIRST_STRAIN = 0.01
# Iterations after which a step is halved.
MOST_ITERATIONS = 15
# What a step may multiply the largest stretch by, or the smallest inverted: Newton's method can
# jump over a limit point to a torn state, which is in balance too.
STRETCH_JUMP = 1.5
# A correction is halved until the unbalanced force falls, or its work along the correction falls to
# this part; not below this length.
LINE_SEARCH, SHORTEST = 0.8, 1.0 / 128.0
# Displacement, relative to the smallest triangle, by which prescribed motion is felt out: as much
# as the second order that it leaves in a prediction.
PROBE = 1e-6


@dataclass(frozen=True)
class Problem:
    """What stays as it is while the loads change.

    Attributes
    ----------
    grid : Grid
    points : MaterialPoints
        What is summed over; updated in place to each state that is accepted.
    gradients : (p, k, 2) float
        Basis gradients with respect to the reference configuration [1/mm].
    base : (p, 2, 2) float
        Displacement gradient of the points before the grid moves.
    materials : Materials
    loading : Loading
    solver : str
    patches : Patches or None
        Over which the volume ratio is averaged.
    faces : Grid or None
        With the crack faces as they were closed, where `grid` has moved since.
    carried : (n, 2) float or 0
        By which its nodes have [mm].
    springs : Springs or None
        On the grid besides the material.
    """

    grid: Grid
    points: MaterialPoints
    gradients: Floats
    base: Floats
    materials: Materials
    loading: Loading
    solver: str = "auto"
    patches: Patches | None = None
    faces: Grid | None = None
    carried: Floats | float = 0.0
    springs: Springs | None = None

    @cached_property
    def pattern(self) -> tuple[Ints, Ints]:
        """Row pointers and columns of the stiffness of the free degrees of freedom."""
        material = sparsity(self.grid, self.loading, self.patches)
        return material if self.springs is None else self.springs.united(material, self.free)

    @cached_property
    def spring_entries(self) -> Floats | float:
        """What the springs add to the entries of the stiffness [N/mm^2]."""
        return 0.0 if self.springs is None else self.springs.entries(self.pattern, self.free)

    @cached_property
    def free(self) -> Ints:
        """Rows of the free degrees of freedom among those of the displacement."""
        return np.flatnonzero(~self.loading.prescribed)

    @property
    def pull(self) -> Floats | float:
        """Force of the springs per load factor [N/mm]."""
        return 0.0 if self.springs is None else self.springs.pull

    @cached_property
    def patch(self) -> Ints:
        """Patch of each point; empty where there are none."""
        return patch_of(self.patches, self.points)

    @cached_property
    def slots(self) -> Ints:
        """Where the entries of each element go in the stiffness."""
        slots: Ints = finite.entry_slots(self.grid.elements, self.loading.free, *self.pattern)
        return slots

    @cached_property
    def patch_slots(self) -> Ints:
        """Where the entries of each patch go in the stiffness."""
        assert self.patches is not None
        slots: Ints = finite.entry_slots(self.patches.nodes, self.loading.free, *self.pattern)
        return slots


@dataclass(frozen=True)
class PointStates:
    """What a displacement of the grid does to the points, balanced or not."""

    displacement: Floats
    displacement_gradient: Floats
    stress: Floats
    energy: Floats
    history: Floats
    internal_force: Floats
    spring_force: Floats | float

    @property
    def resistance(self) -> Floats:
        """Force of material and springs against the displacement [N/mm], (n, 2)."""
        return self.internal_force + self.spring_force


@dataclass(frozen=True)
class Balanced:
    """Where Newton's method ended."""

    state: PointStates
    contact_force: Floats
    contact_pairs: int
    residuals: tuple[float, ...]
    floor: float


class March:
    """Goes from one stable state of a problem to the next.

    Parameters
    ----------
    problem : Problem
    history : (p, h) float
        Of the last accepted state.
    """

    def __init__(self, problem: Problem, history: Floats) -> None:
        self._problem = problem
        self._history = history
        self._free = ~problem.loading.prescribed
        n_free = int(np.count_nonzero(self._free))
        self._chosen = solvers.select(n_free, problem.solver)
        self._factor: Factor | None = None

    def state(self, displacement: Floats) -> PointStates:
        """Evaluate the points; SolveError where one is turned inside out."""
        grid, points, materials = self._problem.grid, self._problem.points, self._problem.materials
        gradient, stress, energy, history, det_F = finite.update_points(
            grid.elements,
            points.element,
            self._problem.gradients,
            self._problem.base,
            points.volume,
            points.material,
            materials.law,
            materials.constants,
            self._history,
            displacement,
            self._problem.patch,
        )
        if not det_F.min() > 0.0:
            raise SolveError(
                f"{int((~(det_F > 0.0)).sum())} material points would be turned inside out"
            )
        force = finite.internal_force(
            grid.elements,
            len(grid.nodes),
            points.element,
            self._problem.gradients,
            points.volume,
            gradient,
            stress,
        )
        springs = self._problem.springs
        spring_force = 0.0 if springs is None else springs.resistance(displacement)
        return PointStates(displacement, gradient, stress, energy, history, force, spring_force)

    def factor_at(self, state: PointStates) -> csr_array:
        """Factor the stiffness of a state; SolveError where it is not positive definite."""
        points, materials = self._problem.points, self._problem.materials
        indptr, indices = self._problem.pattern
        data = finite.stiffness(
            self._problem.slots,
            len(indices),
            points.element,
            self._problem.gradients,
            points.volume,
            points.material,
            materials.law,
            materials.constants,
            self._history,
            state.displacement_gradient,
            self._problem.patch,
        )
        if self._problem.patches is not None:
            bulk = patch_kernels.bulk_moduli(
                len(self._problem.patches.nodes),
                points.volume,
                points.material,
                materials.law,
                materials.constants,
                state.displacement_gradient,
                self._problem.patch,
            )
            data += patch_kernels.coupling(
                self._problem.patch_slots,
                len(indices),
                self._problem.patches.nodes,
                self._problem.grid.elements,
                points.element,
                self._problem.gradients,
                points.volume,
                bulk,
                state.displacement_gradient,
                self._problem.patch,
            )
        data = data + self._problem.spring_entries
        stiffness = csr_array((data, indices, indptr), shape=(len(indptr) - 1,) * 2)
        if self._factor is None:
            grid, chosen = self._problem.grid, self._chosen
            modes = (
                solvers.rigid_body_modes(grid.nodes, self._free) if chosen.name == "amg" else None
            )
            self._factor = chosen.factor(stiffness, modes)
        else:
            self._factor.refactor(stiffness)
        return stiffness

    def rate(self, state: PointStates) -> Floats:
        """Return the displacement per load factor, from the stiffness factored last."""
        loading = self._problem.loading
        rate = loading.displacement.copy()
        unbalanced = loading.force + self._problem.pull
        reach = np.abs(rate).max(initial=0.0)
        if reach > 0.0:
            step = PROBE * np.sqrt(self._problem.grid.areas.min()) / reach
            probed = self.state(state.displacement + step * rate)
            unbalanced = unbalanced - (probed.resistance - state.resistance) / step
        rate[self._free] += self._solve(unbalanced[self._free])
        return rate

    def first_step(self, rate: Floats, total: float) -> float:
        """Return the change of load factor that strains the body by `FIRST_STRAIN`."""
        grid, points = self._problem.grid, self._problem.points
        lame = self._problem.materials.lame
        energy = constitutive.linear_elastic(
            grid.elements, points.element, self._problem.gradients, points.material, lame, rate
        )[2]
        modulus = (lame[:, 0] + 2.0 * lame[:, 1])[points.material]
        strain = math.sqrt(2.0 * np.sum(energy * points.volume) / np.sum(modulus * points.volume))
        if strain * abs(total) <= FIRST_STRAIN:
            return total
        return math.copysign(FIRST_STRAIN / strain, total)

    def apart(self, displacement: Floats) -> Floats:
        """Keep the crack faces of a displacement apart, by the stiffness factored last."""
        assert self._factor is not None
        return self._closed(displacement, displacement, self._factor).displacement

    def balance(self, state: PointStates, load_factor: float, force_before: Floats) -> Balanced:
        """Newton's method, from a state with the prescribed displacement of a load factor.

        Each iteration solves K delta = f_ext - f_int (paper eq 13, sign put right), presses
        overlapping faces apart, and goes along that correction as far as it helps. Normals turn
        with the faces, and forces along them with the normals. Where it ends without force, the
        forces before set the scale of what is unbalanced.
        """
        external = load_factor * self._problem.loading.force
        # Of large and opposite forces: what springs leave of them, the material feels.
        pull = load_factor * self._problem.pull
        scale = max(np.abs(force).max(initial=0.0) for force in (force_before, external))
        residuals: list[float] = []
        pressed = np.zeros(0)
        while True:
            stiffness = self.factor_at(state)
            tangent = self._tangent(state, pressed)
            unbalanced = external + pull - state.resistance
            corrected = state.displacement.copy()
            corrected[self._free] += tangent.solve(unbalanced[self._free]).x
            closed = self._closed(corrected, state.displacement, tangent)
            pressed = closed.pressed
            left = (unbalanced + closed.force)[self._free]
            scale = max(scale, np.abs(state.internal_force).max(initial=0.0))
            residuals.append(float(np.abs(left).max(initial=0.0) / scale) if scale > 0.0 else 0.0)
            floor = 0.0
            if residuals[-1] > RESIDUAL:
                floor = round_off(stiffness, state.displacement[self._free], scale)
            if residuals[-1] <= max(RESIDUAL, min(floor, RESIDUAL_AT_FLOOR)):
                return Balanced(state, closed.force, closed.pairs, tuple(residuals), floor)
            if len(residuals) > MOST_ITERATIONS:
                raise SolveError(
                    f"after {MOST_ITERATIONS} iterations {residuals[-1]:.1e} of the largest nodal "
                    f"force is still unbalanced (allowed {RESIDUAL:.0e}; round-off explains "
                    f"{floor:.1e})"
                )
            state = self._searched(state, closed.displacement, external + pull, pressed)

    def check_jump(self, before: PointStates, after: PointStates) -> None:
        """SolveError where the stretch of a point has grown by more than `STRETCH_JUMP`."""
        jump = stretch.largest_jump(before.displacement_gradient, after.displacement_gradient)
        if not jump <= STRETCH_JUMP:
            raise SolveError(f"the stretch of a point would jump to {jump:.2g} times what it was")

    def accept(
        self, last: Equilibrium, before: PointStates, found: Balanced, load_factor: float
    ) -> Equilibrium:
        """Give a state to the points, and describe it."""
        points, state = self._problem.points, found.state
        points.displacement_gradient = state.displacement_gradient
        points.stress, points.energy = state.stress, state.energy
        lost, known = self._unstable_points(state), last.unstable_points > 0
        self._history = state.history
        return Equilibrium(
            displacement=state.displacement,
            internal_force=state.internal_force,
            contact_force=found.contact_force,
            contact_pairs=found.contact_pairs,
            residual_norm=found.residuals[-1],
            residual_floor=found.floor,
            solver=self._chosen.name,
            n_unknowns=int(np.count_nonzero(self._free)),
            negative_pivots=0.0 if self._factor is None else self._factor.negative_pivots,
            iterations=0,
            load_factor=load_factor,
            finite=True,
            external_work=last.external_work + self._work(last, before, state, load_factor),
            history=state.history,
            newton_iterations=last.newton_iterations + len(found.residuals) - 1,
            substeps=last.substeps + 1,
            residuals=found.residuals,
            unstable_points=lost,
            unstable_from=load_factor if lost and not known else last.unstable_from,
        )

    def _work(
        self, last: Equilibrium, before: PointStates, after: PointStates, load_factor: float
    ) -> float:
        """Work of loads, grips and springs over a step, by the trapezoidal rule [N]."""
        motion = after.displacement - before.displacement
        applied = self._problem.loading.force + self._problem.pull
        mean = 0.5 * (load_factor + last.load_factor) * applied
        mean -= 0.5 * (before.spring_force + after.spring_force)
        mean[~self._free] = 0.5 * (before.internal_force + after.internal_force)[~self._free]
        return float(np.sum(mean * motion))

    def _unstable_points(self, state: PointStates) -> int:
        """Count the points that have lost ellipticity."""
        points, materials = self._problem.points, self._problem.materials
        lowest = acoustic.ellipticity(
            points.volume,
            points.material,
            materials.law,
            materials.constants,
            self._history,
            state.displacement_gradient,
            self._problem.patch,
        )
        return int(np.count_nonzero(~(lowest > 0.0)))

    def _solve(self, force: Floats) -> Floats:
        assert self._factor is not None
        return self._factor.solve(force).x

    def _tangent(self, state: PointStates, pressed: Floats) -> Solver:
        """What Newton's method solves with: the stiffness, and that of the forces of faces."""
        assert self._factor is not None
        if not pressed.any():
            return self._factor
        faces = self._faces(state.displacement)
        return TurningStiffness(self._factor, faces, self._problem.loading.prescribed, pressed)

    def _faces(self, displacement: Floats) -> Faces:
        problem = self._problem
        grid, shape = problem.faces or problem.grid, problem.carried + displacement
        return turned_faces(grid, problem.loading.prescribed, shape)

    def _closed(self, displacement: Floats, shape: Floats, tangent: Solver) -> Contact:
        """Press faces apart in a shape of the body near by."""
        problem = self._problem
        if not (problem.faces or problem.grid).crack_faces:
            return Contact(displacement, np.zeros_like(displacement), np.zeros(0))
        total = problem.carried + displacement
        contact = close_faces(self._faces(shape), problem.loading.prescribed, total, tangent)
        if contact.displacement is total:
            return replace(contact, displacement=displacement)
        return replace(contact, displacement=contact.displacement - problem.carried)

    def _searched(
        self, state: PointStates, goal: Floats, external: Floats, pressed: Floats
    ) -> PointStates:
        """Go towards a displacement as far as it helps."""
        along = goal - state.displacement

        def unbalanced(at: PointStates) -> Floats:
            pushed = self._faces(at.displacement).force(pressed) if pressed.any() else 0.0
            return np.where(self._free, external + pushed - at.resistance, 0.0)

        left = unbalanced(state)
        size, work = float(np.sqrt(np.sum(left * left))), float(np.sum(left * along))
        part = 1.0
        while part >= SHORTEST:
            try:
                trial = self.state(state.displacement + part * along)
            except SolveError:
                part *= 0.5
                continue
            left = unbalanced(trial)
            smaller = np.sqrt(np.sum(left * left)) < size
            if smaller or abs(np.sum(left * along)) <= LINE_SEARCH * abs(work):
                return trial
            part *= 0.5
        raise SolveError("no part of Newton's correction brings the body nearer to balance")
