"""The boundary value problem of small strain and of finite deformation."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from scipy.sparse import csr_array

from cfmpm.body.grid import Floats, Grid, Ints
from cfmpm.body.loads import Loading
from cfmpm.body.materials import Materials
from cfmpm.body.points import MaterialPoints
from cfmpm.body.volume_patches import Patches, patch_of
from cfmpm.equilibrium.contact import CrackFaces
from cfmpm.kernels import assembly


class Force(Protocol):
    """Additional nodal forces that depend on the displacement, besides stress and loads.

    Examples are springs (`body.springs`), follower pressure, friction. At small strain the
    resistance is linear in the displacement. Contact of crack faces is not of this kind: closed
    pairs and contact forces are the solution of a complementarity problem with the factored
    stiffness of the body (`contact.close_faces`).
    """

    @property
    def pull(self) -> Floats:
        """Force per load factor [N/mm], (n, 2)."""
        ...

    def resistance(self, displacement: Floats, /) -> Floats:
        """Return the resisting force at a displacement [N/mm], (n, 2)."""
        ...

    def stiffness(self, displacement: Floats, /) -> csr_array:
        """Return the derivative of the resistance, (2 n, 2 n) [N/mm^2].

        Symmetric, rows in the order of the displacement. Its pattern is the same for every
        displacement.
        """
        ...


@dataclass(frozen=True)
class BoundaryValueProblem:
    """Data of a boundary value problem, for any load factor.

    Attributes
    ----------
    grid : Grid
    points : MaterialPoints
        The quadrature points.
    gradients : (p, k, 2) float
        Basis gradients at the points, with respect to the reference configuration [1/mm].
    materials : Materials
    loading : Loading
    solver : str
        A name of `linear.solvers`.
    patches : Patches or None
        Patches over which the volume change is averaged.
    base : (p, 2, 2) float or None
        Displacement gradient of the points at zero displacement of the grid; None if it is zero.
    faces : CrackFaces or None
        The crack faces for contact; None for those of the grid.
    forces : tuple of Force
    """

    grid: Grid
    points: MaterialPoints
    gradients: Floats
    materials: Materials
    loading: Loading
    solver: str = "auto"
    patches: Patches | None = None
    base: Floats | None = None
    faces: CrackFaces | None = None
    forces: tuple[Force, ...] = ()

    @cached_property
    def base_gradient(self) -> Floats:
        """Displacement gradient of the points at zero displacement of the grid, (p, 2, 2)."""
        return np.zeros((len(self.points), 2, 2)) if self.base is None else self.base

    @cached_property
    def crack_faces(self) -> CrackFaces:
        """The crack faces for contact."""
        return CrackFaces(self.grid) if self.faces is None else self.faces

    @property
    def n_unknowns(self) -> int:
        """Number of the free degrees of freedom."""
        return int(np.count_nonzero(~self.loading.prescribed))

    @cached_property
    def patch(self) -> Ints:
        """Patch of each point; empty without patches."""
        return patch_of(self.patches, self.points)

    @cached_property
    def pattern(self) -> tuple[Ints, Ints]:
        """Row pointers and columns of the stiffness of the free degrees of freedom."""
        coupled = self.grid.elements if self.patches is None else self.patches.nodes
        indptr, indices = assembly.sparsity(coupled, self.loading.free)
        if len(indices) < np.iinfo(np.int32).max:
            indptr = indptr.astype(np.int32)
        for force in self.forces:
            own = self._of_free(force, np.zeros(self.grid.nodes.shape))
            indptr, indices = _united((indptr, indices), (own.indptr, own.indices))
        return indptr, indices

    @cached_property
    def slots(self) -> Ints:
        """Places of the entries of each element in the stiffness."""
        slots: Ints = assembly.entry_slots(self.grid.elements, self.loading.free, *self.pattern)
        return slots

    @cached_property
    def patch_slots(self) -> Ints:
        """Places of the entries of each patch in the stiffness."""
        assert self.patches is not None
        slots: Ints = assembly.entry_slots(self.patches.nodes, self.loading.free, *self.pattern)
        return slots

    @cached_property
    def _force_slots(self) -> list[Ints]:
        """Places of the entries of each additional force in the stiffness."""
        indptr, indices = self.pattern
        n = len(indptr) - 1
        places = np.repeat(np.arange(n), np.diff(indptr)) * n + indices
        found = []
        for force in self.forces:
            own = self._of_free(force, np.zeros(self.grid.nodes.shape)).tocoo()
            found.append(np.searchsorted(places, own.row.astype(np.int64) * n + own.col))
        return found

    @property
    def pull(self) -> Floats | float:
        """Pull of the additional forces per load factor [N/mm], (n, 2)."""
        return sum((force.pull for force in self.forces), 0.0)

    def resistance(self, displacement: Floats) -> Floats | float:
        """Return the resistance of the additional forces at a displacement [N/mm], (n, 2)."""
        return sum((force.resistance(displacement) for force in self.forces), 0.0)

    def matrix(self, data: Floats, displacement: Floats) -> csr_array:
        """Make the stiffness from that of the material (`data`) and of the additional forces."""
        indptr, indices = self.pattern
        if self.forces:
            data = data.copy()
        for force, slots in zip(self.forces, self._force_slots, strict=True):
            data[slots] += self._of_free(force, displacement).data
        return csr_array((data, indices, indptr), shape=(len(indptr) - 1,) * 2)

    def _of_free(self, force: Force, displacement: Floats) -> csr_array:
        """Stiffness of an additional force for the free degrees of freedom."""
        rows = np.flatnonzero(~self.loading.prescribed)
        return csr_array(force.stiffness(displacement)[rows][:, rows])


def _united(one: tuple[Ints, Ints], other: tuple[Ints, Ints]) -> tuple[Ints, Ints]:
    """Union of the sparsity patterns of two matrices of the same size."""
    n = len(one[0]) - 1
    both: Any = csr_array((n, n))
    for indptr, indices in (one, other):
        both = both + csr_array((np.ones(len(indices)), indices, indptr), shape=(n, n))
    both.sort_indices()
    return both.indptr, both.indices
