"""Rigid motions of a body and its parts that no support prevents, and how they are held."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from cfmpm.body.grid import Floats, Grid, Ints
from cfmpm.errors import Problem, SceneError
from cfmpm.linear.solvers import rigid_body_modes

# Loads are in equilibrium if their resultant is below this fraction of the sum of their norms.
BALANCE = 1e-9


class UnheldError(SceneError):
    """Loads do work on a rigid motion of a part of the body that no support prevents.

    Attributes
    ----------
    centre : (2,) float
        Mean position of the nodes of that part [mm].
    """

    def __init__(self, problems: list[Problem], centre: Floats) -> None:
        self.centre = centre
        super().__init__(problems)


def hold_rigid_motions(
    grid: Grid, prescribed: NDArray[np.bool_], force: Floats
) -> tuple[int, Ints]:
    """Hold the rigid motions without support of each connected part; changes `prescribed`.

    Returns
    -------
    held : int
        Number of these motions.
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
        resultant = force[nodes].ravel() @ modes
        scale = np.abs(force[nodes]).sum()
        if np.abs(loose @ resultant).max() > BALANCE * scale:
            reason = _unheld(grid, nodes, force[nodes])
            raise UnheldError([Problem(reason, "loads")], x.mean(axis=0))
        motions = modes @ loose.T
        number = np.arange(len(grid.nodes))[nodes]
        holds = []
        for _ in loose:
            # Hold the component with the largest motion, and make the others orthogonal to it.
            chosen = int((motions**2).sum(axis=1).argmax())
            holds.append((number[chosen // 2], chosen % 2))
            prescribed[holds[-1]] = True
            along = motions[chosen] / np.hypot.reduce(motions[chosen])
            motions = motions - np.outer(motions @ along, along)
        held += len(loose)
        for place in holds:
            prescribed[place] = False
            _, (motion,) = _unheld_motions(x, prescribed[nodes])
            prescribed[place] = True
            if abs(motion[2]) > 1e-6:
                turning.append(place)
                break
    return held, np.array(turning, np.int64).reshape(-1, 2)


def loose_motions(grid: Grid, prescribed: NDArray[np.bool_], node_area: Floats) -> Floats:
    """Return the rigid motions of the whole body without support; see `Loading.loose`.

    Only motions of the whole body are subtracted, so that parts in contact keep their relative
    position.
    """
    modes, loose = _unheld_motions(grid.nodes, prescribed)
    motions = (loose @ modes.T).reshape(len(loose), *grid.nodes.shape)
    motions[:, prescribed] = 0.0  # zero up to round-off
    products = np.einsum("ank,bnk->ab", motions, node_area * motions)
    return np.einsum("ab,bnk->ank", np.linalg.inv(np.linalg.cholesky(products)), motions)


def _unheld_motions(x: Floats, prescribed: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Rigid motions of nodes, and their combinations that are zero at prescribed components.

    Returns
    -------
    modes : (2 n, 3) float
        Rows are (node, component), columns the two translations and the rotation.
    loose : (m, 3) float
    """
    modes = rigid_body_modes(x, np.ones(x.shape, bool))
    fixed = modes[prescribed.ravel()]
    _, sizes, directions = np.linalg.svd(fixed.T @ fixed)
    return modes, directions[sizes <= 1e-12 * max(1.0, len(fixed))]


def _unheld(grid: Grid, nodes: Ints | slice, force: Floats) -> str:
    """Describe the resultant of the loads on a part without sufficient support."""
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
