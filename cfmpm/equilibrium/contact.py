"""Frictionless unilateral contact of crack faces."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, hstack

from cfmpm.body.crack_faces import FacePairs, Turning, face_pairs, turning_of
from cfmpm.body.grid import Floats, Grid
from cfmpm.body.loads import Loading
from cfmpm.equilibrium.complementarity import Flexibility, Solver
from cfmpm.errors import SolveError
from cfmpm.linear.engine import NotPositiveDefiniteError
from cfmpm.linear.solvers import Factor, Solution

# Overlap, relative to the largest displacement, that is round-off.
TOUCH = 1e-10
# How much further than what it touches a spring that stands in for a free part yields to a force,
# and how often it is let go, at the most.
SOFT = 1e4
LETTINGS_GO = 30
# Factor by which its force has to fall each time, else it is made softer by that, up to a limit.
SLOW, SOFTEST = 10.0, 1e9


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
    free : (2 n, m) float
        Rigid motions of parts without support, in that shape: `Loading.free_motions`.
    """

    pairs: FacePairs
    shape: Floats
    opening: Floats
    push: csc_array
    turnings: tuple[tuple[slice, Turning], ...] = ()
    free: Floats = field(default_factory=lambda: np.zeros((0, 0)))

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

    def at_rest(self, loading: Loading) -> Faces:
        """Return the undeformed faces, for small strain.

        Parameters
        ----------
        loading : Loading
            What is prescribed, and which parts are free.
        """
        supported = loading.supported
        cracks = [face_pairs(self.grid, crack) for crack in self.grid.crack_faces]
        pairs = _joined([_kept(pairs, _movable(pairs, supported)) for pairs in cracks])
        nothing = np.zeros((len(self.grid.nodes), 2))
        return Faces(
            pairs,
            nothing,
            np.zeros(len(pairs.left)),
            _nodal_forces(pairs, len(nothing)),
            free=loading.free_motions(self.grid.nodes),
        )

    def turned(self, loading: Loading, displacement: Floats) -> Faces:
        """Return the faces in a deformed shape of the body, with rotated normals.

        Parameters
        ----------
        loading : Loading
        displacement : (n, 2) float
            Of the body [mm].
        """
        shape, supported = self.carried + displacement, loading.supported
        turnings, cracks, columns, begin = [], [], [], 0
        for crack in self.grid.crack_faces:
            turning = turning_of(self.grid, crack, shape)
            movable = _movable(face_pairs(self.grid, crack), supported)
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
        free = loading.free_motions(self.grid.nodes + shape)
        return Faces(pairs, shape, pairs.opening(shape), push, tuple(turnings), free)


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
    parting = faces.push.T @ faces.free
    if parting.any():
        pressed, moved = _force_beside_free_parts(gap, slack, free_push, parting, factor)
    else:
        pressed, moved = Flexibility(free_push, factor).complementary_force(gap, slack), np.zeros(0)
    closed = displacement.copy()
    if moved.any():
        closed += (faces.free @ moved).reshape(-1, 2)
    closed[~prescribed] += factor.solve(free_push @ pressed).x
    return Contact(closed, faces.force(pressed), pressed)


def _force_beside_free_parts(
    gap: Floats, slack: float, push: csc_array, parting: Floats, factor: Solver
) -> tuple[Floats, Floats]:
    """Find the forces of the pairs where parts of the body are free to move.

    Parameters
    ----------
    gap, slack, push, factor
        As of `Flexibility.complementary_force`, of the body with its free parts held.
    parting : (k, m) float
        Openings of the pairs by the motions of the parts.

    Returns
    -------
    pressed : (k,) float
        Without a resultant on any motion: parting^T pressed = 0.
    moved : (m,) float
        How far the parts go.

    Notes
    -----
    The potential energy is to be least over the motions a as well. That is the proximal point
    method (Rockafellar 1976): springs without force at a stand in for the holds, by `SOFT` softer
    than the body; in each round the parts go to where the springs are strained to, and the springs
    are let go. What is left of their forces falls by about that factor each time.
    """
    size = np.abs(parting).max(axis=0)
    parting = parting / np.where(size > 1e-9 * size.max(), size, np.inf)
    flexibility = Flexibility(push, factor)
    softest = flexibility.largest(gap < -slack)
    yields, last = SOFT * softest, math.inf
    moved = np.zeros(parting.shape[1])
    for _ in range(LETTINGS_GO):
        springs = math.sqrt(yields) * parting
        pressed = flexibility.complementary_force(gap + parting @ moved, slack, springs)
        left = parting.T @ pressed
        moved += yields * left
        exact = flexibility.force_beside_motions(gap + parting @ moved, slack, parting, pressed > 0)
        if exact is not None:
            pressed, moved = exact[0], moved + exact[1]
            return pressed, np.divide(moved, size, where=size > 0.0, out=np.zeros_like(moved))
        if np.abs(parting @ left).max() * softest <= slack / SOFT:
            return pressed, np.divide(moved, size, where=size > 0.0, out=np.zeros_like(moved))
        # What a body yields in all can be much more than a pair does.
        if np.abs(left).max() > last / SLOW and yields < SOFTEST * softest:
            yields *= SLOW
        last = float(np.abs(left).max())
    raise SolveError(
        f"contact of crack faces: {LETTINGS_GO} rounds of moving a part of the body that is cut "
        "off have not brought it to rest beside the others"
    )


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
