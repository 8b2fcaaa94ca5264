"""SciPy's SuperLU."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from scipy.sparse import csc_array, csr_array
from scipy.sparse.linalg import splu

from cfmpm.linear.engine import TOLERANCE, Floats, NotPositiveDefiniteError, first


class SuperLU:
    """SciPy's SuperLU without pivoting.

    It keeps no analysis, so that `refactor` takes as long as `factor`. The signs of the pivots
    require a copy of both factors, which is most of the memory.
    """

    direct: ClassVar[bool] = True

    def __init__(self, K: csr_array, modes: Floats | None) -> None:
        pass

    def factor(self, K: csr_array) -> None:
        # A symmetric matrix is its transpose: the same arrays, read by columns.
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
            # SuperLU pivots off the diagonal only for a zero pivot.
            raise NotPositiveDefiniteError("a pivot is exactly zero")
        pivots = self._factor.U.diagonal()
        negative = int(np.count_nonzero(pivots < 0.0))
        if negative:
            worst = first(pivots[self._factor.perm_c] < 0.0)
            raise NotPositiveDefiniteError(
                f"{negative} pivots are negative, such as that of unknown {worst}"
            )

    def solve(self, b: Floats, tolerance: float = TOLERANCE) -> tuple[Floats, tuple[float, ...]]:
        return self._factor.solve(b), ()
