"""Which crack tips run, at which load, and where to."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cfmpm.fracture import criteria
from cfmpm.grid import CrackTip, Floats
from cfmpm.scene.model import Growth

# Tips whose criteria differ by less than this part run together under crack control: twins of a
# symmetric part differ by the error of the grid.
TIE = 0.02


@dataclass(frozen=True)
class Decision:
    """What the cracks do next.

    Attributes
    ----------
    load_factor : float
        At which they do it; infinite where no load makes a crack run.
    running : dict of str to (2,) float
        Direction of each tip that runs, by its name.
    """

    load_factor: float
    running: dict[str, Floats]


def decide(
    tips: tuple[CrackTip, ...], values: Mapping[str, Any], toughness: Floats, growth: Growth
) -> Decision:
    """Compare the tips with their toughness.

    Parameters
    ----------
    tips : tuple of CrackTip
        Those that may still run.
    values : mapping of str to (tip,) array
        Of a linear scene at load factor one, by the names of `results.VARIABLES`.
    toughness : (tip,) float
        g_c at each tip [N/mm].
    growth : Growth

    Returns
    -------
    Decision
        Under load control the load factor is one, and tips run whose criterion reaches g_c. Under
        crack control it is the one at which the first tip gets there, sqrt(g_c / G).
    """
    if not tips:
        return Decision(math.inf if growth.control == "crack" else 1.0, {})
    driving = values["G" if growth.criterion == "energy_release_rate" else "cf_norm"]
    # Faces that are pressed together release nothing, whatever the integral says.
    closed = np.asarray(values["K_I"]) <= 0.0
    part = np.where(closed & (growth.criterion == "energy_release_rate"), 0.0, driving) / toughness
    largest = float(part.max())
    if growth.control == "load":
        load_factor = 1.0
        runs = part >= 1.0
    else:
        load_factor = 1.0 / math.sqrt(largest) if largest > 0.0 else math.inf
        runs = part >= (1.0 - TIE) * largest
    if growth.tips == "largest":
        runs &= part == largest
    if not math.isfinite(load_factor):
        runs[:] = False
    return Decision(
        load_factor,
        {
            tip.name: direction(tip, {name: value[i] for name, value in values.items()}, growth)
            for i, tip in enumerate(tips)
            if runs[i]
        },
    )


def direction(tip: CrackTip, values: Mapping[str, Any], growth: Growth) -> Floats:
    """Return the unit vector in which a tip runs, (2,)."""
    if growth.direction == "cf":
        force = np.array([values["cf_x"], values["cf_y"]])
        return force / np.hypot(*force)
    angle = {"max_hoop": criteria.max_hoop_angle, "max_energy": criteria.max_energy_angle}[
        growth.direction
    ](values["K_I"], values["K_II"])
    turn = np.exp(1j * np.radians(angle)) * complex(*tip.tangent)
    return np.array([turn.real, turn.imag])
