"""Frictionless unilateral contact of crack faces."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import csc_array, hstack

from cfmpm.body.crack_faces import FacePairs, Turning, face_pairs, turning_of
from cfmpm.body.grid import Floats, Grid, Ints
from cfmpm.errors import SolveError
from cfmpm.linear.engine import NotPositiveDefiniteError
from cfmpm.linear.solvers import Factor, Solution

# Overlap, relative to the largest displacement, that is round-off.
TOUCH = 1e-10
# Block pivots without a decrease of the number of infeasible pairs before single pivots are done,
# and the largest number of pivoting steps.
PATIENCE = 5
ROUNDS = 200
# A pivot below this fraction of its diagonal entry is round-off.
NOISE = 1e-15


class Solver(Protocol):
    """A solver of linear systems with the stiffness."""

    def solve(self, b: Floats, /) -> Solution:
        """Solve for the free components."""
        ...


@dataclass(frozen=True)
class Contact:
    """Solution of a contact problem.

    Attributes
    ----------
    displacement : (n, 2) float
        Displacement of the nodes, without overlap of crack faces [mm].
    force : (n, 2) float
        Contact forces at the nodes [N/mm].
    pressed : (k,) float
        Contact force of each pair of nodes along its normal [N/mm].
    """

    displacement: Floats
    force: Floats
    pressed: Floats

    @property
    def pairs(self) -> int:
        """Number of closed pairs of nodes."""
        return int(np.count_nonzero(self.pressed))


@dataclass(frozen=True)
class Faces:
    """The faces of all cracks in a deformed shape of the body.

    Attributes
    ----------
    pairs : FacePairs
        Without pairs whose opening is prescribed by supports.
    shape : (n, 2) float
        Displacement of the nodes [mm].
    opening : (k,) float
        Openings in that shape [mm].
    push : (2 n, k) csc_array
        Derivative of the openings by the displacement, which is the nodal force by a unit force of
        each pair. As the normals turn with the edges, it has no moment even after sliding.
    turnings : tuple of (slice, Turning)
        The pairs of each crack and its rotation; empty at small strain.
    """

    pairs: FacePairs
    shape: Floats
    opening: Floats
    push: csc_array
    turnings: tuple[tuple[slice, Turning], ...] = ()

    def force(self, pressed: Floats) -> Floats:
        """Nodal forces from the forces of the pairs [N/mm], (n, 2)."""
        force: Floats = (self.push @ pressed).reshape(-1, 2)
        return force


@dataclass(frozen=True)
class CrackFaces:
    """The crack faces of a body for contact.

    Attributes
    ----------
    grid : Grid
        The grid in which the faces are closed.
    carried : (n, 2) float or 0
        Displacement of its nodes at zero displacement of the body [mm].
    """

    grid: Grid
    carried: Floats | float = 0.0

    def at_rest(self, prescribed: NDArray[np.bool_]) -> Faces:
        """Return the undeformed faces, for small strain.

        Parameters
        ----------
        prescribed : (n, 2) bool
            Components of displacement that are prescribed.
        """
        cracks = [face_pairs(self.grid, crack) for crack in self.grid.crack_faces]
        pairs = _joined([_kept(pairs, _movable(pairs, prescribed)) for pairs in cracks])
        nothing = np.zeros((len(self.grid.nodes), 2))
        return Faces(pairs, nothing, np.zeros(len(pairs.left)), _nodal_forces(pairs, len(nothing)))

    def turned(self, prescribed: NDArray[np.bool_], displacement: Floats) -> Faces:
        """Return the faces in a deformed shape of the body, with rotated normals.

        Parameters
        ----------
        prescribed : (n, 2) bool
        displacement : (n, 2) float
            Of the body [mm].
        """
        shape = self.carried + displacement
        turnings, cracks, columns, begin = [], [], [], 0
        for crack in self.grid.crack_faces:
            turning = turning_of(self.grid, crack, shape)
            movable = _movable(face_pairs(self.grid, crack), prescribed)
            pairs = _kept(face_pairs(self.grid, crack, turning), movable)
            jump = shape[pairs.left] - shape[pairs.right]
            # After sliding, a rotation of the normal also changes the opening.
            slid = np.einsum("ki,ki->k", jump, _turned_by_quarter(pairs.normal))
            columns.append(_nodal_forces(pairs, len(shape)) + _outer(turning, slid, len(shape)))
            turnings.append((slice(begin, begin + len(slid)), turning))
            cracks.append(pairs)
            begin += len(slid)
        pairs = _joined(cracks)
        push = csc_array(hstack(columns, format="csc"))
        return Faces(pairs, shape, pairs.opening(shape), push, tuple(turnings))


def close_faces(
    faces: Faces, prescribed: NDArray[np.bool_], displacement: Floats, factor: Solver
) -> Contact:
    """Solve for contact of the crack faces that overlap in a linear solution.

    Each pair of coincident nodes has an opening g >= 0 and a force p >= 0 along its normal, one of
    which is zero (Signorini 1959). With the derivative C of the openings by the displacement,
    g = g0 + C K^-1 C^T p: a symmetric positive definite linear complementarity problem with one
    unknown per pair. At small strain its solution is proportional to the load.

    Parameters
    ----------
    faces : Faces
        In a nearby shape.
    prescribed : (n, 2) bool
        Components of displacement that are prescribed.
    displacement : (n, 2) float
        Solution without contact [mm].
    factor : Solver
        Factored stiffness of the free components.

    Returns
    -------
    Contact
        With the given `displacement` if nothing overlaps.

    Raises
    ------
    SolveError
        If no set of closed pairs is found.

    Notes
    -----
    A uniform pressure p on an edge of length l gives nodal forces p l (1/2, 1/2) for T3 and
    p l (1, 4, 1) / 6 for T6, all compressive, so that their sign distinguishes closed from open
    pairs. A nodal force over the length of these rules is the pressure only in the mean. If the
    pressure varies within an edge of T6, a corner may open under it within the discretisation
    error.
    """
    gap = faces.opening + faces.push.T @ (displacement - faces.shape).ravel()
    slack = TOUCH * np.abs(displacement).max(initial=0.0)
    if not (gap < -slack).any():
        return Contact(displacement, np.zeros_like(displacement), np.zeros(len(gap)))
    free_push = faces.push[np.flatnonzero(~prescribed.ravel())]
    pressed = _complementary_force(gap, slack, free_push, factor)
    closed = displacement.copy()
    closed[~prescribed] += factor.solve(free_push @ pressed).x
    return Contact(closed, faces.force(pressed), pressed)


class TurningStiffness:
    """A factored stiffness with the contribution of rotating closed crack faces.

    Newton's method for the energy minus the work of the forces p on the openings g has the
    stiffness K - sum p d2g/du2. As all normals of a crack turn by one angle a, this is
    K + a' w^T + w a'^T, two columns for each crack. w contains the forces rotated by 90 degrees,
    the sliding and the stretch of the faces. It is solved with the factored K by the identity of
    Sherman, Morrison and Woodbury.

    Parameters
    ----------
    factor : Factor
        Factored stiffness K of the free components.
    faces : Faces
        In the shape in which K was assembled.
    prescribed : (n, 2) bool
    pressed : (k,) float
        Forces of the pairs, not all zero [N/mm].

    Raises
    ------
    NotPositiveDefiniteError
        If the closed faces are unstable against rotation.
    """

    def __init__(
        self, factor: Factor, faces: Faces, prescribed: NDArray[np.bool_], pressed: Floats
    ) -> None:
        self._factor = factor
        columns = []
        for part, turning in faces.turnings:
            if not pressed[part].any():
                continue
            angle, pushed = np.zeros_like(faces.shape), np.zeros_like(faces.shape)
            angle[turning.nodes] = turning.angle_slope
            left, right = faces.pairs.left[part], faces.pairs.right[part]
            forces = pressed[part, None] * _turned_by_quarter(faces.pairs.normal[part])
            np.add.at(pushed, left, forces)
            np.add.at(pushed, right, -forces)
            slid = np.sum(forces * (faces.shape[left] - faces.shape[right]))
            other = 0.5 * (pressed[part] @ faces.opening[part]) * angle - pushed
            other[turning.nodes] += slid * turning.stretch_slope
            columns += [angle[~prescribed], other[~prescribed]]
        self._columns = np.array(columns)
        self._solved = np.array([factor.solve(column).x for column in columns])
        # [0 1; 1 0] for each crack is its own inverse.
        self._small = np.kron(np.eye(len(columns) // 2), [[0.0, 1.0], [1.0, 0.0]])
        self._small += self._columns @ self._solved.T
        # By Haynsworth's inertia additivity, with positive definite K the sum is positive definite
        # if this matrix has as many positive as negative eigenvalues.
        if np.count_nonzero(np.linalg.eigvalsh(self._small) > 0.0) != len(columns) // 2:
            raise NotPositiveDefiniteError("closed crack faces slide off as they rotate")

    def solve(self, b: Floats) -> Solution:
        """Solve for the free components, as `Factor.solve` does."""
        plain = self._factor.solve(b)
        part = np.linalg.solve(self._small, self._columns @ plain.x)
        return replace(plain, x=plain.x - part @ self._solved)


def _turned_by_quarter(vectors: Floats) -> Floats:
    return np.column_stack([-vectors[:, 1], vectors[:, 0]])


def _movable(pairs: FacePairs, prescribed: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Find the undeformed pairs whose opening is not prescribed by supports."""
    held = prescribed[pairs.left] & prescribed[pairs.right]
    return np.asarray((np.abs(pairs.normal * ~held) > 1e-9).any(axis=1))


def _kept(pairs: FacePairs, which: NDArray[np.bool_]) -> FacePairs:
    return FacePairs(pairs.left[which], pairs.right[which], pairs.normal[which])


def _joined(cracks: list[FacePairs]) -> FacePairs:
    return FacePairs(
        *(
            np.concatenate([getattr(pairs, name) for pairs in cracks])
            for name in ("left", "right", "normal")
        )
    )


def _nodal_forces(pairs: FacePairs, n_nodes: int) -> csc_array:
    """Nodal force components by a unit force in each pair, (2 n, k)."""
    rows = [2 * nodes + axis for nodes in (pairs.left, pairs.right) for axis in (0, 1)]
    values = np.concatenate([pairs.normal.T, -pairs.normal.T])
    columns = np.broadcast_to(np.arange(len(pairs.left)), values.shape)
    return csc_array(
        (values.ravel(), (np.concatenate(rows), columns.ravel())),
        shape=(2 * n_nodes, len(pairs.left)),
    )


def _outer(turning: Turning, slid: Floats, n_nodes: int) -> csc_array:
    """Derivative of the openings by the rotation of the normals, (2 n, k)."""
    rows = (2 * turning.nodes[:, None] + np.arange(2)).ravel()
    angle = turning.angle_slope.ravel()
    columns = np.repeat(np.arange(len(slid)), len(rows))
    return csc_array(
        (np.outer(slid, angle).ravel(), (np.tile(rows, len(slid)), columns)),
        shape=(2 * n_nodes, len(slid)),
    )


def _complementary_force(gap: Floats, slack: float, push: csc_array, factor: Solver) -> Floats:
    """Find the forces of the pairs by block pivoting (Judice and Pires 1994), (k,).

    All pairs in tension or with overlap are exchanged at once, which is the primal-dual active set
    method (Hintermueller, Ito and Kunisch 2002). If their number does not decrease, only the last
    of them is exchanged, which cannot cycle (Murty 1974).
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
        opening = gap + flexibility @ force
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
        f"contact of crack faces: after {ROUNDS} steps of block pivoting and single pivoting "
        f"{count} of {k} pairs of nodes still overlap or are in tension, {fewest} at best; "
        "smaller elements along the crack, or grading: uniform, may help"
    )


def _closing_force(flexibility: Floats, gap: Floats, closed: Ints) -> Floats:
    """Forces that close the given pairs, with zero force in the others."""
    if not len(closed):
        return np.zeros(0)
    matrix = flexibility[np.ix_(closed, closed)]
    try:
        factor = cho_factor(matrix)
        sound = np.square(factor[0].diagonal()) > NOISE * matrix.diagonal()
    except np.linalg.LinAlgError:
        sound = np.zeros(1, bool)
    if not sound.all():
        raise SolveError(
            f"contact of crack faces: {len(closed)} pairs of nodes cannot all be closed, since "
            "their openings are linearly dependent; check for cracks that cross or meet at a "
            "small angle"
        )
    return np.asarray(cho_solve(factor, -gap[closed]))
