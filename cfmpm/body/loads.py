"""Loads and supports of a scene as nodal values, and the holding of rigid bodies."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from cfmpm.body.boundary import Segments, find_segments, nodes_and_weights
from cfmpm.body.grid import Floats, Grid, Ints
from cfmpm.body.points import MaterialPoints
from cfmpm.errors import Problem, SceneError
from cfmpm.kernels import assembly, basis
from cfmpm.linear.solvers import rigid_body_modes
from cfmpm.scene.loads import Load
from cfmpm.scene.model import Scene

# Loads are in equilibrium when their resultant is below this part of the sum of their moduli.
BALANCE = 1e-9


class UnheldError(SceneError):
    """A part of the body is free to move, and the loads drive it.

    Attributes
    ----------
    centre : (2,) float
        Of the nodes of that part [mm].
    """

    def __init__(self, problems: list[Problem], centre: Floats) -> None:
        self.centre = centre
        super().__init__(problems)


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


def apply_loads(scene: Scene, grid: Grid, points: MaterialPoints) -> Loading:
    """Turn the loads of a scene into nodal values.

    Parameters
    ----------
    scene : Scene
        Expanded: every load has its name.
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
    n = len(grid.nodes)
    prescribed = np.zeros((n, 2), bool)
    values = np.zeros((n, 2))
    force = np.zeros((n, 2))
    own_weight = np.zeros((n, 2))
    density = np.zeros(2)
    boundaries: dict[str, Boundary] = {}
    problems: list[Problem] = []
    owner: dict[tuple[int, int], int] = {}
    tractions: list[tuple[int, Segments]] = []
    for i, load in enumerate(scene.loads):
        if load.body_force is not None:
            density += load.body_force
            continue
        if load.point is not None:
            nodes, weights = np.array([grid.points[str(load.name)]]), np.ones(1)
        else:
            segments = find_segments(load, scene, grid)
            nodes, weights = nodes_and_weights(load, grid, segments)
            if load.traction is not None:
                tractions.append((i, segments))
        if nodes.size == 0:
            reason = "no part of the boundary lies in the box"
            if len(segments.edges):
                reason = "no node of the boundary lies in the box: the grid is too coarse for it"
            problems.append(Problem(reason, f"loads[{i}].box"))
            continue
        applied = np.zeros((len(nodes), 2))
        if load.traction is not None:
            applied = weights[:, None] * np.array(load.traction)
        if load.force is not None:
            applied[0] = load.force
        force[nodes] += applied
        holds = np.zeros((len(nodes), 2), bool)
        if load.displacement is not None:
            for axis, value in enumerate((load.displacement.x, load.displacement.y)):
                if value is None:
                    continue
                holds[:, axis] = ~prescribed[nodes, axis]
                clash = prescribed[nodes, axis] & (values[nodes, axis] != value)
                if clash.any():
                    node = int(nodes[np.argmax(clash)])
                    problems.append(
                        Problem(
                            f"prescribes u_{'xy'[axis]} = {value:g} mm where "
                            f"loads[{owner[node, axis]}] prescribes {values[node, axis]:g} mm, "
                            f"at ({grid.nodes[node, 0]:g}, {grid.nodes[node, 1]:g})",
                            f"loads[{i}].displacement.{'xy'[axis]}",
                        )
                    )
                prescribed[nodes, axis] = True
                values[nodes, axis] = value
                owner.update({(int(node), axis): i for node in nodes})
        boundaries[str(load.name)] = Boundary(nodes, weights / weights.sum(), applied, holds)
    if problems:
        raise SceneError(problems)
    if density.any():
        shape = basis.basis_values(grid.nodes, grid.elements, points.element, points.position)
        own_weight = assembly.body_force(
            grid.elements, n, points.element, shape, points.volume, density
        )
        force += own_weight
    warnings = [
        warning
        for i, segments in tractions
        for warning in _lost(scene.loads[i], i, segments, prescribed)
    ]
    node_area = np.zeros((n, 1))
    np.add.at(node_area, grid.triangles, (grid.areas / 3.0)[:, None, None])
    loose = _loose_motions(grid, prescribed, node_area)
    held, turning = _hold_rigid_motions(grid, prescribed, force)
    return Loading(
        prescribed=prescribed,
        displacement=values,
        force=force,
        own_weight=own_weight,
        body_force=density,
        boundaries=boundaries,
        held=held,
        turning=turning,
        warnings=tuple(warnings),
        loose=loose,
        node_area=node_area,
    )


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
    for axis, component in enumerate(load.traction or ()):
        part = lengths[prescribed[segments.edges, axis].all(axis=1)].sum() / lengths.sum()
        if component != 0.0 and part > BALANCE:
            yield (
                f"loads[{i}].traction: {100 * part:.3g} % of {load.name} acts where u_{'xy'[axis]} "
                "is prescribed, and goes straight into that support"
            )


def _hold_rigid_motions(
    grid: Grid, prescribed: NDArray[np.bool_], force: Floats
) -> tuple[int, Ints]:
    """Hold, in place, the motions of each connected part that nothing holds.

    Returns
    -------
    held : int
        Their number.
    turning : (r, 2) int
        As in `Loading`.
    """
    element_part = _connected_parts(grid)
    node_part = np.empty(len(grid.nodes), np.int64)
    node_part[grid.elements] = element_part[:, None]
    held, turning = 0, []
    for part in range(element_part.max() + 1):
        nodes = np.flatnonzero(node_part == part) if element_part.any() else slice(None)
        x = grid.nodes[nodes]
        modes, loose = _unheld_motions(x, prescribed[nodes])
        if len(loose) == 0:
            continue
        resultant = np.einsum("km,k->m", modes, force[nodes].ravel())
        scale = np.abs(force[nodes]).sum()
        if np.abs(loose @ resultant).max() > BALANCE * scale:
            reason = _unheld(grid, nodes, force[nodes])
            raise UnheldError([Problem(reason, "loads")], x.mean(axis=0))
        motions = np.einsum("km,lm->kl", modes, loose)
        number = np.arange(len(grid.nodes))[nodes]
        holds = []
        for _ in loose:
            # Hold what moves most, and take from all others what that holds of them.
            chosen = int((motions**2).sum(axis=1).argmax())
            holds.append((number[chosen // 2], chosen % 2))
            prescribed[holds[-1]] = True
            along = motions[chosen] / np.hypot.reduce(motions[chosen])
            motions = motions - np.einsum("kl,l->k", motions, along)[:, None] * along
        held += len(loose)
        for place in holds:
            prescribed[place] = False
            _, (motion,) = _unheld_motions(x, prescribed[nodes])
            prescribed[place] = True
            if abs(motion[2]) > 1e-6:
                turning.append(place)
                break
    return held, np.array(turning, np.int64).reshape(-1, 2)


def _loose_motions(grid: Grid, prescribed: NDArray[np.bool_], node_area: Floats) -> Floats:
    """Return the rigid motions of the whole body that nothing holds; see `Loading.loose`.

    Of the whole body, so that taking them out leaves parts in contact where they are.
    """
    modes, loose = _unheld_motions(grid.nodes, prescribed)
    motions = np.einsum("km,lm->lk", modes, loose).reshape(len(loose), *grid.nodes.shape)
    motions[:, prescribed] = 0.0  # which they are, but for round-off
    products = np.einsum("ank,bnk->ab", motions, node_area * motions)
    return np.einsum("ab,bnk->ank", np.linalg.inv(np.linalg.cholesky(products)), motions)


def _unheld_motions(x: Floats, prescribed: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Rigid motions of nodes, and which sums of them move nothing that is prescribed.

    Returns
    -------
    modes : (2 n, 3) float
        Rows are (node, component), columns the two translations and the rotation.
    loose : (m, 3) float
    """
    modes = rigid_body_modes(x, np.ones(x.shape, bool))
    fixed = modes[prescribed.ravel()]
    # Sums by numpy itself: the bits of a threaded BLAS (a @ b) depend on its threads.
    _, sizes, directions = np.linalg.svd(np.einsum("ki,kj->ij", fixed, fixed))
    return modes, directions[sizes <= 1e-12 * max(1.0, len(fixed))]


def _unheld(grid: Grid, nodes: Ints | slice, force: Floats) -> str:
    """Say how the loads would move a part that is not held."""
    x = grid.nodes[nodes]
    total = force.sum(axis=0)
    centre = x.mean(axis=0)
    moment = float(((x - centre)[:, 0] * force[:, 1] - (x - centre)[:, 1] * force[:, 0]).sum())
    return (
        "the supports leave the body free to move and the loads are out of balance: resultant "
        f"({total[0]:.6g}, {total[1]:.6g}) N/mm, moment {moment:.6g} N about "
        f"({centre[0]:.6g}, {centre[1]:.6g}); add a displacement or balance the loads"
    )


def _connected_parts(grid: Grid) -> Ints:
    """Number the connected parts of the body; one number for each element."""
    element, side = np.nonzero(grid.twins >= 0)
    links = coo_array(
        (np.ones(len(element), np.int8), (element, grid.twins[element, side] // 3)),
        shape=(len(grid.twins),) * 2,
    )
    return connected_components(links, directed=False)[1].astype(np.int64)
