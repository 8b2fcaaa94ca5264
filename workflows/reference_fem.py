"""An independent reference: linear FEM of a plate under tension, by scikit-fem.

Nothing of cfmpm's kernels is used: basis, quadrature, loads, supports, stress, configurational
force and J are scikit-fem's or written here. Only the triangulation is given.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from skfem import (
    Basis,
    ElementTriP1,
    ElementTriP2,
    ElementVector,
    FacetBasis,
    Functional,
    LinearForm,
    MeshTri,
    condense,
)
from skfem.helpers import ddot, eye, grad, mul, trace, transpose
from skfem.models.elasticity import lame_parameters, linear_elasticity

from cfmpm.grid import Floats, Grid, Ints
from cfmpm.scene import Scene


@dataclass(frozen=True)
class Plate:
    """A rectangle in plane strain under tension on its top and bottom.

    Attributes
    ----------
    nodes : (n, 2) float
        Corner nodes [mm], doubled along the crack.
    triangles : (m, 3) int
    E, nu : float
        Young's modulus [MPa] and Poisson's ratio.
    traction : float
        [MPa].
    """

    nodes: Floats
    triangles: Ints
    E: float
    nu: float
    traction: float


@dataclass(frozen=True)
class System:
    """The assembled equations of a plate."""

    plate: Plate
    basis: Basis
    stiffness: Any
    load: Floats
    held: Ints


@dataclass(frozen=True)
class Solution:
    """A solved plate.

    Attributes
    ----------
    plate : Plate
    basis : skfem.Basis
    displacement : (n_dofs,) float
        [mm].
    energy : float
        Strain energy [N mm/mm].
    """

    plate: Plate
    basis: Basis
    displacement: Floats
    energy: float


def plate_of(scene: Scene, grid: Grid) -> Plate:
    """Take the corners of a grid and the numbers of a scene of one edge crack under tension."""
    tension = [load.traction[1] for load in scene.loads if load.traction is not None]
    return Plate(
        nodes=grid.nodes[: grid.n_corners],
        triangles=grid.triangles,
        E=scene.material.E,
        nu=scene.material.nu,
        traction=max(tension),
    )


def assemble(plate: Plate, degree: int) -> System:
    """Assemble the stiffness and the load of a plate.

    Parameters
    ----------
    plate : Plate
    degree : {1, 2}
        Of the basis; quadrature is exact for the stiffness.
    """
    corners, triangles = (np.ascontiguousarray(a.T) for a in (plate.nodes, plate.triangles))
    mesh = MeshTri(corners, triangles, sort_t=False)
    element = ElementVector(ElementTriP1() if degree == 1 else ElementTriP2())
    basis = Basis(mesh, element, intorder=2 * (degree - 1))
    stiffness = linear_elasticity(*lame_parameters(plate.E, plate.nu)).assemble(basis)

    low, high = plate.nodes[:, 1].min(), plate.nodes[:, 1].max()
    load = np.zeros(basis.N)
    for level, pull in ((low, -plate.traction), (high, plate.traction)):
        side = mesh.facets_satisfying(lambda x, y=level: np.isclose(x[1], y), boundaries_only=True)
        tension = LinearForm(lambda v, w, t=pull: t * v[1])
        load += tension.assemble(FacetBasis(mesh, element, facets=side))

    # Two bottom corners hold the three rigid motions; the load is in balance without them.
    left, right = (
        int(np.flatnonzero(np.isclose(plate.nodes, (x, low)).all(axis=1))[0])
        for x in (plate.nodes[:, 0].min(), plate.nodes[:, 0].max())
    )
    held = np.array([*basis.nodal_dofs[:, left], basis.nodal_dofs[1, right]])
    return System(plate, basis, stiffness, load, held)


def solve(system: System, solver: Callable[[Any, Floats], Floats]) -> Solution:
    """Solve the equations by ``solver(matrix, right hand side)``."""
    matrix, load, u, free = condense(system.stiffness, system.load, D=system.held)
    u = u.copy()
    u[free] = solver(matrix, load)
    return Solution(system.plate, system.basis, u, 0.5 * float(u @ (system.stiffness @ u)))


def nodal_force(solution: Solution) -> tuple[Floats, Floats]:
    """Return where the nodes are [mm], corners first, and their configurational force [N/mm]."""
    basis = solution.basis
    force = LinearForm(
        lambda v, w: -ddot(_eshelby(solution.plate, grad(w["u"])), grad(v))
    ).assemble(basis, u=basis.interpolate(solution.displacement))
    x, y = basis.split_indices()
    return basis.doflocs[:, x].T, np.column_stack([force[x], force[y]])


def j_integral(solution: Solution, tip: Floats, radius: float) -> float:
    """Return J along x [N/mm] in a ring from half the radius to the radius [mm]."""
    basis = solution.basis
    scalar = basis.with_element(ElementTriP1())
    distance = np.hypot(*(scalar.doflocs - tip[:, None]))
    q = np.clip(2.0 - 2.0 * distance / radius, 0.0, 1.0)

    def density(w: Any) -> Any:
        return -(_eshelby(solution.plate, grad(w["u"]))[0] * grad(w["q"])).sum(axis=0)

    fields = {"u": basis.interpolate(solution.displacement), "q": scalar.interpolate(q)}
    return float(Functional(density).assemble(basis, **fields))


def _eshelby(plate: Plate, H: Any) -> Any:
    """Energy-momentum W 1 - H^T sigma of linear elasticity in plane strain."""
    lam, mu = lame_parameters(plate.E, plate.nu)
    strain = 0.5 * (H + transpose(H))
    stress = lam * eye(trace(strain), 2) + 2.0 * mu * strain
    return eye(0.5 * ddot(stress, strain), 2) - mul(transpose(H), stress)
