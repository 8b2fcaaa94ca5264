"""Linear solvers for the symmetric positive definite stiffness, behind one small interface.

``select(n)`` picks a solver; ``solver.factor(K)`` gives a `Factor`, which solves as often as
wanted and takes new values on the old pattern by ``refactor(K)``. Every solver refuses a matrix
that is singular or has a negative pivot: a mechanism or a loss of stability is never answered by
numbers.

======== ============================== =====================================================
name     what                           needs
======== ============================== =====================================================
cholmod  supernodal L L^T               the extra ``fast`` (kvxopt, which bundles CHOLMOD; GPL)
rslab    supernodal L D L^T             rslab (MIT)
superlu  L U in symmetric mode          nothing beyond SciPy
amg      smoothed aggregation with CG   nothing beyond PyAMG; least memory
======== ============================== =====================================================
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csc_array, csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from cfmpm.errors import SolveError

Floats = NDArray[np.float64]

SUPERLU_LIMIT = 200_000
"""Unknowns up to which ``auto`` takes SuperLU where no fast direct solver is installed.

Measured: as fast as the multigrid at 100 000, half as fast with 1.5 GB at 300 000.
"""

SINGULAR = 1e13
"""Growth of a probe vector beyond which a factored matrix counts as singular.

Sound plane problems of a million unknowns reach 1e4, a part without support 1e15 and more.
"""

BACKWARD_ERROR = 1e-10
"""Largest residual of a direct solve, relative to ``|K| |x| + |b|``."""

CG_TOLERANCE = 1e-10
CG_ITERATIONS = 500

log = logging.getLogger(__name__)


class NotPositiveDefiniteError(SolveError):
    """The stiffness has a pivot that is zero or negative.

    Attributes
    ----------
    unknown : int or None
        The unknown at whose pivot it was seen, counted among the free ones.
    negative_pivots : int or None
        How many pivots are negative; None where the solver stops at the first one.
    """

    def __init__(
        self, seen: str, *, unknown: int | None = None, negative_pivots: int | None = None
    ) -> None:
        self.unknown = unknown
        self.negative_pivots = negative_pivots
        super().__init__(
            f"the stiffness is not positive definite: {seen}. Either a part of the body is a "
            "mechanism (no support, or it hangs by a single node), or the state has lost its "
            "stability (a limit point or a material past its strength); a smaller load step or "
            "prescribed displacements help only in the second case"
        )


@dataclass(frozen=True)
class Solution:
    """What a solve gave.

    Attributes
    ----------
    x : (n,) float
        The unknowns.
    residual : float
        ``|b - K x| / |b|`` in the Euclidean norm; 0 where b is zero.
    iterations : int
        Iterations of the conjugate gradients; 0 for a direct solver.
    history : tuple of float
        The residual after each iteration, from the start on.
    """

    x: Floats
    residual: float
    iterations: int = 0
    history: tuple[float, ...] = ()


class Engine(Protocol):
    """What a solver has to provide; it may rely on a checked matrix and right hand side."""

    def __init__(self, K: csr_array, modes: Floats | None) -> None:
        """Analyse the pattern of `K`."""

    def factor(self, K: csr_array) -> None:
        """Take the values of `K`; raise `NotPositiveDefiniteError` on a bad pivot."""

    def solve(self, b: Floats) -> tuple[Floats, tuple[float, ...]]:
        """Return the solution and, from an iterative solver, the history of its residual."""


class Factor:
    """A factored stiffness.

    Attributes
    ----------
    negative_pivots : int
        Always 0: a matrix with a negative pivot raises instead.
    """

    negative_pivots = 0

    def __init__(self, solver: LinearSolver, K: csr_array, modes: Floats | None = None) -> None:
        self._solver = solver
        self._K = _checked(K)
        self._engine: Engine | None = None
        if self.n_unknowns:
            self._engine = solver.engine(self._K, modes)
            self._take_values()

    @property
    def n_unknowns(self) -> int:
        """Size of the system."""
        return int(self._K.shape[0])

    def __repr__(self) -> str:
        return f"<Factor by {self._solver.name}: {self.n_unknowns} unknowns, {self._K.nnz} entries>"

    def refactor(self, K: csr_array) -> None:
        """Take the values of another matrix with the same pattern; the analysis is reused.

        Parameters
        ----------
        K : (n, n) csr_array
        """
        K = _checked(K)
        same = np.array_equal(K.indptr, self._K.indptr) and np.array_equal(
            K.indices, self._K.indices
        )
        if not same:
            raise ValueError("refactor: the pattern of the matrix has changed; factor it anew")
        self._K = K
        self._take_values()

    def solve(self, b: ArrayLike) -> Solution:
        """Solve ``K x = b``.

        Parameters
        ----------
        b : (n,) float

        Returns
        -------
        Solution

        Raises
        ------
        SolveError
            Where b is not finite, the iteration does not converge or the residual is too large.
        """
        b = np.asarray(b, dtype=float)
        if b.shape != (self.n_unknowns,):
            raise ValueError(f"right hand side of shape {b.shape} for {self.n_unknowns} unknowns")
        if not np.isfinite(b).all():
            raise SolveError(
                f"the right hand side is not finite at unknown {_first(~np.isfinite(b))}: "
                "a force was computed from an invalid state"
            )
        if self._engine is None or not b.any():
            return Solution(np.zeros_like(b), 0.0)
        x, history = self._engine.solve(b)
        residual = _norm(b - self._K @ x)
        scale = self._K.diagonal().max() * _norm(x) + _norm(b)
        if not residual <= BACKWARD_ERROR * scale:
            raise SolveError(
                f"{self._solver.name} left a residual of {residual / scale:.1e} relative to "
                f"|K||x| + |b| (allowed {BACKWARD_ERROR:.0e}); is the matrix symmetric?"
            )
        log.debug("%r: residual %.1e", self, residual / _norm(b))
        return Solution(x, float(residual / _norm(b)), max(len(history) - 1, 0), history)

    def _take_values(self) -> None:
        """Factor, then look for a zero pivot that round-off has made small and positive."""
        if self._engine is None:
            return
        self._engine.factor(self._K)
        probe = np.random.default_rng(0).choice([-1.0, 1.0], self.n_unknowns)
        answer, _ = self._engine.solve(self._K.diagonal() * probe)
        growth = np.abs(answer)
        if not growth.max() < SINGULAR:
            raise NotPositiveDefiniteError(
                f"it is singular to round-off (a probe grew to {growth.max():.0e}), "
                f"most of all at unknown {int(growth.argmax())}",
                unknown=int(growth.argmax()),
            )


@dataclass(frozen=True)
class LinearSolver:
    """A way of solving; `select` hands them out."""

    name: str
    engine: type[Engine]

    def factor(self, K: csr_array, modes: Floats | None = None) -> Factor:
        """Factor a stiffness.

        Parameters
        ----------
        K : (n, n) csr_array
            Symmetric positive definite, both triangles stored [N/mm^2].
        modes : (n, 3) float, optional
            `rigid_body_modes` of the unknowns; only ``amg`` reads them, and needs them.

        Returns
        -------
        Factor

        Raises
        ------
        NotPositiveDefiniteError
            Where a pivot is zero or negative.
        SolveError
            Where an entry is not finite.
        """
        return Factor(self, K, modes)


class Cholmod:
    """CHOLMOD's supernodal Cholesky factor, as bundled in kvxopt's wheels.

    kvxopt wants the lower triangle by columns; of a symmetric matrix those are the entries on
    and right of the diagonal, row by row, as they lie in the CSR arrays. Its wheel links the
    factorisation to a serial BLAS, so that the result does not depend on threads.
    """

    def __init__(self, K: csr_array, modes: Floats | None) -> None:
        self._base = import_module("kvxopt.base")
        self._cholmod = import_module("kvxopt.cholmod")
        rows = np.repeat(np.arange(K.shape[0]), np.diff(K.indptr))
        self._half = np.flatnonzero(K.indices >= rows)
        # All-zero values serve: the analysis reads the pattern only.
        matrix = self._base.matrix
        self._values = self._base.spmatrix(
            matrix(np.zeros(self._half.size)),
            matrix(K.indices[self._half].astype(np.int64)),
            matrix(rows[self._half].astype(np.int64)),
            K.shape,
        )
        self._factor = self._cholmod.symbolic(self._values)

    def factor(self, K: csr_array) -> None:
        self._values.V = self._base.matrix(K.data[self._half])
        # kvxopt 1.3 reads the status before it factors: an error raised by `numeric` is about the
        # matrix before this one. `solve` knows, and without a right hand side it only looks.
        with suppress(ArithmeticError):
            self._cholmod.numeric(self._values, self._factor)
        try:
            self._cholmod.solve(self._factor, self._base.matrix(0.0), nrhs=0)
        except ArithmeticError as failure:
            raise NotPositiveDefiniteError("Cholesky met a pivot that is not positive") from failure

    def solve(self, b: Floats) -> tuple[Floats, tuple[float, ...]]:
        x = self._base.matrix(b)
        self._cholmod.solve(self._factor, x)
        return np.array(x).ravel(), ()


class Rslab:
    """L D L^T of the Rust library rslab, on one thread; knows the inertia."""

    def __init__(self, K: csr_array, modes: Floats | None) -> None:
        # Minimum fill costs a quarter of nested dissection and gains most of its speed.
        rslab = import_module("rslab")
        self._symbolic = rslab.analyze(K, path="ldlt", threads=1, ordering="amf")

    def factor(self, K: csr_array) -> None:
        try:
            self._factor = self._symbolic.factor(K)
        except RuntimeError as failure:
            raise NotPositiveDefiniteError(str(failure)) from failure
        _, negative, zero = self._factor.inertia
        if negative or zero:
            raise NotPositiveDefiniteError(
                f"{negative} pivots are negative and {zero} are zero", negative_pivots=negative
            )

    def solve(self, b: Floats) -> tuple[Floats, tuple[float, ...]]:
        return self._factor.solve(b), ()


class SuperLU:
    """SciPy's SuperLU without pivoting.

    It keeps no analysis, so that a refactor is a factor. The signs of the pivots cost a copy of
    both triangles, which is most of the memory.
    """

    def __init__(self, K: csr_array, modes: Floats | None) -> None:
        pass

    def factor(self, K: csr_array) -> None:
        from scipy.sparse.linalg import splu

        # The transpose of a symmetric matrix: the same arrays, read by columns.
        columns = csc_array((K.data, K.indices, K.indptr), shape=K.shape)
        try:
            self._factor = splu(
                columns,
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
        except RuntimeError as failure:
            raise NotPositiveDefiniteError("a pivot is exactly zero") from failure
        if not np.array_equal(self._factor.perm_r, self._factor.perm_c):
            # SuperLU leaves the diagonal only there.
            raise NotPositiveDefiniteError("a pivot is exactly zero")
        pivots = self._factor.U.diagonal()
        negative = int(np.count_nonzero(pivots < 0.0))
        if negative:
            worst = _first(pivots[self._factor.perm_c] < 0.0)
            raise NotPositiveDefiniteError(
                f"{negative} pivots are negative, such as that of unknown {worst}",
                unknown=worst,
                negative_pivots=negative,
            )

    def solve(self, b: Floats) -> tuple[Floats, tuple[float, ...]]:
        return self._factor.solve(b), ()


class Amg:
    """Conjugate gradients, preconditioned by PyAMG's smoothed aggregation.

    Energy smoothing and a direct coarse solver draw no random numbers and call no threaded BLAS,
    other than PyAMG's defaults; hence the same bits on every run. A narrow band keeps the sweeps
    in cache, which halves their time on a mesh numbered at random.
    """

    def __init__(self, K: csr_array, modes: Floats | None) -> None:
        if modes is None:
            raise ValueError("amg needs the rigid body modes: factor(K, rigid_body_modes(x, free))")
        self._order = reverse_cuthill_mckee(K, symmetric_mode=True)
        self._modes = np.ascontiguousarray(modes[self._order], dtype=float)

    def factor(self, K: csr_array) -> None:
        pyamg = import_module("pyamg")
        K = csr_array(K[self._order][:, self._order])
        K.sort_indices()
        # PyAMG's kernels take 32-bit indices only.
        self._K = csr_array((K.data, K.indices.astype(np.int32), K.indptr.astype(np.int32)))
        self._hierarchy = pyamg.smoothed_aggregation_solver(
            self._K,
            B=self._modes,
            strength=("symmetric", {"theta": 0.0}),
            smooth="energy",
            max_coarse=200,
            coarse_solver="splu",
        )
        # The direct coarse solver would hide directions of negative curvature from the iteration.
        try:
            np.linalg.cholesky(self._hierarchy.levels[-1].A.toarray())
        except np.linalg.LinAlgError as failure:
            raise NotPositiveDefiniteError("it is not so on the coarsest level") from failure

    def solve(self, b: Floats) -> tuple[Floats, tuple[float, ...]]:
        cycle = self._hierarchy.aspreconditioner(cycle="V")
        x = np.empty_like(b)
        x[self._order], history = _conjugate_gradients(self._K, b[self._order], cycle.matvec)
        return x, history


def _conjugate_gradients(
    K: csr_array, b: Floats, precondition: Callable[[Floats], Floats]
) -> tuple[Floats, tuple[float, ...]]:
    """Preconditioned conjugate gradients that look at the curvature of every direction."""
    x = np.zeros_like(b)
    r = b.copy()
    z = precondition(r)
    p = z.copy()
    rz = _dot(r, z)
    history = [1.0]
    noise = 10.0 * np.finfo(float).eps * K.diagonal().max()
    for _ in range(CG_ITERATIONS):
        Kp = K @ p
        curvature = _dot(p, Kp)
        if not (curvature > 0.0 and rz > 0.0):
            raise NotPositiveDefiniteError(
                f"iteration {len(history)} of the conjugate gradients broke down with a curvature "
                f"of {curvature:.1e} and a preconditioned residual of {rz:.1e}"
            )
        step = rz / curvature
        x += step * p
        r -= step * Kp
        history.append(_norm(r) / _norm(b))
        # No residual can fall below the round-off of K x.
        if history[-1] <= max(CG_TOLERANCE, noise * _norm(x) / _norm(b)):
            return x, tuple(history)
        z = precondition(r)
        rz, previous = _dot(r, z), rz
        p = z + (rz / previous) * p
    raise SolveError(
        f"conjugate gradients reached a residual of {min(history):.1e} instead of "
        f"{CG_TOLERANCE:.0e} in {CG_ITERATIONS} iterations, the last ones "
        + ", ".join(f"{value:.1e}" for value in history[-3:])
        + "; take a direct solver (cholmod, rslab or superlu), which also tells a mechanism"
    )


SOLVERS = {
    "cholmod": LinearSolver("cholmod", Cholmod),
    "rslab": LinearSolver("rslab", Rslab),
    "superlu": LinearSolver("superlu", SuperLU),
    "amg": LinearSolver("amg", Amg),
}
_PACKAGE = {"cholmod": "kvxopt", "rslab": "rslab"}


def available(name: str) -> bool:
    """Return whether the package that a solver needs is installed."""
    package = _PACKAGE.get(name)
    return package is None or find_spec(package) is not None


def select(n_unknowns: int, preference: str = "auto") -> LinearSolver:
    """Choose a linear solver.

    Parameters
    ----------
    n_unknowns : int
        Size of the system.
    preference : {"auto", "cholmod", "rslab", "superlu", "amg"}
        ``auto`` takes the fastest installed direct solver; without CHOLMOD and rslab, SuperLU up
        to `SUPERLU_LIMIT` unknowns and the multigrid beyond, where SuperLU's memory hurts.

    Returns
    -------
    LinearSolver

    Raises
    ------
    SolveError
        Where the preferred solver is not installed.
    """
    if preference == "auto":
        name = next((name for name in _PACKAGE if available(name)), None)
        return SOLVERS[name or ("superlu" if n_unknowns <= SUPERLU_LIMIT else "amg")]
    if preference not in SOLVERS:
        raise ValueError(f"no solver {preference!r}; there are auto, {', '.join(SOLVERS)}")
    if not available(preference):
        raise SolveError(
            f"solver {preference} needs the package {_PACKAGE[preference]}: pip install "
            f"{_PACKAGE[preference]}, or choose auto"
        )
    return SOLVERS[preference]


def rigid_body_modes(x: ArrayLike, free: ArrayLike) -> Floats:
    """Return the two translations and the rotation of the plane, for the free unknowns.

    Parameters
    ----------
    x : (m, 2) float
        Coordinates of the nodes [mm].
    free : (m, 2) or (2 m,) bool
        Which displacement components are unknowns, node by node.

    Returns
    -------
    (n, 3) float
        One mode per column, without unit; the rotation turns about the mean of `x` and moves the
        farthest node by one, so that the columns are of one size.
    """
    x = np.asarray(x, dtype=float)
    arm = x - x.mean(axis=0) if len(x) else x
    reach = np.hypot(arm[:, 0], arm[:, 1]).max(initial=0.0)
    modes = np.zeros((len(x), 2, 3))
    modes[:, 0, 0] = modes[:, 1, 1] = 1.0
    if reach > 0.0:
        modes[:, 0, 2] = -arm[:, 1] / reach
        modes[:, 1, 2] = arm[:, 0] / reach
    return modes.reshape(-1, 3)[np.asarray(free, dtype=bool).ravel()]


def _checked(K: csr_array) -> csr_array:
    """Return `K` with sorted indices; refuse what no solver could answer."""
    if K.shape[0] != K.shape[1]:
        raise ValueError(f"the stiffness is not square: {K.shape}")
    if not K.has_canonical_format:
        K = K.copy()
        K.sum_duplicates()
    if not np.isfinite(K.data).all():
        row = int(np.searchsorted(K.indptr, _first(~np.isfinite(K.data)), side="right")) - 1
        raise SolveError(
            f"the stiffness is not finite in row {row}: it was computed from an invalid state"
        )
    diagonal = K.diagonal()
    if (diagonal <= 0.0).any():
        unknown = _first(diagonal <= 0.0)
        raise NotPositiveDefiniteError(
            f"the diagonal entry of unknown {unknown} is {diagonal[unknown]:.1e}", unknown=unknown
        )
    return K


def _first(where: NDArray[np.bool_]) -> int:
    return int(np.flatnonzero(where)[0])


def _dot(a: Floats, b: Floats) -> float:
    # numpy's own sum: the bits of a threaded BLAS depend on the number of threads.
    return float(np.sum(a * b))


def _norm(a: Floats) -> float:
    return float(np.sqrt(_dot(a, a)))
