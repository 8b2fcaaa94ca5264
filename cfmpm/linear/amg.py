"""Conjugate gradients, preconditioned by PyAMG's smoothed aggregation."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import ClassVar

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from cfmpm.errors import SolveError
from cfmpm.linear.engine import TOLERANCE, Floats, NotPositiveDefiniteError

CG_ITERATIONS = 500


class Amg:
    """Conjugate gradients, preconditioned by PyAMG's smoothed aggregation.

    Unlike PyAMG's defaults, energy smoothing and a direct coarse solver use no random numbers, so
    that results are equal bit by bit in every run. A narrow bandwidth keeps the sweeps in cache,
    which halves their time on a randomly numbered mesh.
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
        # With the direct coarse solver the iteration would not find negative curvature there.
        try:
            np.linalg.cholesky(self._hierarchy.levels[-1].A.toarray())
        except np.linalg.LinAlgError as failure:
            raise NotPositiveDefiniteError("on the coarsest level it is not") from failure

    def solve(self, b: Floats, tolerance: float = TOLERANCE) -> tuple[Floats, tuple[float, ...]]:
        cycle = self._hierarchy.aspreconditioner(cycle="V")
        x = np.empty_like(b)
        x[self._order], residuals = _conjugate_gradients(
            self._K, b[self._order], cycle.matvec, tolerance
        )
        return x, residuals


def _conjugate_gradients(
    K: csr_array, b: Floats, precondition: Callable[[Floats], Floats], tolerance: float
) -> tuple[Floats, tuple[float, ...]]:
    """Preconditioned conjugate gradients that look at the curvature of every direction."""
    x = np.zeros_like(b)
    r = b.copy()
    z = precondition(r)
    p = z.copy()
    rz = r @ z
    residuals = [1.0]
    noise = 10.0 * np.finfo(float).eps * K.diagonal().max()
    for _ in range(CG_ITERATIONS):
        Kp = K @ p
        curvature = p @ Kp
        if not (curvature > 0.0 and rz > 0.0):
            raise NotPositiveDefiniteError(
                f"iteration {len(residuals)} of the conjugate gradients broke down with a "
                f"curvature of {curvature:.1e} and a preconditioned residual of {rz:.1e}"
            )
        step = rz / curvature
        x += step * p
        r -= step * Kp
        residuals.append(float(np.linalg.norm(r) / np.linalg.norm(b)))
        # No residual can fall below the round-off of K x.
        if residuals[-1] <= max(tolerance, noise * np.linalg.norm(x) / np.linalg.norm(b)):
            return x, tuple(residuals)
        z = precondition(r)
        rz, previous = r @ z, rz
        p = z + (rz / previous) * p
    raise SolveError(
        f"conjugate gradients reached a residual of {min(residuals):.1e} instead of "
        f"{tolerance:.0e} in {CG_ITERATIONS} iterations, the last ones "
        + ", ".join(f"{value:.1e}" for value in residuals[-3:])
        + "; use a direct solver (cholmod, rslab or superlu), which also detects a mechanism"
    )
