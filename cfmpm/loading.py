"""Loads and supports of a scene as nodal values, and the holding of rigid bodies."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from cfmpm.errors import Problem, SceneError
from cfmpm.grid import Floats, Grid, Ints
from cfmpm.kernels import assembly, basis
from cfmpm.points import MaterialPoints
from cfmpm.scene.model import Load, Scene

# Loads are in equilibrium when their resultant is below this part of the sum of their moduli.
BALANCE = 1e-9


class UnheldError(SceneError):
    """A part of the body is free to move, and the loads drive it."""


@dataclass(frozen=True)
class Boundary:
    """The nodes of one loaded or supported part, with weights for the mean over its length."""

    nodes: Ints
    weights: Floats


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
    """

    prescribed: NDArray[np.bool_]
    displacement: Floats
    force: Floats
    own_weight: Floats
    body_force: Floats
    boundaries: dict[str, Boundary]
    held: int

    @property
    def free(self) -> Ints:
        """Number of each free degree of freedom, -1 where prescribed; (n, 2)."""
        open_ = ~self.prescribed
        return np.where(open_, np.cumsum(open_).reshape(open_.shape) - 1, -1)


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
        Where two loads prescribe different displacements at a node, or a box holds no boundary.
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
    for i, load in enumerate(scene.loads):
        if load.body_force is not None:
            density += load.body_force
            continue
        boundary, lengths = _place(load, grid)
        if boundary.nodes.size == 0:
            problems.append(Problem("no part of the boundary lies in the box", f"loads[{i}].box"))
            continue
        boundaries[str(load.name)] = boundary
        if load.traction is not None:
            if not lengths:
                problems.append(Problem("no edge lies wholly in the box", f"loads[{i}].box"))
            force[boundary.nodes] += boundary.weights[:, None] * lengths * np.array(load.traction)
        if load.force is not None:
            force[boundary.nodes] += load.force
        if load.displacement is not None:
            for axis, value in enumerate((load.displacement.x, load.displacement.y)):
                if value is None:
                    continue
                clash = prescribed[boundary.nodes, axis] & (values[boundary.nodes, axis] != value)
                if clash.any():
                    node = int(boundary.nodes[np.argmax(clash)])
                    problems.append(
                        Problem(
                            f"prescribes u_{'xy'[axis]} = {value:g} mm where "
                            f"loads[{owner[node, axis]}] prescribes {values[node, axis]:g} mm, "
                            f"at ({grid.nodes[node, 0]:g}, {grid.nodes[node, 1]:g})",
                            f"loads[{i}].displacement.{'xy'[axis]}",
                        )
                    )
                prescribed[boundary.nodes, axis] = True
                values[boundary.nodes, axis] = value
                owner.update({(int(node), axis): i for node in boundary.nodes})
    if problems:
        raise SceneError(problems)
    if density.any():
        shape = basis.basis_values(grid.nodes, grid.elements, points.element, points.position)
        own_weight = assembly.body_force(
            grid.elements, n, points.element, shape, points.volume, density
        )
        force += own_weight
    held = _hold_rigid_motions(grid, prescribed, force)
    return Loading(prescribed, values, force, own_weight, density, boundaries, held)


def hold_nodes(loading: Loading, nodes: Ints) -> Loading:
    """Hold nodes that have no stiffness, at their prescribed displacement or at zero."""
    if nodes.size == 0:
        return loading
    prescribed = loading.prescribed.copy()
    prescribed[nodes] = True
    return replace(loading, prescribed=prescribed)


def _place(load: Load, grid: Grid) -> tuple[Boundary, float]:
    """Find the nodes of a load, their weights, and the length of the edges there."""
    if load.point is not None:
        return Boundary(np.array([grid.points[str(load.name)]]), np.ones(1)), 0.0
    alone = np.empty(0, np.int64)
    if load.edge is not None:
        edges = grid.edges[load.edge]
    else:
        assert load.box is not None
        # In a mesh file an edge may have two names.
        edges = np.unique(np.concatenate(list(grid.edges.values())), axis=0)
        low, high = np.min(load.box, axis=0), np.max(load.box, axis=0)
        slack = 1e-9 * np.ptp(grid.nodes, axis=0).max()
        inside = np.all((grid.nodes >= low - slack) & (grid.nodes <= high + slack), axis=1)
        alone = np.unique(edges[inside[edges]])
        edges = edges[inside[edges].all(axis=1)]
    if len(edges) == 0:
        return Boundary(alone, np.full(len(alone), 1.0 / max(1, len(alone)))), 0.0
    # A constant traction on a straight edge: the trapezoidal rule is exact for the linear basis,
    # Simpson's for the quadratic one.
    rule = np.array([0.5, 0.5]) if edges.shape[1] == 2 else np.array([1.0, 1.0, 4.0]) / 6.0
    lengths = np.hypot(*(grid.nodes[edges[:, 1]] - grid.nodes[edges[:, 0]]).T)
    nodes, inverse = np.unique(edges, return_inverse=True)
    weights = np.bincount(inverse.ravel(), (lengths[:, None] * rule).ravel())
    extra = np.setdiff1d(alone, nodes)
    nodes = np.concatenate([nodes, extra])
    weights = np.concatenate([weights, np.zeros(len(extra))])
    return Boundary(nodes, weights / lengths.sum()), float(lengths.sum())


def _hold_rigid_motions(grid: Grid, prescribed: NDArray[np.bool_], force: Floats) -> int:
    """Hold, in place, the motions of each connected part that nothing holds."""
    element_part = _connected_parts(grid)
    node_part = np.empty(len(grid.nodes), np.int64)
    node_part[grid.elements] = element_part[:, None]
    held = 0
    for part in range(element_part.max() + 1):
        nodes = np.flatnonzero(node_part == part) if element_part.any() else slice(None)
        x = grid.nodes[nodes]
        x = (x - x.mean(axis=0)) / np.ptp(x, axis=0).max()
        # Rows are (node, component), columns the two translations and the rotation.
        modes = np.zeros((len(x), 2, 3))
        modes[:, 0, 0] = modes[:, 1, 1] = 1.0
        modes[:, 0, 2], modes[:, 1, 2] = -x[:, 1], x[:, 0]
        fixed = modes[prescribed[nodes]]
        _, sizes, directions = np.linalg.svd(fixed.T @ fixed)
        loose = directions[sizes <= 1e-12 * max(1.0, len(fixed))]
        if len(loose) == 0:
            continue
        resultant = np.einsum("nim,ni->m", modes, force[nodes])
        scale = np.abs(force[nodes]).sum()
        if np.abs(loose @ resultant).max() > BALANCE * scale:
            raise UnheldError([Problem(_unheld(grid, nodes, force[nodes]), "loads")])
        motions = modes.reshape(-1, 3) @ loose.T
        _, order = qr(motions.T, mode="r", pivoting=True)
        chosen = order[: len(loose)]
        where = np.arange(len(grid.nodes))[nodes][chosen // 2]
        prescribed[where, chosen % 2] = True
        held += len(loose)
    return held


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
