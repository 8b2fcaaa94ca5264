"""The engines behind the linear solvers: each takes a checked matrix and solves with it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from cfmpm.errors import SolveError

Floats = NDArray[np.float64]
CG_TOLERANCE = 1e-10
CG_ITERATIONS = 500


class NotPositiveDefiniteError(SolveError):
    """The stiffness has a pivot that is zero or negative.

    Attributes
    ----------
    seen : str
        By what it was told.
    unknown : int or None
        The unknown at whose pivot it was seen, counted among the free ones.
    negative_pivots : int or None
        How many pivots are negative; None where the solver stops at the first one.
    """

    def __init__(
        self, seen: str, *, unknown: int | None = None, negative_pivots: int | None = None
    ) -> None:
        self.seen = seen
        self.unknown = unknown
        self.negative_pivots = negative_pivots
        super().__init__(
            f"the stiffness is not positive definite: {seen}. A part of the body is a mechanism "
            "(no support, or it hangs by a single node), or stiffnesses differ by more than double "
            "precision resolves, or the state has lost its stability (a limit point, buckling, or "
            "a material past its strength); a smaller load step or prescribed displacements help "
            "in the last case only"
        )


class Engine(Protocol):
    """What a solver has to provide; it may rely on a checked matrix and right hand side.

    Attributes
    ----------
    direct : bool
        Whether it eliminates, and so meets every pivot.
    """

    direct: ClassVar[bool]

    def __init__(self, K: csr_array, modes: Floats | None) -> None:
        """Analyse the pattern of `K`."""

    def factor(self, K: csr_array) -> None:
        """Take the values of `K`; raise `NotPositiveDefiniteError` on a bad pivot."""

    def solve(self, b: Floats, tolerance: float = CG_TOLERANCE) -> tuple[Floats, tuple[float, ...]]:
        """Return the solution and, from an iterative solver, the history of its residual.

        Only an iterative solver has a use for the tolerance on the residual relative to b.
        """


class Cholmod:
    """CHOLMOD's supernodal Cholesky factor, as bundled in kvxopt's wheels.

    kvxopt wants the lower triangle by columns; of a symmetric matrix those are the entries on
    and right of the diagonal, row by row, as they lie in the CSR arrays. Its wheel links the
    factorisation to a serial BLAS, so that the result does not depend on threads.
    """

    direct: ClassVar[bool] = True

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

    def solve(self, b: Floats, tolerance: float = CG_TOLERANCE) -> tuple[Floats, tuple[float, ...]]:
        x = self._base.matrix(b)
        self._cholmod.solve(self._factor, x)
        return np.array(x).ravel(), ()


class Rslab:
    """L D L^T of the Rust library rslab, on one thread; knows the inertia."""

    direct: ClassVar[bool] = True

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

    def solve(self, b: Floats, tolerance: float = CG_TOLERANCE) -> tuple[Floats, tuple[float, ...]]:
        return self._factor.solve(b), ()


class SuperLU:
    """SciPy's SuperLU without pivoting.

    It keeps no analysis, so that a refactor is a factor. The signs of the pivots cost a copy of
    both triangles, which is most of the memory.
    """

    direct: ClassVar[bool] = True

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
            worst = first(pivots[self._factor.perm_c] < 0.0)
            raise NotPositiveDefiniteError(
                f"{negative} pivots are negative, such as that of unknown {worst}",
                unknown=worst,
                negative_pivots=negative,
            )

    def solve(self, b: Floats, tolerance: float = CG_TOLERANCE) -> tuple[Floats, tuple[float, ...]]:
        return self._factor.solve(b), ()


class Amg:
    """Conjugate gradients, preconditioned by PyAMG's smoothed aggregation.

    Energy smoothing and a direct coarse solver draw no random numbers and call no threaded BLAS,
    other than PyAMG's defaults; hence the same bits on every run. A narrow band keeps the sweeps
    in cache, which halves their time on a mesh numbered at random.
    """

    direct: ClassVar[bool] = False

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

    def solve(self, b: Floats, tolerance: float = CG_TOLERANCE) -> tuple[Floats, tuple[float, ...]]:
        cycle = self._hierarchy.aspreconditioner(cycle="V")
        x = np.empty_like(b)
        x[self._order], history = _conjugate_gradients(
            self._K, b[self._order], cycle.matvec, tolerance
        )
        return x, history


def _conjugate_gradients(
    K: csr_array, b: Floats, precondition: Callable[[Floats], Floats], tolerance: float
) -> tuple[Floats, tuple[float, ...]]:
    """Preconditioned conjugate gradients that look at the curvature of every direction."""
    x = np.zeros_like(b)
    r = b.copy()
    z = precondition(r)
    p = z.copy()
    rz = dot(r, z)
    history = [1.0]
    noise = 10.0 * np.finfo(float).eps * K.diagonal().max()
    for _ in range(CG_ITERATIONS):
        Kp = K @ p
        curvature = dot(p, Kp)
        if not (curvature > 0.0 and rz > 0.0):
            raise NotPositiveDefiniteError(
                f"iteration {len(history)} of the conjugate gradients broke down with a curvature "
                f"of {curvature:.1e} and a preconditioned residual of {rz:.1e}"
            )
        step = rz / curvature
        x += step * p
        r -= step * Kp
        history.append(norm(r) / norm(b))
        # No residual can fall below the round-off of K x.
        if history[-1] <= max(tolerance, noise * norm(x) / norm(b)):
            return x, tuple(history)
        z = precondition(r)
        rz, previous = dot(r, z), rz
        p = z + (rz / previous) * p
    raise SolveError(
        f"conjugate gradients reached a residual of {min(history):.1e} instead of "
        f"{tolerance:.0e} in {CG_ITERATIONS} iterations, the last ones "
        + ", ".join(f"{value:.1e}" for value in history[-3:])
        + "; take a direct solver (cholmod, rslab or superlu), which also tells a mechanism"
    )


def first(where: NDArray[np.bool_]) -> int:
    """Return the first place that is true."""
    return int(np.flatnonzero(where)[0])


def dot(a: Floats, b: Floats) -> float:
    """Return a . b by numpy's own sum: the bits of a threaded BLAS depend on its threads."""
    return float(np.sum(a * b))


def norm(a: Floats) -> float:
    """Return the Euclidean norm, with the bits of `dot`."""
    return float(np.sqrt(dot(a, a)))
