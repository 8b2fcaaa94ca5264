"""Rigid motions of a body and its parts that no support prevents, and how they are held."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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


@dataclass(frozen=True)
class FreePart:
    """A part of a body that has come apart, with rigid motions that no support holds.

    The program holds these motions at single nodes so that there is one solution, but the holds may
    not carry a force: what touches the part moves it.

    Attributes
    ----------
    nodes : (k,) int
    loose : (r, 3) float
        Sums of its two translations and its rotation that move nothing that is prescribed.
    centre : (2,) float
        Of its nodes [mm].
    """

    nodes: Ints
    loose: Floats
    centre: Floats

    def motions(self, x: Floats, supported: NDArray[np.bool_]) -> Floats:
        """Return its loose motions as displacements of all nodes, (n, 2, r).

        Parameters
        ----------
        x : (n, 2) float
            Where the nodes are [mm].
        supported : (n, 2) bool
            Components that loads and supports prescribe.
        """
        modes = rigid_body_modes(x[self.nodes], np.ones((len(self.nodes), 2), bool))
        motions = np.zeros((*x.shape, len(self.loose)))
        motions[self.nodes] = (modes @ self.loose.T).reshape(len(self.nodes), 2, -1)
        motions[supported] = 0.0  # which they are, but for round-off and what has turned
        return motions


@dataclass(frozen=True)
class Holds:
    """Where the program holds rigid motions that no support holds.

    Attributes
    ----------
    places : (h, 2) int
        Node and component of each.
    turning : (r, 2) int
        Those of them that hold a rotation on which loads may work once the body bends, at most one
        for each part.
    free_parts : tuple of FreePart
        Of a body in several parts; one in a single part has no other to push it.
    """

    places: Ints
    turning: Ints
    free_parts: tuple[FreePart, ...] = ()

    @classmethod
    def none(cls) -> Holds:
        """No hold."""
        nowhere = np.zeros((0, 2), np.int64)
        return cls(nowhere, nowhere)


def hold_rigid_motions(grid: Grid, prescribed: NDArray[np.bool_], force: Floats) -> Holds:
    """Hold, in place, the motions of each connected part that nothing holds.

    Parameters
    ----------
    grid : Grid
    prescribed : (n, 2) bool
        By loads and supports; the holds are added.
    force : (n, 2) float
        Of the loads [N/mm].

    Raises
    ------
    UnheldError
        Where loads work on such a motion.
    """
    element_part = grid.parts
    node_part = np.empty(len(grid.nodes), np.int64)
    node_part[grid.elements] = element_part[:, None]
    places: list[tuple[int, int]] = []
    turning: list[tuple[int, int]] = []
    free_parts: list[FreePart] = []
    for part in range(element_part.max() + 1):
        nodes = np.flatnonzero(node_part == part)
        x = grid.nodes[nodes]
        modes, loose = _unheld_motions(x, prescribed[nodes])
        if len(loose) == 0:
            continue
        resultant = force[nodes].ravel() @ modes
        scale = np.abs(force[nodes]).sum()
        if np.abs(loose @ resultant).max() > BALANCE * scale:
            reason = _unheld(grid, nodes, force[nodes])
            raise UnheldError([Problem(reason, "loads")], x.mean(axis=0))
        if element_part.any():
            free_parts.append(FreePart(nodes, loose, x.mean(axis=0)))
        # What is not loaded at all does not turn as it is deformed.
        loaded = not element_part.any() or force[nodes].any() or prescribed[nodes].any()
        motions = modes @ loose.T
        holds: list[tuple[int, int]] = []
        for _ in loose:
            # Hold the component with the largest motion, and make the others orthogonal to it.
            chosen = int((motions**2).sum(axis=1).argmax())
            holds.append((int(nodes[chosen // 2]), chosen % 2))
            prescribed[holds[-1]] = True
            along = motions[chosen] / np.hypot.reduce(motions[chosen])
            motions = motions - np.outer(motions @ along, along)
        places += holds
        for place in holds if loaded else ():
            prescribed[place] = False
            _, (motion,) = _unheld_motions(x, prescribed[nodes])
            prescribed[place] = True
            if abs(motion[2]) > 1e-6:
                turning.append(place)
                break
    return Holds(
        np.array(places, np.int64).reshape(-1, 2),
        np.array(turning, np.int64).reshape(-1, 2),
        tuple(free_parts),
    )


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
