"""Linear solvers: the words of ``solver``, in the order in which ``auto`` prefers them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cfmpm.registry.table import Registry


@dataclass(frozen=True)
class SolverEntry:
    """Entry of a linear solver.

    Attributes
    ----------
    place : str
        Place of its `cfmpm.linear.engine.Engine`.
    package : str
        Name of the optional package that it needs, for import and pip; empty if it needs none.
    most_unknowns : float
        Largest number of unknowns for which ``auto`` chooses it.
    """

    place: str
    package: str = ""
    most_unknowns: float = math.inf


# Other packages: entry points of the group cfmpm.solvers. They are used by name only: amg, which
# has no limit, comes before them in the order of auto.
SOLVERS = Registry(
    "solver",
    {
        # Supernodal Cholesky factorisation L L^T, bundled in kvxopt; GPL, the extra "fast".
        "cholmod": SolverEntry("cfmpm.linear.cholmod:Cholmod", package="kvxopt"),
        # Supernodal factorisation L D L^T; MIT.
        "rslab": SolverEntry("cfmpm.linear.rslab:Rslab", package="rslab"),
        # L U factorisation in symmetric mode, by SciPy. Measured: as fast as amg at 100 000
        # unknowns, half as fast, with 1.5 GB, at 300 000.
        "superlu": SolverEntry("cfmpm.linear.superlu:SuperLU", most_unknowns=200_000),
        # Conjugate gradients with smoothed aggregation multigrid, by PyAMG; least memory.
        "amg": SolverEntry("cfmpm.linear.amg:Amg"),
    },
)
