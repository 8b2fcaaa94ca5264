"""What a linear solver has to provide: it takes a checked matrix and solves with it."""

from __future__ import annotations

from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from cfmpm.errors import SolveError

Floats = NDArray[np.float64]
TOLERANCE = 1e-10


class NotPositiveDefiniteError(SolveError):
    """The stiffness has a pivot that is zero or negative.

    Attributes
    ----------
    seen : str
        By what it was told.
    """

    def __init__(self, seen: str) -> None:
        self.seen = seen
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
        Whether it eliminates, and so meets every pivot; one that does not gets the rigid body
        modes.
    """

    direct: ClassVar[bool]

    def __init__(self, K: csr_array, modes: Floats | None) -> None:
        """Analyse the pattern of `K`."""

    def factor(self, K: csr_array) -> None:
        """Take the values of `K`; raise `NotPositiveDefiniteError` on a bad pivot."""

    def solve(self, b: Floats, tolerance: float = TOLERANCE) -> tuple[Floats, tuple[float, ...]]:
        """Return the solution and, from an iterative solver, its residual after each iteration.

        Only an iterative solver has a use for the tolerance on the residual relative to b.
        """


def first(where: NDArray[np.bool_]) -> int:
    """Return the first place that is true."""
    return int(np.flatnonzero(where)[0])
