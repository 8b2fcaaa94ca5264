"""Forces of pairs of crack face nodes that press or part: a linear complementarity problem."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import csc_array

from cfmpm.body.grid import Floats
from cfmpm.errors import SolveError
from cfmpm.linear.solvers import Solution

# Block pivots without a decrease of the number of infeasible pairs before single pivots are done,
# and the largest number of pivoting steps.
PATIENCE = 5
ROUNDS = 200
# A pivot below this fraction of its diagonal entry is round-off.
NOISE = 1e-15
ROUND_OFF = float(np.finfo(float).eps)
# Block pivots with motions as unknowns before the springs are softened again; and the part of the
# largest below which closed pairs do not determine a motion.
ATTEMPTS, UNDETERMINED = 20, 1e-10


class Solver(Protocol):
    """A solver of linear systems with the stiffness."""

    def solve(self, b: Floats, /) -> Solution:
        """Solve for the free components."""
        ...


class Flexibility:
    """Openings by unit forces of the pairs, found column by column as pairs close.

    Parameters
    ----------
    push : (2 n, k) csc_array
        Forces on the free components by unit forces of the pairs.
    factor : Solver
    """

    def __init__(self, push: csc_array, factor: Solver) -> None:
        k = push.shape[1]
        self._push, self._factor = push, factor
        self._matrix = np.zeros((k, k))
        self._known = np.zeros(k, bool)

    def _find(self, pairs: NDArray[np.bool_]) -> None:
        """Find the columns of pairs."""
        for j in np.flatnonzero(pairs & ~self._known):
            unit = self._push[:, [j]].toarray().ravel()
            self._matrix[:, j] = self._push.T @ self._factor.solve(unit).x
        self._known |= pairs

    def largest(self, pairs: NDArray[np.bool_]) -> float:
        """Return the largest opening that a unit force in one of these pairs makes there [mm]."""
        self._find(pairs)
        return float(self._matrix.diagonal()[pairs].max())

    def complementary_force(
        self, gap: Floats, slack: float, yielding: Floats | None = None
    ) -> Floats:
        """Find the forces of the pairs by block pivoting (Judice and Pires 1994), (k,).

        Parameters
        ----------
        gap : (k,) float
            Openings without forces [mm].
        slack : float
            Overlap below which faces only touch [mm].
        yielding : (k, m) float, optional
            Of parts on springs: the openings are more by yielding yielding^T p.

        Raises
        ------
        SolveError
            Where no set of closed pairs is found.

        Notes
        -----
        All pairs in tension or with overlap are exchanged at once, which is the primal-dual active
        set method (Hintermueller, Ito and Kunisch 2002). If their number does not decrease, only
        the last of them is exchanged, which cannot cycle (Murty 1974).
        """
        k = len(gap)
        more = np.zeros((k, 0)) if yielding is None else yielding
        closed = gap < -slack
        fewest, patience = k + 1, PATIENCE
        for _ in range(ROUNDS):
            self._find(closed)
            force = np.zeros(k)
            chosen = self._matrix[np.ix_(closed, closed)] + more[closed] @ more[closed].T
            force[closed] = _closing_force(chosen, gap[closed])
            opening = gap + self._matrix @ force + more @ (more.T @ force)
            # What soft springs yield to is known to the round-off of the sum of its forces only.
            noise = ROUND_OFF * (np.abs(more) @ (np.abs(more).T @ np.abs(force)))
            wrong = np.where(closed, force < 0.0, opening < -slack - noise)
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
            f"contact of crack faces: after {ROUNDS} steps of block pivoting and single pivoting "
            f"{count} of {k} pairs of nodes still overlap or are in tension, {fewest} at best; "
            "smaller elements along the crack, or grading: uniform, may help"
        )

    def force_beside_motions(
        self, gap: Floats, slack: float, parting: Floats, closed: NDArray[np.bool_]
    ) -> tuple[Floats, Floats] | None:
        """Find the forces of the pairs together with rigid motions that nothing resists.

        Parameters
        ----------
        gap, slack
            As of `complementary_force`.
        parting : (k, m) float
            Openings of the pairs by the motions.
        closed : (k,) bool
            Pairs that are closed, to begin with.

        Returns
        -------
        force : (k,) float
            Without a resultant on any motion: parting^T force = 0.
        moved : (m,) float
            The motions. What no closed pair determines stays 0.
        None
            If block pivoting from the given pairs does not end.

        Notes
        -----
        Closed pairs with the flexibility M and the openings P by the motions have
        M p + P a = -gap and P^T p = 0, which is solved for a by its Schur complement.
        """
        closed = closed.copy()
        for _ in range(ATTEMPTS):
            if not closed.any():
                return None
            self._find(closed)
            chosen, of_motions = self._matrix[np.ix_(closed, closed)], parting[closed]
            solved = _closing_force(chosen, np.column_stack([gap[closed], of_motions]))
            left = of_motions.T @ solved
            found = np.linalg.lstsq(left[:, 1:], left[:, 0], rcond=UNDETERMINED)[0]
            moved = -np.asarray(found, float)
            force = np.zeros(len(gap))
            force[closed] = solved[:, 0] + solved[:, 1:] @ moved
            yielded = self._matrix @ force
            wrong = np.where(closed, force < 0.0, gap + yielded + parting @ moved < -slack)
            if not wrong.any():
                # Parts that have gone so far that they only touch do not press.
                beside = parting.any(axis=1)
                if np.abs(yielded[beside]).max() <= slack:
                    force[beside] = 0.0
                return force, moved
            closed ^= wrong
        return None


def _closing_force(flexibility: Floats, gap: Floats) -> Floats:
    """Forces that close the pairs of a flexibility, (k,) or (k, j) for j gaps of each."""
    if not len(gap):
        return np.zeros_like(gap)
    try:
        factor = cho_factor(flexibility)
        sound = np.square(factor[0].diagonal()) > NOISE * flexibility.diagonal()
    except np.linalg.LinAlgError:
        sound = np.zeros(1, bool)
    if not sound.all():
        raise SolveError(
            f"contact of crack faces: {len(gap)} pairs of nodes cannot all be closed, since "
            "their openings are linearly dependent; check for cracks that cross or meet at a "
            "small angle"
        )
    return np.asarray(cho_solve(factor, -gap))
