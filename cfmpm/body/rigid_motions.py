"""Rigid motions of a body and its parts: which the supports leave, and how they are held."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from cfmpm.body.grid import Floats, Grid, Ints
from cfmpm.errors import Problem, SceneError
from cfmpm.linear.solvers import rigid_body_modes

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


def hold_rigid_motions(
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
        resultant = force[nodes].ravel() @ modes
        scale = np.abs(force[nodes]).sum()
        if np.abs(loose @ resultant).max() > BALANCE * scale:
            reason = _unheld(grid, nodes, force[nodes])
            raise UnheldError([Problem(reason, "loads")], x.mean(axis=0))
        motions = modes @ loose.T
        number = np.arange(len(grid.nodes))[nodes]
        holds = []
        for _ in loose:
            # Hold what moves most, and take from all others what that holds of them.
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
    """Return the rigid motions of the whole body that nothing holds; see `Loading.loose`.

    Of the whole body, so that taking them out leaves parts in contact where they are.
    """
    modes, loose = _unheld_motions(grid.nodes, prescribed)
    motions = (loose @ modes.T).reshape(len(loose), *grid.nodes.shape)
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
    _, sizes, directions = np.linalg.svd(fixed.T @ fixed)
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
