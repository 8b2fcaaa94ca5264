"""Which crack tips run, at which load, and where to."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cfmpm.fracture import criteria
from cfmpm.grid import CrackTip, Floats, Grid, region_of
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
        At which they do it; infinite where no load makes a crack run, nan where no tip is left
        under crack control.
    running : dict of str to (2,) float
        Direction of each tip that runs, by its name.
    """

    load_factor: float
    running: dict[str, Floats]


def decide(
    grid: Grid, values: Mapping[str, Any], g_c: Sequence[float | None], growth: Growth | None
) -> Decision:
    """Compare the tips with their toughness.

    Parameters
    ----------
    grid : Grid
    values : mapping of str to (tip,) array
        Of a linear scene at load factor one, by the names of `results.VARIABLES`.
    g_c : sequence of float or None
        Critical energy release rate of each region [N/mm].
    growth : Growth or None
        None where the cracks do not grow.

    Returns
    -------
    Decision
        Under load control the load factor is one, and tips run whose criterion reaches g_c. Under
        crack control it is the one at which the first tip gets there, sqrt(g_c / G).
    """
    if growth is None:
        return Decision(1.0, {})
    if not grid.tips:
        return Decision(1.0 if growth.control == "load" else math.nan, {})
    toughness = np.array([g_c[region_of(grid, tip)] for tip in grid.tips], float)
    driving = np.asarray(values["G" if growth.criterion == "energy_release_rate" else "cf_norm"])
    # Faces that are pressed together open no crack, whatever the integral says.
    if growth.criterion == "energy_release_rate":
        driving = np.where(np.asarray(values["K_I"]) > 0.0, driving, 0.0)
    part = driving / toughness
    largest = float(part.max())
    if growth.control == "load":
        load_factor = 1.0
        runs = part >= 1.0
    else:
        load_factor = 1.0 / math.sqrt(largest) if largest > 0.0 else math.inf
        runs = (part >= (1.0 - TIE) * largest) & (largest > 0.0)
    if growth.tips == "largest":
        runs &= part == largest
    return Decision(
        load_factor,
        {
            tip.name: direction(tip, {name: value[i] for name, value in values.items()}, growth)
            for i, tip in enumerate(grid.tips)
            if runs[i]
        },
    )


def ending(
    growth: Growth | None, decision: Decision, tips: tuple[CrackTip, ...], steps: int
) -> str:
    """Say why a run ends after this step; empty where it goes on."""
    if growth is None:
        return "solved: the cracks are stationary"
    if not tips:
        return "arrived: no crack ends inside the body any more"
    if not decision.running:
        return "stopped: no tip meets the criterion"
    if steps > growth.increments:
        return f"increments: {growth.increments} were asked for"
    return ""


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
