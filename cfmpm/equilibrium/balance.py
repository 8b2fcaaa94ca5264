"""The state of balance, and what round-off leaves of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from cfmpm.body.grid import Floats
from cfmpm.body.points import DeformedPoints

RESIDUAL_AT_FLOOR = 1e-3


@dataclass(frozen=True)
class Equilibrium:
    """The state of balance of a load step.

    Attributes
    ----------
    points : DeformedPoints
        What was summed over.
    displacement : (n, 2) float
        [mm].
    internal_force : (n, 2) float
        [N/mm].
    contact_force : (n, 2) float
        That crack faces exert on each other [N/mm].
    contact_pairs : int
        Number of pairs of nodes on crack faces that are closed.
    residual_norm : float
        Largest unbalanced force over the largest nodal force, before or after the solve.
    residual_floor : float
        What round-off explains of it; 0 where the residual is too small to ask.
    solver : str
    n_unknowns : int
    iterations : int
        Of an iterative linear solver; 0 for a direct one.
    load_factor : float
        At which all this holds.
    finite : bool
        Whether by finite deformation.
    parts : Parts or None
        Of small strain under loads that are not all proportional to the load factor.
    finite_effect : float
        Part of the energy that finite deformation would change, where it was left out: at
        `load_factor`, of first order in the load; nan where nobody asked.
    external_work : float
        That finite deformation has taken so far [N]; nan where results grow with the load.
    newton_iterations, substeps : int
        At finite deformation, so far.
    residuals : tuple of float
        Of each iteration of the last step, relative as `residual_norm`.
    unstable_points : float
        Points that have lost ellipticity; nan at small strain.
    unstable_from : float
        Load factor at which the first one had; nan where none has.
    stopped : str
        Why finite deformation went no further; empty where it did.
    """

    points: DeformedPoints
    displacement: Floats
    internal_force: Floats
    contact_force: Floats
    contact_pairs: int
    residual_norm: float
    residual_floor: float
    solver: str
    n_unknowns: int
    iterations: int
    load_factor: float = 1.0
    finite: bool = False
    parts: Parts | None = None
    finite_effect: float = math.nan
    external_work: float = math.nan
    newton_iterations: int = 0
    substeps: int = 0
    residuals: tuple[float, ...] = ()
    unstable_points: float = math.nan
    unstable_from: float = math.nan
    stopped: str = ""

    @property
    def proportional(self) -> bool:
        """Whether stresses grow in proportion to the load factor; else they hold at one only."""
        return not self.finite and self.parts is None

    def scale(self, load_factor: float) -> float:
        """Return what its stresses are to be multiplied with to be those of a load factor."""
        return load_factor / self.load_factor if self.proportional else 1.0


@dataclass(frozen=True)
class Parts:
    """What a linear state is the sum of, where no crack faces press on each other.

    Faces are free to overlap here. At any load factor the state is `fixed` plus the factor times
    `proportional`.

    Attributes
    ----------
    fixed : Equilibrium
        Of the fixed loads alone.
    proportional : Equilibrium
        Of the proportional loads alone, at load factor one.
    both : Equilibrium
        Of all loads, at a load factor at which both are felt.
    """

    fixed: Equilibrium
    proportional: Equilibrium
    both: Equilibrium


def round_off(stiffness: csr_array, displacement: Floats, scale: float) -> float:
    """Return the unbalanced force that round-off explains, relative to a nodal force.

    Parameters
    ----------
    stiffness : (n, n) csr_array
    displacement : (n,) float
        Of the free degrees of freedom [mm].
    scale : float
        The nodal force [N/mm].

    Returns
    -------
    float
        eps |K| |u|, times as many terms as a row has to add up their round-off.
    """
    bound = abs(stiffness) @ np.abs(displacement)
    return float(32.0 * np.finfo(float).eps * bound.max(initial=0.0) / scale)
