"""The load factor at which a crack grows under fixed and proportional loads.

At small strain the state is u = u_fixed + f u_proportional unless crack faces are in contact.
Hence K_I, K_II and T are linear in the load factor f (superposition). J, G and the configurational
force are quadratic polynomials in f; the linear coefficient is twice the mutual term of both parts
(Betti's reciprocal theorem). As K_II / K_I changes with f, so does the kink angle: the driving
force of the kink is not a polynomial, and the load factor is found by a root search.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from cfmpm.body.body import Body
from cfmpm.body.crack_faces import smallest_openings
from cfmpm.body.grid import CrackTip, Floats, regions_ahead
from cfmpm.equilibrium.balance import Equilibrium, Parts
from cfmpm.equilibrium.contact import TOUCH
from cfmpm.fracture import cf
from cfmpm.fracture.criteria.protocols import Direction, direction_by, is_closed
from cfmpm.fracture.evaluation import evaluate_tips, kink, values_of_tip

# Values at the tips that are linear and quadratic in the displacement.
LINEAR = ("K_I", "K_II", "T_stress")
QUADRATIC = ("J", "G", "cf_x", "cf_y", "cf_tip_x", "cf_tip_y")
# Largest number of doublings of the load factor in the search.
DOUBLINGS = 60
# Tolerance of a root of drive - 1; a larger residual is the jump at a tip that opens.
ROOT = 1e-8


@dataclass(frozen=True)
class TipsByFactor:
    """Values at the tips of a body at any load factor, without contact of crack faces.

    Attributes
    ----------
    tips : tuple of CrackTip
    direction : Direction
        Criterion for the direction of a kink.
    constant, first, second : dict of str to (tip,) array
        Coefficients of the powers of the load factor, by the names of a history's variables.
    """

    tips: tuple[CrackTip, ...]
    direction: Direction
    constant: Mapping[str, Floats]
    first: Mapping[str, Floats]
    second: Mapping[str, Floats]

    @classmethod
    def of(cls, body: Body, gradients: Floats, parts: Parts, direction: str) -> Self:
        """Evaluate the fixed and the proportional part of a state.

        Parameters
        ----------
        body : Body
        gradients : (p, k, 2) float
            Basis gradients at its quadrature points [1/mm].
        parts : Parts
            Parts of its state.
        direction : str
            Criterion for the direction of growth, a word of `registry.criteria`.
        """
        alone = replace(body, loading=body.loading.proportional_alone())
        constant, second, both = (
            _evaluated(of, gradients, part, direction)
            for of, part in ((body, parts.fixed), (alone, parts.proportional), (body, parts.both))
        )
        constant, second = (_known(part, both) for part in (constant, second))
        f = parts.both.load_factor
        first = {name: second[name] for name in LINEAR if name in second}
        # Of a part that hardly loads a tip, K is summed without a uniform stress: the sum of both
        # would not be K of the whole, by the error of its quadrature.
        constant |= {name: both[name] - f * second[name] for name in first}
        if "K_I" in first:
            k = [part["K_I"] ** 2 + part["K_II"] ** 2 for part in (constant, second)]
            constant["G"] = np.divide(
                k[0] * second["G"], k[1], out=constant["G"].copy(), where=k[1] > 0.0
            )
        for name in QUADRATIC:
            first[name] = (both[name] - constant[name] - f * f * second[name]) / f
        return cls(
            tips=body.grid.tips,
            direction=direction_by(direction),
            constant={name: constant[name] for name in first},
            first=first,
            second={name: second[name] for name in QUADRATIC},
        )

    def at(self, load_factor: float) -> dict[str, Any]:
        """Return the values at a load factor, (tip,) each."""
        values: dict[str, Any] = {
            name: self.constant[name]
            + load_factor * self.first[name]
            + (load_factor**2 * self.second[name] if name in self.second else 0.0)
            for name in self.first
        }
        return self._completed(values)

    def proportional(self) -> dict[str, Any]:
        """Return the values of the proportional part alone, at load factor one."""
        return self._completed({n: self.second.get(n, self.first[n]) for n in self.first})

    def _completed(self, values: dict[str, Any]) -> dict[str, Any]:
        """Add the values that are derived from these."""
        forces = np.column_stack([values["cf_x"], values["cf_y"]])
        values["cf_norm"] = np.hypot(*forces.T)
        pairs = zip(forces, self.tips, strict=True)
        values["cf_angle"] = np.array([cf.angle(force, tip) for force, tip in pairs])
        if "K_I" in values:
            rows = [kink(values_of_tip(values, i), self.direction) for i in range(len(self.tips))]
            for name in ("kink_angle", "G_kink"):
                values[name] = np.array([row[name] for row in rows])
        return values


def factor_at_fracture(drive: Callable[[float], float], alone: float) -> float:
    """Return the load factor at which the driving force of a crack reaches the toughness.

    Parameters
    ----------
    drive : callable
        Square root of driving force over toughness as a function of the load factor.
    alone : float
        The same quantity of the proportional part alone, at load factor one.

    Returns
    -------
    float
        The smallest positive one; infinite where none is found, and nan where the fixed part alone
        reaches the toughness, or where `drive` jumps past one as a tip opens.

    Notes
    -----
    The square root of the driving force of a kink is the maximum over the angle of linear functions
    of K_I and K_II (`max_hoop`), or the norm of a vector that is linear in them (`max_energy`):
    convex, and homogeneous of first degree. If it starts below one, it therefore reaches one at
    one load factor at most, and never if the proportional part alone has no driving force. The
    same holds for cf: with CF from Irwin's K, 2 |CF|^2 is proportional to
    (K_I + K_II)^4 + (K_I - K_II)^4. Hence doubling cannot step over a root.

    Examples
    --------
    >>> round(factor_at_fracture(lambda f: 0.5 + 0.25 * f, 0.25), 12)
    2.0
    >>> factor_at_fracture(lambda f: 1.5 + f, 1.0)
    nan
    """
    if not drive(0.0) < 1.0:
        return math.nan
    if not alone > 0.0:
        return math.inf
    low, high = 0.0, 1.0 / alone
    for _ in range(DOUBLINGS):
        if drive(high) >= 1.0:
            break
        low, high = high, 2.0 * high
    else:
        return math.inf
    from scipy.optimize import brentq  # takes long, and few scenes need it

    root = float(
        brentq(lambda f: drive(f) - 1.0, low, high, xtol=1e-300, rtol=4.0 * np.finfo(float).eps)
    )
    return root if abs(drive(root) - 1.0) <= ROOT else math.nan


def critical_load_factors(body: Body, by_factor: TipsByFactor, parts: Parts) -> dict[str, Floats]:
    """Find the load factor at which `G_kink` of each tip reaches the toughness.

    Parameters
    ----------
    body : Body
    by_factor : TipsByFactor
    parts : Parts

    Returns
    -------
    dict of str to (tip,) array
        `critical_load_factor` from `factor_at_fracture`; also nan without toughness or K, and where
        crack faces would be in contact at that factor, since the parts cannot be superposed then.
        Empty if there is no toughness or no K.
    """
    found = np.full(len(by_factor.tips), np.nan)
    if "K_I" not in by_factor.first or np.isnan(body.materials.g_c).all():
        return {}
    alone = by_factor.proportional()
    for i, tip in enumerate(by_factor.tips):
        region = regions_ahead(body.grid, tip, tip.tangent)[0]
        toughness = float(body.materials.g_c[region])
        if math.isnan(toughness) or math.isnan(by_factor.first["K_I"][i]):
            continue

        def drive(factor: float, i: int = i, toughness: float = toughness) -> float:
            return _drive(by_factor.at(factor), i, toughness)

        factor = factor_at_fracture(drive, _drive(alone, i, toughness))
        found[i] = math.nan if presses(body, parts, factor) else factor
    return {"critical_load_factor": found}


def presses(body: Body, parts: Parts, load_factor: float) -> bool:
    """Whether crack faces would overlap at a load factor without contact."""
    if not math.isfinite(load_factor):
        return False
    u = parts.fixed.displacement + load_factor * parts.proportional.displacement
    openings = smallest_openings(body.grid, u)
    slack = TOUCH * np.abs(u).max(initial=0.0)
    return any(opening < -slack for opening in openings.values())


def _drive(values: Mapping[str, Any], i: int, toughness: float) -> float:
    """Square root of `G_kink` over toughness of a tip; zero for a closed tip."""
    if is_closed(values["K_I"][i], values["K_II"][i]):
        return 0.0
    return math.sqrt(max(float(values["G_kink"][i]), 0.0) / toughness)


def _known(part: Mapping[str, Any], both: Mapping[str, Any]) -> dict[str, Any]:
    """Values of one part: zero where the tip has some in both, and none where this part is alone.

    Nothing is stressed there by this part alone.
    """
    return {
        name: np.where(np.isnan(part[name]) & ~np.isnan(both[name]), 0.0, part[name])
        for name in (*LINEAR, *QUADRATIC)
        if name in part
    }


def _evaluated(body: Body, gradients: Floats, part: Equilibrium, direction: str) -> dict[str, Any]:
    density = body.loading.at(part.load_factor).body_force
    nodal = cf.nodal_force(body.grid, part.points, gradients, density)
    values = evaluate_tips(body, gradients, part, nodal, direction=direction)
    if values:
        # Without contact, J below zero is round-off; as G it superposes like J.
        values["G"] = np.where(np.isnan(values["G"]), values["J"], values["G"])
    return values
