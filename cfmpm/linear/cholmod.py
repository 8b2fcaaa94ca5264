"""CHOLMOD's supernodal Cholesky factor."""

from __future__ import annotations

from contextlib import suppress
from functools import cache
from importlib import import_module
from types import ModuleType
from typing import ClassVar

import numpy as np
from scipy.sparse import csr_array

from cfmpm.linear.engine import TOLERANCE, Floats, NotPositiveDefiniteError
from cfmpm.threads import limit_blas_of


class Cholmod:
    """CHOLMOD's supernodal Cholesky factor, as bundled in kvxopt's wheels.

    kvxopt requires the lower triangle by columns. For a symmetric matrix these are the entries on
    and right of the diagonal by rows, in the order of the CSR arrays. Its BLAS is held at one
    thread, so that the result does not depend on their number.
    """

    direct: ClassVar[bool] = True

    def __init__(self, K: csr_array, modes: Floats | None) -> None:
        self._base, self._cholmod = _library()
        rows = np.repeat(np.arange(K.shape[0]), np.diff(K.indptr))
        self._half = np.flatnonzero(K.indices >= rows)
        # Values are zero, since the analysis only reads the pattern.
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
        # kvxopt 1.3 reads the status before it factors: an error raised by `numeric` is that of the
        # previous matrix. `solve` without a right-hand side checks the status of this one.
        with suppress(ArithmeticError):
            self._cholmod.numeric(self._values, self._factor)
        try:
            self._cholmod.solve(self._factor, self._base.matrix(0.0), nrhs=0)
        except ArithmeticError as failure:
            raise NotPositiveDefiniteError(
                "Cholesky found a pivot that is not positive"
            ) from failure

    def solve(self, b: Floats, tolerance: float = TOLERANCE) -> tuple[Floats, tuple[float, ...]]:
        x = self._base.matrix(b)
        self._cholmod.solve(self._factor, x)
        return np.array(x).ravel(), ()


@cache
def _library() -> tuple[ModuleType, ModuleType]:
    """Import kvxopt; its BLAS is loaded with it, after the threads of a run were limited."""
    modules = import_module("kvxopt.base"), import_module("kvxopt.cholmod")
    limit_blas_of("kvxopt")
    return modules
