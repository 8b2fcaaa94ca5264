"""The linear solvers that ``solver`` knows, in the order in which ``auto`` prefers them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cfmpm.registry.table import Registry


@dataclass(frozen=True)
class SolverEntry:
    """A linear solver by its word.

    Attributes
    ----------
    place : str
        Of its `cfmpm.linear.engine.Engine`.
    package : str
        That has to be installed, by the name of its import and of pip; empty where none has to.
    most_unknowns : float
        Up to which ``auto`` takes it.
    """

    place: str
    package: str = ""
    most_unknowns: float = math.inf


# Other packages: entry points of the group cfmpm.solvers; they are taken by name only, as auto
# finds amg before them.
SOLVERS = Registry(
    "solver",
    {
        # Supernodal L L^T, as bundled in kvxopt; GPL, the extra "fast".
        "cholmod": SolverEntry("cfmpm.linear.cholmod:Cholmod", package="kvxopt"),
        # Supernodal L D L^T; MIT.
        "rslab": SolverEntry("cfmpm.linear.rslab:Rslab", package="rslab"),
        # L U in symmetric mode, by SciPy. Measured: as fast as the multigrid at 100 000 unknowns,
        # half as fast with 1.5 GB at 300 000.
        "superlu": SolverEntry("cfmpm.linear.superlu:SuperLU", most_unknowns=200_000),
        # Conjugate gradients with smoothed aggregation, by PyAMG; least memory.
        "amg": SolverEntry("cfmpm.linear.amg:Amg"),
    },
)
