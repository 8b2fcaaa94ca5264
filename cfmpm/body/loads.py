"""Loads and supports of a scene as nodal values, and the holding of rigid bodies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.applied import Place
from cfmpm.body.boundary import Segments, find_segments, nodes_and_weights
from cfmpm.body.grid import Floats, Grid, Ints
from cfmpm.body.points import MaterialPoints
from cfmpm.body.rigid_motions import BALANCE, hold_rigid_motions, loose_motions
from cfmpm.errors import Problem, SceneError
from cfmpm.kernels import assembly
from cfmpm.registry.loads import LOADS
from cfmpm.registry.table import load as find

if TYPE_CHECKING:  # values that are handed in
    from cfmpm.scene.loads import Load
    from cfmpm.scene.shapes import Side


@dataclass(frozen=True)
class Boundary:
    """The nodes of one loaded or supported part.

    Attributes
    ----------
    nodes : (k,) int
    weights : (k,) float
        For the mean over its length; their sum is one.
    force : (k, 2) float
        What this load itself applies, at load factor one [N/mm].
    holds : (k, 2) bool
        Components that this load prescribes, and none before it: each belongs to one part.
    """

    nodes: Ints
    weights: Floats
    force: Floats
    holds: NDArray[np.bool_]


@dataclass(frozen=True)
class Loads:
    """What acts on a body at a load factor, or for each unit of it.

    Attributes
    ----------
    force : (n, 2) float
        External force, body force included [N/mm].
    displacement : (n, 2) float
        Prescribed components [mm]; zero elsewhere.
    body_force : (2,) float
        [N/mm^3].
    """

    force: Floats
    displacement: Floats
    body_force: Floats


@dataclass(frozen=True)
class Loading:
    """Loads and supports on the nodes of a grid.

    Attributes
    ----------
    prescribed : (n, 2) bool
        Components of displacement that are prescribed.
    displacement : (n, 2) float
        Their values at load factor one [mm]; zero elsewhere.
    force : (n, 2) float
        External force at load factor one, body force included [N/mm].
    own_weight : (n, 2) float
        The part of `force` that is body force [N/mm].
    body_force : (2,) float
        [N/mm^3].
    boundaries : dict of str to Boundary
        The parts of the boundary at which forces and displacements are reported.
    held : int
        Number of rigid motions that the program itself holds.
    warnings : tuple of str
        Loads that do nothing but press on a support.
    turning : (r, 2) int
        Node and component of what the program holds a rotation by, one for each part that has one.
    loose : (m, n, 2) float
        Rigid motions of the whole body that no support holds, scaled such that
        ``(node_area * motion_i * motion_j).sum()`` is 1 for i = j, else 0.
    node_area : (n, 1) float
        A third of the triangles around each of their corners [mm^2].
    """

    prescribed: NDArray[np.bool_]
    displacement: Floats
    force: Floats
    own_weight: Floats
    body_force: Floats
    boundaries: dict[str, Boundary]
    held: int
    warnings: tuple[str, ...] = ()
    turning: Ints = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    loose: Floats = field(default_factory=lambda: np.zeros((0, 1, 2)))
    node_area: Floats = field(default_factory=lambda: np.ones((1, 1)))

    @property
    def free(self) -> Ints:
        """Number of each free degree of freedom, -1 where prescribed; (n, 2)."""
        open_ = ~self.prescribed
        return np.where(open_, np.cumsum(open_).reshape(open_.shape) - 1, -1)

    def at(self, load_factor: float) -> Loads:
        """Return what acts at a load factor, in arrays of its own."""
        return Loads(
            load_factor * self.force,
            load_factor * self.displacement,
            load_factor * self.body_force,
        )

    @property
    def per_factor(self) -> Loads:
        """What a unit of the load factor adds."""
        return Loads(self.force, self.displacement, self.body_force)

    def at_rest(self, displacement: Floats) -> Floats:
        """Take the rigid motions that no support holds out of a displacement.

        Parameters
        ----------
        displacement : (n, 2) float
            With those motions held at some nodes or other, which differ from grid to grid.

        Returns
        -------
        (n, 2) float
            Whose mean over the body along these motions is zero [mm].
        """
        share = (self.loose * (self.node_area * displacement)).sum(axis=(1, 2))
        return displacement - (share[:, None, None] * self.loose).sum(axis=0)


def apply_loads(
    loads: Sequence[Load], sides: Mapping[str, Sequence[Side]], grid: Grid, points: MaterialPoints
) -> Loading:
    """Turn loads into nodal values.

    Parameters
    ----------
    loads : sequence of Load
        Each with its name.
    sides : mapping of str to sequence of Side
        The true sides of the boundary, by the names of their edges; of a mesh file none.
    grid : Grid
    points : MaterialPoints

    Returns
    -------
    Loading
        Rigid motions that no support holds are held at single nodes if the loads do no work on
        them; the forces there are zero, and stress and configurational force are untouched.

    Raises
    ------
    SceneError
        Where two loads prescribe different displacements at a node, or a box holds no boundary,
        or no node of it that a displacement could be prescribed at.
    UnheldError
        Where a motion is not held and the loads would drive it.
    """
    nodal = _NodalValues.of(grid)
    problems: list[Problem] = []
    places = [_place_of(load, sides, grid) for load in loads]
    for i, (load, place) in enumerate(zip(loads, places, strict=True)):
        if LOADS[load.kind].places and place.nodes.size == 0:
            reason = "no part of the boundary lies in the box"
            if place.segments is not None and len(place.segments.edges):
                reason = "no node of the boundary lies in the box: the grid is too coarse for it"
            problems.append(Problem(reason, f"loads[{i}].box"))
            continue
        problems += nodal.add(i, load, place, grid)
    if problems:
        raise SceneError(problems)
    force, prescribed, density = nodal.force, nodal.prescribed, nodal.density
    own_weight = np.zeros_like(force)
    if density.any():
        shape = grid.basis_values(points.element, points.position)
        own_weight = assembly.body_force(
            grid.elements, len(force), points.element, shape, points.volume, density
        )
        force += own_weight
    warnings = [
        warning
        for i, (load, place) in enumerate(zip(loads, places, strict=True))
        if place.segments is not None and not LOADS[load.kind].holds
        for warning in _lost(load, i, place.segments, prescribed)
    ]
    node_area = np.zeros((len(force), 1))
    np.add.at(node_area, grid.triangles, (grid.areas / 3.0)[:, None, None])
    loose = loose_motions(grid, prescribed, node_area)
    held, turning = hold_rigid_motions(grid, prescribed, force)
    return Loading(
        prescribed=prescribed,
        displacement=nodal.displacement,
        force=force,
        own_weight=own_weight,
        body_force=density,
        boundaries=nodal.boundaries,
        held=held,
        turning=turning,
        warnings=tuple(warnings),
        loose=loose,
        node_area=node_area,
    )


def _place_of(load: Load, sides: Mapping[str, Sequence[Side]], grid: Grid) -> Place:
    """Find the nodes that a load acts on."""
    if not LOADS[load.kind].places:
        return Place(np.empty(0, np.int64), np.empty(0))
    if load.point is not None:
        return Place(np.array([grid.points[str(load.name)]]), np.ones(1))
    segments = find_segments(load, sides, grid)
    return Place(*nodes_and_weights(load, grid, segments), segments)


@dataclass(frozen=True)
class _NodalValues:
    """What the loads so far come to; their arrays are added to in place.

    Attributes
    ----------
    force, displacement : (n, 2) float
        [N/mm], [mm].
    prescribed : (n, 2) bool
    density : (2,) float
        Body force [N/mm^3].
    boundaries : dict of str to Boundary
    owner : dict of (int, int) to int
        The load that prescribes a component of a node last.
    """

    force: Floats
    displacement: Floats
    prescribed: NDArray[np.bool_]
    density: Floats
    boundaries: dict[str, Boundary]
    owner: dict[tuple[int, int], int]

    @classmethod
    def of(cls, grid: Grid) -> Self:
        """Nothing, on the nodes of a grid."""
        shape = grid.nodes.shape
        return cls(np.zeros(shape), np.zeros(shape), np.zeros(shape, bool), np.zeros(2), {}, {})

    def add(self, i: int, load: Load, place: Place, grid: Grid) -> Iterator[Problem]:
        """Add a load; yield where it contradicts those before it."""
        applied = find(LOADS[load.kind].code)(load.value, place, grid)
        if applied.density is not None:
            self.density[:] += applied.density
        if not len(place.nodes):
            return
        nodes = place.nodes
        force = np.zeros((len(nodes), 2)) if applied.force is None else applied.force
        self.force[nodes] += force
        holds = np.zeros((len(nodes), 2), bool)
        if applied.displacement is not None:
            given = ~np.isnan(applied.displacement)
            for axis in np.flatnonzero(given.any(axis=0)).tolist():
                chosen, values = nodes[given[:, axis]], applied.displacement[given[:, axis], axis]
                known = self.prescribed[chosen, axis]
                holds[given[:, axis], axis] = ~known
                clash = np.flatnonzero(known & (self.displacement[chosen, axis] != values))
                if clash.size:
                    node, value = int(chosen[clash[0]]), values[clash[0]]
                    yield Problem(
                        f"prescribes u_{'xy'[axis]} = {value:g} mm where "
                        f"loads[{self.owner[node, axis]}] prescribes "
                        f"{self.displacement[node, axis]:g} mm, "
                        f"at ({grid.nodes[node, 0]:g}, {grid.nodes[node, 1]:g})",
                        f"loads[{i}].{load.kind}.{'xy'[axis]}",
                    )
                self.prescribed[chosen, axis] = True
                self.displacement[chosen, axis] = values
                self.owner.update({(int(node), axis): i for node in chosen})
        weights = place.weights / place.weights.sum()
        self.boundaries[str(load.name)] = Boundary(nodes, weights, force, holds)


def hold_nodes(loading: Loading, nodes: Ints) -> Loading:
    """Hold nodes that have no stiffness, at their prescribed displacement or at zero."""
    if nodes.size == 0:
        return loading
    prescribed = loading.prescribed.copy()
    prescribed[nodes] = True
    return replace(loading, prescribed=prescribed)


def _lost(load: Load, i: int, segments: Segments, prescribed: NDArray[np.bool_]) -> Iterator[str]:
    """Say how much of a traction acts where its component is prescribed.

    Only edges whose nodes are all prescribed count: where a loaded and a held part meet at a
    corner, they share a node on any grid.
    """
    lengths = segments.weights.sum(axis=1)
    components = load.value if isinstance(load.value, tuple) else ()
    for axis, component in enumerate(components):
        part = lengths[prescribed[segments.edges, axis].all(axis=1)].sum() / lengths.sum()
        if component != 0.0 and part > BALANCE:
            yield (
                f"loads[{i}].{load.kind}: {100 * part:.3g} % of {load.name} acts where "
                f"u_{'xy'[axis]} is prescribed, and goes straight into that support"
            )
