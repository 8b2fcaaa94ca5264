"""Interface of a linear solver, which gets a checked matrix."""

from __future__ import annotations

from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from cfmpm.errors import SolveError

Floats = NDArray[np.float64]
TOLERANCE = 1e-10


class NotPositiveDefiniteError(SolveError):
    """The stiffness matrix is singular or indefinite.

    Attributes
    ----------
    seen : str
        The finding, such as a negative pivot.
    """

    def __init__(self, seen: str) -> None:
        self.seen = seen
        super().__init__(
            f"the stiffness is not positive definite: {seen}. A part of the body is a mechanism "
            "(no support, or attached at a single node), or stiffnesses differ by more than double "
            "precision resolves, or the state has lost stability (a limit point, buckling, or "
            "softening of the material); only in the last case smaller load steps or prescribed "
            "displacements help"
        )


class Engine(Protocol):
    """Interface of a solver; matrix and right-hand side are checked before.

    Attributes
    ----------
    direct : bool
        Whether it is a direct solver, which computes every pivot; an iterative one gets the rigid
        body modes.
    """

    direct: ClassVar[bool]

    def __init__(self, K: csr_array, modes: Floats | None) -> None:
        """Analyse the pattern of `K`."""

    def factor(self, K: csr_array) -> None:
        """Factor the values of `K`; raise `NotPositiveDefiniteError` for a pivot <= 0."""

    def solve(self, b: Floats, tolerance: float = TOLERANCE) -> tuple[Floats, tuple[float, ...]]:
        """Return the solution and, from an iterative solver, its residual after each iteration.

        Only an iterative solver uses the tolerance on the residual relative to b.
        """


def first(where: NDArray[np.bool_]) -> int:
    """Return the first index that is true."""
    return int(np.flatnonzero(where)[0])
