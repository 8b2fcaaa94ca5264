"""Unilateral contact of crack faces without friction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from cfmpm.errors import SolveError
from cfmpm.fracture.opening import FacePairs, face_pairs
from cfmpm.grid import Floats, Grid, Ints
from cfmpm.kernels.dense import cholesky_solve
from cfmpm.solvers import Factor

# Overlap, relative to the largest displacement, below which faces only touch.
TOUCH = 1e-10
# Rounds in which all wrong pairs change places without there being fewer of them, before they
# change one at a time; and rounds altogether.
PATIENCE = 5
ROUNDS = 200


@dataclass(frozen=True)
class Contact:
    """What the faces of cracks do to each other.

    Attributes
    ----------
    displacement : (n, 2) float
        Of the nodes, with the faces kept apart [mm].
    force : (n, 2) float
        That the faces exert on each other, at their nodes [N/mm].
    pairs : int
        Number of pairs of nodes that are closed.
    """

    displacement: Floats
    force: Floats
    pairs: int


def close_faces(
    grid: Grid,
    prescribed: NDArray[np.bool_],
    displacement: Floats,
    factor: Factor,
    shape: Floats | None = None,
) -> Contact:
    """Press apart the crack faces that overlap in a linear solution.

    Each pair of coincident nodes has an opening g >= 0 and a force p >= 0 along its normal, one of
    which is zero (Signorini 1959). With C the openings per displacement, g = g0 + C K^-1 C^T p: a
    linear complementarity problem with as many unknowns as there are pairs, symmetric positive
    definite. Its solution grows in proportion to the load.

    Parameters
    ----------
    grid : Grid
    prescribed : (n, 2) bool
        Components of displacement that are prescribed.
    displacement : (n, 2) float
        In balance without contact [mm].
    factor : Factor
        Of the stiffness of the free components.
    shape : (n, 2) float, optional
        Displacement with which the faces and their normals turn, at finite deformation [mm].

    Returns
    -------
    Contact
        With `displacement` as it came where nothing overlaps.

    Raises
    ------
    SolveError
        Where no set of closed pairs is found.

    Notes
    -----
    A uniform pressure p on an edge of length l makes nodal forces p l (1/2, 1/2) in T3 and
    p l (1, 4, 1) / 6 in T6, all of them compressive: their sign tells closed from open. A nodal
    force divided by the length in these rules is a pressure in the mean only. Where pressure
    changes within an edge of T6, a corner may open under it by as much as the grid can tell.
    """
    nothing = Contact(displacement, np.zeros_like(displacement), 0)
    if not grid.crack_faces:
        return nothing
    pairs = _movable([face_pairs(grid, crack, shape) for crack in grid.crack_faces], prescribed)
    gap = pairs.opening(displacement)
    slack = TOUCH * np.abs(displacement).max(initial=0.0)
    if not (gap < -slack).any():
        return nothing
    push = _nodal_forces(pairs, len(grid.nodes))
    free_push = push[np.flatnonzero(~prescribed.ravel())]
    force = _complementary_force(gap, slack, free_push, factor)
    closed = displacement.copy()
    closed[~prescribed] += factor.solve(free_push @ force).x
    return Contact(closed, (push @ force).reshape(-1, 2), int(np.count_nonzero(force)))


def _movable(cracks: list[FacePairs], prescribed: NDArray[np.bool_]) -> FacePairs:
    """Join the pairs of all cracks, but for those whose opening the supports prescribe."""
    left, right, normal = (
        np.concatenate([getattr(pairs, name) for pairs in cracks])
        for name in ("left", "right", "normal")
    )
    held = prescribed[left] & prescribed[right]
    movable = (np.abs(normal * ~held) > 1e-9).any(axis=1)
    return FacePairs(left[movable], right[movable], normal[movable])


def _nodal_forces(pairs: FacePairs, n_nodes: int) -> csc_array:
    """Forces on all components of displacement by a unit force in each pair, (2 n, k)."""
    rows = [2 * nodes + axis for nodes in (pairs.left, pairs.right) for axis in (0, 1)]
    values = np.concatenate([pairs.normal.T, -pairs.normal.T])
    columns = np.broadcast_to(np.arange(len(pairs.left)), values.shape)
    return csc_array(
        (values.ravel(), (np.concatenate(rows), columns.ravel())),
        shape=(2 * n_nodes, len(pairs.left)),
    )


def _complementary_force(gap: Floats, slack: float, push: csc_array, factor: Factor) -> Floats:
    """Find the forces of the pairs by block pivoting (Judice and Pires 1994), (k,).

    All pairs that pull or overlap change places at once, which is the primal-dual active set
    method (Hintermueller, Ito and Kunisch 2002). Where that does not make them fewer, only the
    last of them does, which cannot cycle (Murty 1974).
    """
    k = len(gap)
    # Openings by a unit force in a pair, column by column, of the pairs closed so far.
    flexibility = np.zeros((k, k))
    known = np.zeros(k, bool)
    closed = gap < -slack
    fewest, patience = k + 1, PATIENCE
    for _ in range(ROUNDS):
        for j in np.flatnonzero(closed & ~known):
            flexibility[:, j] = push.T @ factor.solve(push[:, [j]].toarray().ravel()).x
        known |= closed
        force = np.zeros(k)
        force[closed] = _closing_force(flexibility, gap, np.flatnonzero(closed))
        opening = gap + np.einsum("ij,j->i", flexibility, force)
        wrong = np.where(closed, force < 0.0, opening < -slack)
        count = int(wrong.sum())
        if count == 0:
            return force
        if count < fewest:
            fewest, patience = count, PATIENCE
        elif patience:
            patience -= 1
        else:
            wrong[: np.flatnonzero(wrong)[-1]] = False
        closed ^= wrong
    raise SolveError(
        f"contact of crack faces: after {ROUNDS} rounds of closing what overlaps and opening what "
        f"pulls, all at once and then one at a time, {count} of {k} pairs of nodes are still "
        f"wrong, {fewest} at best; smaller elements along the crack, or grading: uniform, may help"
    )


def _closing_force(flexibility: Floats, gap: Floats, closed: Ints) -> Floats:
    """Forces that close the given pairs, and leave the others free."""
    force = cholesky_solve(flexibility[np.ix_(closed, closed)], -gap[closed])
    if np.isnan(force).any():
        raise SolveError(
            f"contact of crack faces: {len(closed)} pairs of nodes cannot all be closed, as their "
            "openings depend on each other; look for cracks that cross or meet at a flat angle"
        )
    return force
