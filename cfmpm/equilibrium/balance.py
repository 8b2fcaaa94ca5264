"""States of equilibrium, and their unbalanced force by round-off."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from cfmpm.body.grid import Floats
from cfmpm.body.points import DeformedPoints

RESIDUAL_AT_FLOOR = 1e-3


@dataclass(frozen=True)
class Equilibrium:
    """The state of equilibrium of a load step.

    Attributes
    ----------
    points : DeformedPoints
        The quadrature points.
    displacement : (n, 2) float
        [mm].
    internal_force : (n, 2) float
        [N/mm].
    contact_force : (n, 2) float
        Contact forces of the crack faces [N/mm].
    contact_pairs : int
        Number of closed pairs of nodes on crack faces.
    residual_norm : float
        Largest unbalanced force over the largest nodal force, before or after the solve.
    residual_floor : float
        Part of it that is explained by round-off; 0 where the residual is within the tolerance.
    solver : str
    n_unknowns : int
    iterations : int
        Iterations of an iterative linear solver; 0 for a direct one.
    load_factor : float
        Load factor of this state.
    finite : bool
        Whether at finite deformation.
    parts : Parts or None
        Fixed and proportional part, at small strain if some loads are fixed.
    finite_effect : FiniteEffect or None
        What finite deformation changes, as judged at small strain, by multiples of this state, or,
        of a state at finite deformation, of one at load factor one; None where not evaluated.
    external_work : float
        External work so far at finite deformation [N]; nan at small strain.
    newton_iterations, substeps : int
        Newton iterations and load steps so far, at finite deformation.
    residuals : tuple of float
        `residual_norm` of each iteration of the last step.
    unstable_points : float
        Points that have lost ellipticity; nan at small strain.
    unstable_from : float
        Load factor at which the first point was found to have lost ellipticity; nan if none has.
    stopped : str
        Why no further stable state was found; empty if one was.
    is_last : bool
        With `stopped`: whether no stable state follows. Otherwise one may follow that cannot be
        computed.
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
    finite_effect: FiniteEffect | None = None
    external_work: float = math.nan
    newton_iterations: int = 0
    substeps: int = 0
    residuals: tuple[float, ...] = ()
    unstable_points: float = math.nan
    unstable_from: float = math.nan
    stopped: str = ""
    is_last: bool = True

    @property
    def proportional(self) -> bool:
        """Whether stresses are proportional to the load factor; else they hold at one only."""
        return not self.finite and self.parts is None

    def scale(self, load_factor: float) -> float:
        """Return the factor from the stresses of this state to those at a load factor."""
        return load_factor / self.load_factor if self.proportional else 1.0


@dataclass(frozen=True)
class FiniteEffect:
    """What finite deformation changes in a state of small strain, by a factor s on the state.

    The relative change is ``first s + second s^2``, with the first pair of coefficients for the
    strain energy, the others for J at each tip.

    Attributes
    ----------
    energy : (float, float)
    J : tuple of (float, float)
        nan for a tip without J; empty where it cannot be felt.
    least : float
        Where one of the changes is larger, none has a size: they are infinite.
    """

    energy: tuple[float, float]
    J: tuple[tuple[float, float], ...] = ()
    least: float = math.inf

    def on_energy(self, factor: float) -> float:
        """Size of the relative change of the strain energy of the state times a factor."""
        return float(abs(self._at(factor)[0]))

    def on_j(self, factor: float) -> Floats:
        """Relative change of J at each tip of the state times a factor, (tip,).

        Of a reversed state, in which open faces close, there is none.
        """
        return self._at(factor)[1:] if factor >= 0.0 else np.full(len(self.J), np.nan)

    def largest(self, factors: Iterable[float]) -> float:
        """The largest of all changes at some factors."""
        return max(float(np.nanmax(np.abs(self._at(factor)))) for factor in factors)

    def _at(self, factor: float) -> Floats:
        first, second = np.array([self.energy, *self.J]).T
        change: Floats = factor * (first + factor * second)
        if not np.nanmax(np.abs(change)) > self.least:
            return change
        return np.where(np.isnan(change), np.nan, np.inf)


@dataclass(frozen=True)
class Parts:
    """Parts of a linear state under fixed and proportional loads, without contact of crack faces.

    Crack faces may overlap in these states. The state at any load factor is `fixed` plus the
    factor times `proportional`.

    Attributes
    ----------
    fixed : Equilibrium
        Under the fixed loads alone.
    proportional : Equilibrium
        Under the proportional loads alone, at load factor one.
    both : Equilibrium
        Under all loads, at a load factor at which both parts are of similar size.
    """

    fixed: Equilibrium
    proportional: Equilibrium
    both: Equilibrium


def round_off(stiffness: csr_array, displacement: Floats, scale: float) -> float:
    """Return the unbalanced force that is explained by round-off, relative to a nodal force.

    Parameters
    ----------
    stiffness : (n, n) csr_array
    displacement : (n,) float
        Displacement of the free degrees of freedom [mm].
    scale : float
        The nodal force [N/mm].

    Returns
    -------
    float
        eps |K| |u|, times the number of terms in a row (32), over `scale`.
    """
    bound = abs(stiffness) @ np.abs(displacement)
    return float(32.0 * np.finfo(float).eps * bound.max(initial=0.0) / scale)
