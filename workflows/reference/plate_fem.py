"""An independent reference: linear FEM of a plate with an edge crack, by scikit-fem.

Nothing of cfmpm's kernels is used: basis, quadrature, loads, supports, stress, configurational
force, J, K_I and K_II are scikit-fem's or written here. Only the triangulation is given.
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

from cfmpm.body.grid import Floats, Grid, Ints
from cfmpm.scene import Scene


@dataclass(frozen=True)
class Plate:
    """A rectangle in plane strain, loaded on its top and bottom.

    Attributes
    ----------
    nodes : (n, 2) float
        Corner nodes [mm], doubled along the crack.
    triangles : (m, 3) int
    E, nu : float
        Young's modulus [MPa] and Poisson's ratio.
    top, bottom : (float, float) or None
        Tractions [MPa]; None where the edge is clamped.
    """

    nodes: Floats
    triangles: Ints
    E: float
    nu: float
    top: tuple[float, float] | None
    bottom: tuple[float, float] | None

    def release_rate(self, K_I: float, K_II: float) -> float:
        """G of stress intensity factors by Irwin's formula [N/mm]."""
        return (K_I**2 + K_II**2) * (1.0 - self.nu**2) / self.E


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
    """Take the corners of a grid and the numbers of a scene of one edge crack."""
    loads = {load.edge: load for load in scene.loads if load.edge in ("top", "bottom")}
    return Plate(
        nodes=grid.nodes[: grid.n_corners],
        triangles=grid.triangles,
        E=scene.material.E,
        nu=scene.material.nu,
        top=loads["top"].traction,
        bottom=loads["bottom"].traction,
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
    load, held = np.zeros(basis.N), np.empty(0, np.int64)
    for level, pull in ((low, plate.bottom), (high, plate.top)):
        side = mesh.facets_satisfying(lambda x, y=level: np.isclose(x[1], y), boundaries_only=True)
        if pull is None:
            held = np.append(held, basis.get_dofs(side).flatten())
        else:
            traction = LinearForm(lambda v, w, t=pull: t[0] * v[0] + t[1] * v[1])
            load += traction.assemble(FacetBasis(mesh, element, facets=side))
    if not held.size:
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


def intensity_factors(solution: Solution, tip: Floats, radius: float) -> tuple[float, float]:
    """Return K_I and K_II [MPa mm^0.5] of a crack along x, in the ring of `j_integral`.

    Interaction integral with Williams' fields of one mode each (Yau, Wang and Corten 1980).
    """
    basis, plate = solution.basis, solution.plate
    scalar = basis.with_element(ElementTriP1())
    distance = np.hypot(*(scalar.doflocs - tip[:, None]))
    q = np.clip(2.0 - 2.0 * distance / radius, 0.0, 1.0)
    fields = {"u": basis.interpolate(solution.displacement), "q": scalar.interpolate(q)}
    found = []
    for mode in (1, 2):

        def density(w: Any, mode: int = mode) -> Any:
            H, A = grad(w["u"]), _williams(plate, mode, w.x - tip[:, None, None])
            work = ddot(_stress(plate, H), A)
            mixed = mul(transpose(H), _stress(plate, A)) + mul(transpose(A), _stress(plate, H))
            return ((mixed - eye(work, 2))[0] * grad(w["q"])).sum(axis=0)

        mixed = float(Functional(density).assemble(basis, **fields))
        found.append(0.5 * mixed * plate.E / (1.0 - plate.nu**2))
    return found[0], found[1]


def _williams(plate: Plate, mode: int, x: Floats) -> Any:
    """Displacement gradient of the singular field of K = 1 in one mode, at places from the tip."""
    r, angle = np.hypot(x[0], x[1]), np.arctan2(x[1], x[0])
    mu = 0.5 * plate.E / (1.0 + plate.nu)
    kappa = 3.0 - 4.0 * plate.nu
    c, s, cos, sin = np.cos(angle / 2), np.sin(angle / 2), np.cos(angle), np.sin(angle)
    if mode == 1:
        f = np.array([c * (kappa - cos), s * (kappa - cos)])
        df = np.array([c * sin - s * (kappa - cos) / 2, s * sin + c * (kappa - cos) / 2])
    else:
        f = np.array([s * (kappa + 2 + cos), -c * (kappa - 2 + cos)])
        df = np.array([c * (kappa + 2 + cos) / 2 - s * sin, s * (kappa - 2 + cos) / 2 + c * sin])
    # u = sqrt(r / (2 pi)) f / (2 mu): its derivatives along r and around the tip.
    scale = 1.0 / (2.0 * mu * np.sqrt(2.0 * np.pi * r))
    along, around = 0.5 * scale * f, scale * df
    return np.array([along * cos - around * sin, along * sin + around * cos]).swapaxes(0, 1)


def _stress(plate: Plate, H: Any) -> Any:
    """Stress of a displacement gradient in plane strain [MPa]."""
    lam, mu = lame_parameters(plate.E, plate.nu)
    strain = 0.5 * (H + transpose(H))
    return lam * eye(trace(strain), 2) + 2.0 * mu * strain


def _eshelby(plate: Plate, H: Any) -> Any:
    """Energy-momentum W 1 - H^T sigma of linear elasticity in plane strain."""
    stress = _stress(plate, H)
    return eye(0.5 * ddot(stress, H), 2) - mul(transpose(H), stress)
