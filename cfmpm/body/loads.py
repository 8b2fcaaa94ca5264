"""Loads and supports of a scene as nodal values, and rigid motions without support."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.applied import Place
from cfmpm.body.boundary import Segments, find_segments, nodes_and_weights
from cfmpm.body.grid import Floats, Grid, Ints
from cfmpm.body.points import MaterialPoints
from cfmpm.body.protocols import GivenLoad, TrueSide
from cfmpm.body.rigid_motions import BALANCE, Holds, hold_rigid_motions, loose_motions
from cfmpm.errors import Problem, SceneError
from cfmpm.kernels import assembly
from cfmpm.registry.loads import LOADS
from cfmpm.registry.table import load as find


@dataclass(frozen=True)
class Boundary:
    """The nodes of one loaded or supported part.

    Attributes
    ----------
    nodes : (k,) int
    weights : (k,) float
        Weights of the mean over its length; their sum is one.
    force : (k, 2) float
        Force applied by this load [N/mm].
    holds : (k, 2) bool
        Components that are prescribed by this load and by no load before it.
    fixed : bool
        Whether the load acts in full at every load factor; else `force` is that at factor one.
    """

    nodes: Ints
    weights: Floats
    force: Floats
    holds: NDArray[np.bool_]
    fixed: bool = False

    def force_at(self, load_factor: float) -> Floats:
        """Return the force applied by this load at a load factor [N/mm], (k, 2)."""
        return self.force if self.fixed else load_factor * self.force


@dataclass(frozen=True)
class NodalLoads:
    """Loads as values at the nodes of a grid.

    Attributes
    ----------
    force : (n, 2) float
        External force, including body force [N/mm].
    displacement : (n, 2) float
        Prescribed components [mm]; zero elsewhere.
    own_weight : (n, 2) float
        Body force, which is part of `force` [N/mm].
    body_force : (2,) float
        [N/mm^3].
    """

    force: Floats
    displacement: Floats
    own_weight: Floats
    body_force: Floats

    @classmethod
    def none(cls, n_nodes: int) -> Self:
        """No loads."""
        nothing = np.zeros((n_nodes, 2))
        return cls(nothing, nothing, nothing, np.zeros(2))

    @property
    def any(self) -> bool:
        """Whether there is any load."""
        return bool(self.force.any() or self.displacement.any() or self.body_force.any())

    def times(self, factor: float) -> NodalLoads:
        """Return a multiple, in new arrays."""
        return NodalLoads(
            factor * self.force,
            factor * self.displacement,
            factor * self.own_weight,
            factor * self.body_force,
        )

    def plus(self, other: NodalLoads) -> NodalLoads:
        """Return the sum with other loads on the same nodes."""
        return NodalLoads(
            self.force + other.force,
            self.displacement + other.displacement,
            self.own_weight + other.own_weight,
            self.body_force + other.body_force,
        )


@dataclass(frozen=True)
class Loading:
    """Loads and supports on the nodes of a grid.

    The loads are a fixed part, independent of the load factor, plus the load factor times a
    proportional part (`at`).

    Attributes
    ----------
    prescribed : (n, 2) bool
        Components of displacement that are prescribed.
    proportional : NodalLoads
        At load factor one.
    boundaries : dict of str to Boundary
        The parts of the boundary at which forces and displacements are reported.
    holds : Holds
        Where rigid motions without support are held; `prescribed` includes it.
    warnings : tuple of str
        Warnings about loads that act only on a support.
    loose : (m, n, 2) float
        Rigid motions of the whole body without support, orthonormal:
        ``(node_area * motion_i * motion_j).sum()`` is 1 for i = j, else 0.
    node_area : (n, 1) float
        A third of the area of the triangles at each corner node [mm^2].
    fixed : NodalLoads or None
        None if all loads are proportional to the load factor.
    fixed_names : frozenset of str
        Names of the loads of the fixed part, from which it is made again on another grid.
    """

    prescribed: NDArray[np.bool_]
    proportional: NodalLoads
    boundaries: Mapping[str, Boundary]
    holds: Holds = field(default_factory=Holds.none)
    warnings: tuple[str, ...] = ()
    loose: Floats = field(default_factory=lambda: np.zeros((0, 1, 2)))
    node_area: Floats = field(default_factory=lambda: np.ones((1, 1)))
    fixed: NodalLoads | None = None
    fixed_names: frozenset[str] = frozenset()

    @property
    def held(self) -> int:
        """Number of rigid motions that the program itself holds."""
        return len(self.holds.places)

    @property
    def supported(self) -> NDArray[np.bool_]:
        """Components that loads and supports prescribe, without what the program holds; (n, 2)."""
        supported = self.prescribed.copy()
        supported[tuple(self.holds.places.T)] = False
        return supported

    def free_motions(self, x: Floats) -> Floats:
        """Return the loose motions of all free parts, one a column; (2 n, m).

        Parameters
        ----------
        x : (n, 2) float
            Where the nodes are [mm].
        """
        supported = self.supported
        motions = [part.motions(x, supported) for part in self.holds.free_parts]
        return np.concatenate([np.zeros((*x.shape, 0)), *motions], axis=2).reshape(2 * len(x), -1)

    @property
    def free(self) -> Ints:
        """Number of each free degree of freedom, -1 where prescribed; (n, 2)."""
        open_ = ~self.prescribed
        return np.where(open_, np.cumsum(open_).reshape(open_.shape) - 1, -1)

    @property
    def is_proportional(self) -> bool:
        """Whether all loads are proportional to the load factor."""
        return self.fixed is None or not self.fixed.any

    @property
    def any(self) -> bool:
        """Whether there is any load."""
        return self.proportional.any or not self.is_proportional

    def at(self, load_factor: float) -> NodalLoads:
        """Return the loads at a load factor, in new arrays."""
        acting = self.proportional.times(load_factor)
        if self.fixed is None or self.is_proportional:
            return acting
        return self.fixed.plus(acting)

    def fixed_alone(self) -> Loading:
        """Return the loading with the fixed part alone, proportional to a factor."""
        fixed = NodalLoads.none(len(self.prescribed)) if self.fixed is None else self.fixed
        return replace(self, proportional=fixed, fixed=None)

    def proportional_alone(self) -> Loading:
        """Return the loading without its fixed part."""
        return replace(self, fixed=None)

    def at_rest(self, displacement: Floats) -> Floats:
        """Subtract the rigid motions without support from a displacement.

        Parameters
        ----------
        displacement : (n, 2) float
            Solution with these motions held at nodes, which depend on the grid [mm].

        Returns
        -------
        (n, 2) float
            Displacement with zero mean over the body along these motions [mm].
        """
        share = (self.loose * (self.node_area * displacement)).sum(axis=(1, 2))
        return displacement - (share[:, None, None] * self.loose).sum(axis=0)


def apply_loads(
    loads: Sequence[GivenLoad],
    sides: Mapping[str, Sequence[TrueSide]],
    grid: Grid,
    points: MaterialPoints,
    fixed: Collection[str] = (),
) -> Loading:
    """Convert loads to nodal values.

    Parameters
    ----------
    loads : sequence of GivenLoad
        Loads with names.
    sides : mapping of str to sequence of TrueSide
        The exact sides of the boundary, by the names of their edges; empty for a mesh file.
    grid : Grid
    points : MaterialPoints
    fixed : collection of str
        Names of the loads that act in full at every load factor; the others are proportional to it.

    Returns
    -------
    Loading
        Rigid motions without support are held at single nodes if the loads do no work on them; the
        reactions there are zero, and stress and configurational force are not affected.

    Raises
    ------
    SceneError
        If two loads, both fixed or both proportional, prescribe different displacements at a node;
        if a box contains no part of the boundary, or, for a displacement, no boundary node.
    UnheldError
        If loads do work on a rigid motion without support.
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
        problems += nodal.add(i, load, place, grid, fixed=load.name in fixed)
    if problems:
        raise SceneError(problems)
    prescribed = nodal.prescribed
    proportional, constant = (
        part.with_weight(grid, points) for part in (nodal.proportional, nodal.fixed)
    )
    warnings = [
        warning
        for i, (load, place) in enumerate(zip(loads, places, strict=True))
        if place.segments is not None and not LOADS[load.kind].holds
        for warning in _lost(load, i, place.segments, prescribed)
    ]
    node_area = np.zeros((len(prescribed), 1))
    np.add.at(node_area, grid.triangles, (grid.areas / 3.0)[:, None, None])
    loose = loose_motions(grid, prescribed, node_area)
    if fixed:
        # Each part has to be in equilibrium by itself.
        hold_rigid_motions(grid, prescribed.copy(), constant.force)
    holds = hold_rigid_motions(grid, prescribed, proportional.force)
    return Loading(
        prescribed=prescribed,
        proportional=proportional,
        boundaries=nodal.boundaries,
        holds=holds,
        warnings=tuple(warnings),
        loose=loose,
        node_area=node_area,
        fixed=constant if fixed else None,
        fixed_names=frozenset(fixed),
    )


def _place_of(load: GivenLoad, sides: Mapping[str, Sequence[TrueSide]], grid: Grid) -> Place:
    """Find the nodes that a load acts on."""
    if not LOADS[load.kind].places:
        return Place(np.empty(0, np.int64), np.empty(0))
    if load.point is not None:
        return Place(np.array([grid.points[str(load.name)]]), np.ones(1))
    segments = find_segments(load, sides, grid)
    return Place(*nodes_and_weights(load, grid, segments), segments)


@dataclass(frozen=True)
class _Part:
    """Sum of the fixed or of the proportional loads; its arrays are modified in place.

    Attributes
    ----------
    force, displacement : (n, 2) float
        [N/mm], [mm].
    density : (2,) float
        Body force [N/mm^3].
    owner : (n, 2) int
        Index of the last load that prescribes a component of a node; -1 if none does.
    """

    force: Floats
    displacement: Floats
    density: Floats
    owner: Ints

    @classmethod
    def of(cls, grid: Grid) -> Self:
        """No loads on the nodes of a grid."""
        shape = grid.nodes.shape
        return cls(np.zeros(shape), np.zeros(shape), np.zeros(2), np.full(shape, -1))

    def with_weight(self, grid: Grid, points: MaterialPoints) -> NodalLoads:
        """Return the nodal values, with the nodal forces of the body force."""
        if not self.density.any():
            nothing = np.zeros_like(self.force)
            return NodalLoads(self.force, self.displacement, nothing, self.density)
        shape = grid.basis_values(points.element, points.position)
        own_weight = assembly.body_force(
            grid.elements, len(self.force), points.element, shape, points.volume, self.density
        )
        return NodalLoads(self.force + own_weight, self.displacement, own_weight, self.density)


@dataclass(frozen=True)
class _NodalValues:
    """Sum of the loads so far.

    Attributes
    ----------
    proportional, fixed : _Part
    prescribed : (n, 2) bool
    boundaries : dict of str to Boundary
    """

    proportional: _Part
    fixed: _Part
    prescribed: NDArray[np.bool_]
    boundaries: dict[str, Boundary]

    @classmethod
    def of(cls, grid: Grid) -> Self:
        """No loads on the nodes of a grid."""
        return cls(_Part.of(grid), _Part.of(grid), np.zeros(grid.nodes.shape, bool), {})

    def add(
        self, i: int, load: GivenLoad, place: Place, grid: Grid, *, fixed: bool
    ) -> Iterator[Problem]:
        """Add a load; yield contradictions to previous loads of its part."""
        applied = find(LOADS[load.kind].code)(load.value, place, grid)
        part = self.fixed if fixed else self.proportional
        if applied.density is not None:
            part.density[:] += applied.density
        if not len(place.nodes):
            return
        nodes = place.nodes
        force = np.zeros((len(nodes), 2)) if applied.force is None else applied.force
        part.force[nodes] += force
        holds = np.zeros((len(nodes), 2), bool)
        if applied.displacement is not None:
            given = ~np.isnan(applied.displacement)
            for axis in np.flatnonzero(given.any(axis=0)).tolist():
                chosen, values = nodes[given[:, axis]], applied.displacement[given[:, axis], axis]
                holds[given[:, axis], axis] = ~self.prescribed[chosen, axis]
                known = part.owner[chosen, axis] >= 0
                clash = np.flatnonzero(known & (part.displacement[chosen, axis] != values))
                if clash.size:
                    node, value = int(chosen[clash[0]]), values[clash[0]]
                    yield Problem(
                        f"prescribes u_{'xy'[axis]} = {value:g} mm where "
                        f"loads[{part.owner[node, axis]}] prescribes "
                        f"{part.displacement[node, axis]:g} mm, "
                        f"at ({grid.nodes[node, 0]:g}, {grid.nodes[node, 1]:g})",
                        f"loads[{i}].{load.kind}.{'xy'[axis]}",
                    )
                self.prescribed[chosen, axis] = True
                part.displacement[chosen, axis] = values
                part.owner[chosen, axis] = i
        weights = place.weights / place.weights.sum()
        self.boundaries[str(load.name)] = Boundary(nodes, weights, force, holds, fixed)


def hold_nodes(loading: Loading, nodes: Ints) -> Loading:
    """Hold nodes without stiffness at their prescribed displacement or at zero."""
    if nodes.size == 0:
        return loading
    prescribed = loading.prescribed.copy()
    prescribed[nodes] = True
    return replace(loading, prescribed=prescribed)


def _lost(
    load: GivenLoad, i: int, segments: Segments, prescribed: NDArray[np.bool_]
) -> Iterator[str]:
    """Say how much of a traction acts where its component is prescribed.

    Only edges with all nodes prescribed count, since a loaded and a supported part that meet at a
    corner share a node on any grid.
    """
    lengths = segments.weights.sum(axis=1)
    components = load.value if isinstance(load.value, tuple) else ()
    for axis, component in enumerate(components):
        part = lengths[prescribed[segments.edges, axis].all(axis=1)].sum() / lengths.sum()
        if component != 0.0 and part > BALANCE:
            yield (
                f"loads[{i}].{load.kind}: {100 * part:.3g} % of {load.name} acts where "
                f"u_{'xy'[axis]} is prescribed, and is carried by that support alone: take it off "
                f"there, or leave u_{'xy'[axis]} free there"
            )
