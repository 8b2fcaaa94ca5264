"""Equilibrium at small strain: one linear solve."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from cfmpm.body.grid import Floats, Grid
from cfmpm.body.loads import Loading
from cfmpm.body.materials import Materials
from cfmpm.body.points import MaterialPoints
from cfmpm.body.volume_patches import Patches
from cfmpm.equilibrium.balance import RESIDUAL_AT_FLOOR, Equilibrium, round_off, sparsity
from cfmpm.equilibrium.contact import Contact, close_faces, faces_at_rest
from cfmpm.errors import SolveError
from cfmpm.kernels import assembly, constitutive, finite
from cfmpm.kernels import patches as patch_kernels
from cfmpm.linear import solvers

# Largest unbalanced force, relative to the nodal forces, of a solution: 1e5 times what a well posed
# scene leaves. Stiffness contrasts and slender ligaments leave more, eps |K| |u|, in any solver;
# that much is accepted, and reported, up to the second bar.
RESIDUAL = 1e-8


def assemble_stiffness(
    grid: Grid,
    points: MaterialPoints,
    gradients: Floats,
    materials: Materials,
    loading: Loading,
    patches: Patches | None = None,
) -> csr_array:
    """Sum the stiffness of the free degrees of freedom over the material points.

    Parameters
    ----------
    grid : Grid
    points : MaterialPoints
    gradients : (p, k, 2) float
        Basis gradients at the points [1/mm].
    materials : Materials
    loading : Loading
    patches : Patches, optional
        Over which the change of volume is averaged.

    Returns
    -------
    csr_array
        Symmetric, both triangles [N/mm^2: N/mm per mm of thickness].
    """
    free = loading.free
    indptr, indices = sparsity(grid, loading, patches)
    shared = points.element, gradients, points.volume, points.material
    lame = materials.lame
    own = lame if patches is None else lame * [[0.0, 1.0]]
    data = assembly.stiffness(grid.elements, free, indptr, indices, *shared, own)
    if patches is not None:
        patch = patches.of_triangle[points.element]
        bulk = np.zeros(len(patches.nodes))
        bulk[patch] = lame[points.material, 0]
        data += patch_kernels.coupling(
            finite.entry_slots(patches.nodes, free, indptr, indices),
            len(indices),
            patches.nodes,
            grid.elements,
            points.element,
            gradients,
            points.volume,
            bulk,
            np.zeros((len(points), 2, 2)),
            patch,
        )
    n = len(indptr) - 1
    return csr_array((data, indices, indptr), shape=(n, n))


def update_points(
    grid: Grid,
    points: MaterialPoints,
    gradients: Floats,
    materials: Materials,
    displacement: Floats,
    patches: Patches | None = None,
) -> None:
    """Give every point its displacement gradient, stress and energy, in place."""
    lame = materials.lame
    own = lame if patches is None else lame * [[0.0, 1.0]]
    points.displacement_gradient, points.stress, points.energy = constitutive.linear_elastic(
        grid.elements, points.element, gradients, points.material, own, displacement
    )
    if patches is not None:
        pressure, energy = patch_kernels.mean_pressure(
            points.volume,
            points.material,
            lame,
            points.displacement_gradient,
            patches.of_triangle[points.element],
        )
        points.stress[:, :2] += pressure[:, None]
        points.energy += energy


def internal_force(grid: Grid, points: MaterialPoints, gradients: Floats) -> Floats:
    """Sum the internal force of the points at every node [N/mm], (n, 2)."""
    return assembly.internal_force(
        grid.elements, len(grid.nodes), points.element, gradients, points.volume, points.stress
    )


def solve_linear(
    stiffness: csr_array,
    grid: Grid,
    points: MaterialPoints,
    gradients: Floats,
    materials: Materials,
    loading: Loading,
    solver: str = "auto",
    patches: Patches | None = None,
) -> Equilibrium:
    """Solve a linear scene in one step and update its points.

    K delta_d = f_ext - f_int (paper eq 13, sign put right), from the prescribed displacement. Where
    crack faces would overlap they are kept apart (`contact.close_faces`); the solution still grows
    in proportion to the load.

    Parameters
    ----------
    stiffness : csr_array
        From `assemble_stiffness`.
    grid : Grid
    points : MaterialPoints
        Updated in place to the state of balance.
    gradients : (p, k, 2) float
    materials : Materials
    loading : Loading
    solver : str
    patches : Patches, optional
        Those of the stiffness.

    Returns
    -------
    Equilibrium

    Raises
    ------
    SolveError
        Where the stiffness is not positive definite or the residual stays too large.
    """
    free = ~loading.prescribed
    displacement = loading.displacement.copy()
    unbalanced = loading.force
    if displacement.any():
        update_points(grid, points, gradients, materials, displacement, patches)
        unbalanced = loading.force - internal_force(grid, points, gradients)
    chosen = solvers.select(stiffness.shape[0], solver)
    modes = solvers.rigid_body_modes(grid.nodes, free) if chosen.name == "amg" else None
    factor = chosen.factor(stiffness, modes)
    solution = factor.solve(unbalanced[free])
    displacement[free] += solution.x
    apart = displacement
    if grid.crack_faces:
        faces = faces_at_rest(grid, loading.prescribed)
        contact = close_faces(faces, loading.prescribed, apart, factor)
    else:
        contact = Contact(apart, np.zeros_like(apart), np.zeros(0))
    displacement = loading.at_rest(contact.displacement)
    update_points(grid, points, gradients, materials, displacement, patches)
    force = internal_force(grid, points, gradients)
    # A rigid motion ends without force: what had to be balanced on the way sets the scale.
    scale = max(np.abs(force).max(initial=0.0), np.abs(unbalanced).max(initial=0.0))
    residual = np.abs((loading.force + contact.force - force)[free]).max(initial=0.0)
    residual_norm = float(residual / scale) if scale > 0.0 else 0.0
    residual_floor = 0.0
    if not residual_norm <= RESIDUAL:
        # A part that only contact holds has moved far before its faces closed.
        moved = np.maximum(np.abs(apart), np.abs(displacement))
        residual_floor = round_off(stiffness, moved[free], scale)
        if not residual_norm <= min(residual_floor, RESIDUAL_AT_FLOOR):
            raise SolveError(
                f"the linear solution by {chosen.name} leaves an unbalanced force of "
                f"{residual_norm:.1e} of the largest nodal force (allowed {RESIDUAL:.0e}; "
                f"round-off explains {residual_floor:.1e}); try another solver, and look for a "
                "part that hangs by a single node or a sliver, or for an extreme contrast of "
                "stiffness"
            )
    return Equilibrium(
        displacement=displacement,
        internal_force=force,
        contact_force=contact.force,
        contact_pairs=contact.pairs,
        residual_norm=residual_norm,
        residual_floor=residual_floor,
        solver=chosen.name,
        n_unknowns=stiffness.shape[0],
        negative_pivots=factor.negative_pivots,
        iterations=solution.iterations,
    )
