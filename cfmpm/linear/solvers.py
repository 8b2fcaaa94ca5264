"""Linear solvers for the symmetric positive definite stiffness, with a common interface.

``select(n)`` chooses a solver; ``solver.factor(K)`` returns a `Factor`, which solves for any number
of right-hand sides and takes new values on the same pattern by ``refactor(K)``. Every solver raises
an error for a matrix that is singular or has a negative pivot, so that a mechanism or an unstable
state never gives numbers. `registry.solvers` lists the solvers and their words.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array

from cfmpm.errors import SolveError
from cfmpm.linear.engine import Engine, NotPositiveDefiniteError, first
from cfmpm.registry.solvers import SOLVERS
from cfmpm.registry.table import load

Floats = NDArray[np.float64]

SINGULAR = 1e13
"""Growth of a probe vector above which a factored matrix is taken as singular.

Well posed plane problems of a million unknowns reach 1e4, a part without support 1e15 and more.
"""

PROBE_TOLERANCE = 1e-5
"""Tolerance of the residual of the probe for an iterative solver.

A mechanism has a component of about 1 / sqrt(n) in the probe, 1e-3 at a million unknowns, which no
iteration removes: it continues until the curvature vanishes.
"""

BACKWARD_ERROR = 1e-10
"""Largest residual of a direct solve, relative to ``|K| |x| + |b|``."""
log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Solution:
    """Result of a linear solve.

    Attributes
    ----------
    x : (n,) float
        The unknowns.
    iterations : int
        Iterations of the conjugate gradients; 0 for a direct solver.
    """

    x: Floats
    iterations: int = 0


class Factor:
    """A factored stiffness."""

    def __init__(self, solver: LinearSolver, K: csr_array, modes: Floats | None = None) -> None:
        self._solver = solver
        self._K = _checked(K)
        self._engine: Engine | None = None
        if self.n_unknowns:
            self._engine = solver.engine(self._K, modes)
            self._take_values()

    @property
    def name(self) -> str:
        """The word of the solver."""
        return self._solver.name

    @property
    def direct(self) -> bool:
        """Whether the solver is a direct one."""
        return self._solver.direct

    @property
    def n_unknowns(self) -> int:
        """Size of the system."""
        return int(self._K.shape[0])

    def __repr__(self) -> str:
        return f"<Factor by {self._solver.name}: {self.n_unknowns} unknowns, {self._K.nnz} entries>"

    def refactor(self, K: csr_array) -> None:
        """Factor another matrix with the same pattern; the analysis is reused.

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
            If b is not finite, the iteration does not converge, or the residual is too large.
        """
        b = np.asarray(b, dtype=float)
        if b.shape != (self.n_unknowns,):
            raise ValueError(f"right hand side of shape {b.shape} for {self.n_unknowns} unknowns")
        if not np.isfinite(b).all():
            raise SolveError(
                f"the right hand side is not finite at unknown {first(~np.isfinite(b))}: "
                "a force was computed from an invalid state"
            )
        if self._engine is None or not np.linalg.norm(b) > 0.0:
            return Solution(np.zeros_like(b))
        x, residuals = self._engine.solve(b)
        residual = np.linalg.norm(b - self._K @ x)
        scale = self._K.diagonal().max() * np.linalg.norm(x) + np.linalg.norm(b)
        if not residual <= BACKWARD_ERROR * scale:
            raise SolveError(
                f"{self._solver.name} left a residual of {residual / scale:.1e} relative to "
                f"|K||x| + |b| (allowed {BACKWARD_ERROR:.0e}); is the matrix symmetric?"
            )
        log.debug("%r: residual %.1e", self, residual / np.linalg.norm(b))
        return Solution(x, max(len(residuals) - 1, 0))

    def _take_values(self) -> None:
        """Factor, and check for a zero pivot that is small and positive by round-off."""
        if self._engine is None:
            return
        self._engine.factor(self._K)
        probe = np.random.default_rng(0).choice([-1.0, 1.0], self.n_unknowns)
        answer, _ = self._engine.solve(self._K.diagonal() * probe, PROBE_TOLERANCE)
        growth = np.abs(answer)
        if not growth.max() < SINGULAR:
            raise NotPositiveDefiniteError(
                f"it is singular to round-off: a probe grew to {growth.max():.0e} "
                f"at unknown {int(growth.argmax())}",
            )


@dataclass(frozen=True)
class LinearSolver:
    """A linear solver, from `select`."""

    name: str
    engine: type[Engine]

    @property
    def direct(self) -> bool:
        """Whether it is a direct solver; an iterative one gets the rigid body modes."""
        return self.engine.direct

    def factor(self, K: csr_array, modes: Floats | None = None) -> Factor:
        """Factor a stiffness.

        Parameters
        ----------
        K : (n, n) csr_array
            Symmetric positive definite, both triangles stored [N/mm^2].
        modes : (n, 3) float, optional
            `rigid_body_modes` of the unknowns; a solver that is not `direct` needs them.

        Returns
        -------
        Factor

        Raises
        ------
        NotPositiveDefiniteError
            If a pivot is zero or negative.
        SolveError
            If an entry is not finite.
        """
        return Factor(self, K, modes)


def available(name: str) -> bool:
    """Return whether the package that a solver needs is installed."""
    package = SOLVERS[name].package
    return not package or find_spec(package) is not None


def select(n_unknowns: int, preference: str = "auto") -> LinearSolver:
    """Choose a linear solver.

    Parameters
    ----------
    n_unknowns : int
        Size of the system.
    preference : str
        A word of `registry.solvers`, or ``auto``: the first of those whose package is installed
        and that is suitable for this number of unknowns.

    Returns
    -------
    LinearSolver

    Raises
    ------
    SolveError
        If the preferred solver is not installed.
    """
    if preference == "auto":
        preference = next(
            word
            for word, entry in SOLVERS.items()
            if available(word) and n_unknowns <= entry.most_unknowns
        )
    if preference not in SOLVERS:
        raise ValueError(f"no solver {preference!r}; there are auto, {', '.join(SOLVERS)}")
    if not available(preference):
        package = SOLVERS[preference].package
        raise SolveError(
            f"solver {preference} needs the package {package}: pip install {package}, or choose "
            "auto"
        )
    return LinearSolver(preference, load(SOLVERS[preference].place))


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
        One mode per column, without unit. The rotation is about the mean of `x`, with displacement
        one of the farthest node, so that the columns are of the same magnitude.
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
    """Return `K` with sorted indices; raise an error for a matrix that cannot be solved."""
    if K.shape[0] != K.shape[1]:
        raise ValueError(f"the stiffness is not square: {K.shape}")
    if not K.has_canonical_format:
        K = K.copy()
        K.sum_duplicates()
    if not np.isfinite(K.data).all():
        row = int(np.searchsorted(K.indptr, first(~np.isfinite(K.data)), side="right")) - 1
        raise SolveError(
            f"the stiffness is not finite in row {row}: it was computed from an invalid state"
        )
    diagonal = K.diagonal()
    if (diagonal <= 0.0).any():
        unknown = first(diagonal <= 0.0)
        raise NotPositiveDefiniteError(
            f"the diagonal entry of unknown {unknown} is {diagonal[unknown]:.1e}"
        )
    return K
