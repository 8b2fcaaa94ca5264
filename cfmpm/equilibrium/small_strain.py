"""Equilibrium at small strain: one linear solve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array

from cfmpm.body.grid import Floats
from cfmpm.body.points import DeformedPoints
from cfmpm.equilibrium.balance import RESIDUAL_AT_FLOOR, Equilibrium, Parts, round_off
from cfmpm.equilibrium.contact import Contact, CrackFaces, close_faces
from cfmpm.equilibrium.problem import BoundaryValueProblem
from cfmpm.errors import SolveError
from cfmpm.kernels import assembly, constitutive
from cfmpm.kernels import patches as patch_kernels
from cfmpm.linear import solvers
from cfmpm.linear.solvers import Factor

# Largest accepted unbalanced force relative to the nodal forces: 1e5 times that of a well posed
# scene. With a large contrast of stiffness or slender ligaments round-off, eps |K| |u|, is larger
# for any solver; it is accepted and reported up to RESIDUAL_AT_FLOOR.
RESIDUAL = 1e-8
# Above this the solution is corrected once by what it leaves: so reactions balance the loads in a
# body that is soft beside its stiffness, as on a last ligament, as well as in others.
CORRECTED = 1e-12


def assemble_stiffness(problem: BoundaryValueProblem) -> csr_array:
    """Assemble the stiffness of the free degrees of freedom over the material points.

    Parameters
    ----------
    problem : BoundaryValueProblem

    Returns
    -------
    csr_array
        Symmetric, both triangles [N/mm^2: N/mm per mm of thickness].
    """
    grid, points, patches = problem.grid, problem.points, problem.patches
    indptr, indices = problem.pattern
    shared = points.element, problem.gradients, points.volume, points.material
    free = problem.loading.free
    data = assembly.stiffness(grid.elements, free, indptr, indices, *shared, _own(problem))
    if patches is not None:
        bulk = np.zeros(len(patches.nodes))
        # That of its largest point: pieces of particle domains beyond the interface of two
        # materials have the size of round-off.
        order = np.argsort(points.volume, kind="stable")
        bulk[problem.patch[order]] = problem.materials.volumetric[points.material[order]]
        data += patch_kernels.coupling(
            problem.patch_slots,
            len(indices),
            patches.nodes,
            grid.elements,
            points.element,
            problem.gradients,
            points.volume,
            bulk,
            np.zeros((len(points), 2, 2)),
            problem.patch,
        )
    return problem.matrix(data, np.zeros_like(grid.nodes))


def deform(problem: BoundaryValueProblem, displacement: Floats) -> DeformedPoints:
    """Return the points with displacement gradient, stress and energy at a displacement."""
    points = problem.points
    gradient, stress, energy = constitutive.linear_elastic(
        problem.grid.elements,
        points.element,
        problem.gradients,
        points.material,
        _own(problem),
        displacement,
    )
    if problem.patches is not None:
        pressure, shared = patch_kernels.mean_pressure(
            points.volume, points.material, problem.materials.volumetric, gradient, problem.patch
        )
        stress[:, :2] += pressure[:, None]
        energy += shared
    return points.deformed(gradient, stress, energy)


def internal_force(problem: BoundaryValueProblem, points: DeformedPoints) -> Floats:
    """Sum the internal force of deformed points at every node [N/mm], (n, 2)."""
    force: Floats = assembly.internal_force(
        problem.grid.elements,
        len(problem.grid.nodes),
        points.element,
        problem.gradients,
        points.volume,
        points.stress,
    )
    return force


def factored(problem: BoundaryValueProblem, stiffness: csr_array) -> Factor:
    """Factor the stiffness by the solver of a problem.

    Raises
    ------
    SolveError
        If it is not positive definite.
    """
    chosen = solvers.select(stiffness.shape[0], problem.solver)
    free = ~problem.loading.prescribed
    modes = None if chosen.direct else solvers.rigid_body_modes(problem.grid.nodes, free)
    return chosen.factor(stiffness, modes)


def solve_linear(
    problem: BoundaryValueProblem,
    stiffness: csr_array,
    load_factor: float = 1.0,
    factor: Factor | None = None,
) -> Equilibrium:
    """Solve a linear problem in one step.

    K delta_d = f_ext - f_int (paper eq 13, sign corrected), from the prescribed displacement. Crack
    faces that would overlap are in contact (`contact.close_faces`); under proportional loads the
    solution is still proportional to the load.

    Parameters
    ----------
    problem : BoundaryValueProblem
    stiffness : csr_array
        From `assemble_stiffness`.
    load_factor : float
    factor : Factor, optional
        From `factored`, where it is needed afterwards.

    Returns
    -------
    Equilibrium
        At the load factor; with its parts if some loads are fixed.

    Raises
    ------
    SolveError
        If the stiffness is not positive definite, or the residual is too large.
    """
    factor = factor or factored(problem, stiffness)
    state = _balance(problem, stiffness, factor, load_factor)
    if not problem.loading.is_proportional:
        state = replace(state, parts=_parts(problem, stiffness, factor))
    return state


def _balance(
    problem: BoundaryValueProblem, stiffness: csr_array, factor: Factor, load_factor: float
) -> Equilibrium:
    """Solve with the factored stiffness."""
    free = ~problem.loading.prescribed
    loads = problem.loading.at(load_factor)
    external = loads.force + load_factor * problem.pull
    displacement = loads.displacement
    unbalanced = external
    if displacement.any():
        held = deform(problem, displacement)
        unbalanced = external - internal_force(problem, held) - problem.resistance(displacement)
    solution = factor.solve(unbalanced[free])
    displacement[free] += solution.x
    contact = _closed(problem, displacement, factor)
    acting, moved = external + contact.force, contact.displacement
    for correct in (True, False):
        at_rest = problem.loading.at_rest(moved)
        points = deform(problem, at_rest)
        force = internal_force(problem, points)
        # A rigid motion has no internal force: the right-hand side is then the scale.
        scale = max(np.abs(force).max(initial=0.0), np.abs(unbalanced).max(initial=0.0))
        left = (acting - force - problem.resistance(at_rest))[free]
        residual = np.abs(left).max(initial=0.0)
        # A solver that misses by more is not believed, but told. An iterative one has a tolerance
        # of its own.
        felt = CORRECTED * np.abs(force).max(initial=0.0)
        if not (correct and factor.direct and felt < residual <= RESIDUAL * scale):
            break
        moved = moved.copy()
        moved[free] += factor.solve(left).x
    residual_norm = float(residual / scale) if scale > 0.0 else 0.0
    residual_floor = 0.0
    if not residual_norm <= RESIDUAL:
        # A part that is held by contact only has a large displacement before its faces close.
        moved = np.maximum(np.abs(displacement), np.abs(at_rest))
        residual_floor = round_off(stiffness, moved[free], scale)
        _require_balance(residual_norm, residual_floor, factor.name)
    return Equilibrium(
        points=points,
        displacement=at_rest,
        internal_force=force,
        contact_force=contact.force,
        contact_pairs=contact.pairs,
        residual_norm=residual_norm,
        residual_floor=residual_floor,
        solver=factor.name,
        n_unknowns=stiffness.shape[0],
        iterations=solution.iterations,
        load_factor=load_factor,
    )


def _parts(problem: BoundaryValueProblem, stiffness: csr_array, factor: Factor) -> Parts:
    """Solve for the fixed and the proportional part alone, and for both, without contact."""
    grid, loading = problem.grid, problem.loading
    problem = replace(problem, faces=CrackFaces(replace(grid, crack_faces={})))
    alone = replace(problem, loading=loading.proportional_alone())
    fixed = _balance(problem, stiffness, factor, 0.0)
    proportional = _balance(alone, stiffness, factor, 1.0)
    sizes = [np.abs(part.displacement).max(initial=0.0) for part in (fixed, proportional)]
    felt = float(sizes[0] / sizes[1]) if min(sizes) > 0.0 else 1.0
    return Parts(fixed, proportional, _balance(problem, stiffness, factor, felt))


def _own(problem: BoundaryValueProblem) -> Floats:
    """Elastic matrices of the points, without the volumetric part that patches share."""
    materials = problem.materials
    return materials.elastic if problem.patches is None else materials.unshared


def _closed(problem: BoundaryValueProblem, displacement: Floats, factor: Factor) -> Contact:
    """Solve for contact of crack faces."""
    if not problem.crack_faces.grid.crack_faces:
        return Contact(displacement, np.zeros_like(displacement), np.zeros(0))
    prescribed = problem.loading.prescribed
    faces = problem.crack_faces.at_rest(problem.loading)
    return close_faces(faces, prescribed, displacement, factor)


def _require_balance(residual_norm: float, residual_floor: float, solver: str) -> None:
    """SolveError if the unbalanced force is larger than round-off."""
    if not residual_norm <= min(residual_floor, RESIDUAL_AT_FLOOR):
        raise SolveError(
            f"the unbalanced force of the linear solution by {solver} is "
            f"{residual_norm:.1e} of the largest nodal force (allowed {RESIDUAL:.0e}; "
            f"round-off {residual_floor:.1e}); try another solver, and check the scene for a "
            "part that is attached at a single node or by a sliver, or for an extreme contrast "
            "of stiffness"
        )
