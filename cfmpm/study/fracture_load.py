"""The load at which the first tip of a member reaches g_c, from the steps before a tip moves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cfmpm.scene import Scene

Values = NDArray[Any]

# Largest angle of the configurational force to the crack that counts as straight ahead [deg].
STRAIGHT = 2.0
# Largest ratio of the energy release rate of a kink to J before kinking: that of pure shear is 1.6
# (Hussain, Pu and Underwood 1974; Amestoy and Leblond 1992).
KINKED = 2.0


def fracture_load_factor(scene: Scene, values: Mapping[str, Values]) -> float:
    """Find the load factor at which the first tip reaches g_c.

    Parameters
    ----------
    scene : Scene
    values : mapping of str to array
        ``load_factor`` (step,) and, by (step, tip), ``tip_x``, ``tip_y``, ``critical_load_factor``,
        ``G_kink`` and ``J`` [N/mm] and ``cf_angle`` [deg].

    Returns
    -------
    float
        nan without tips or a single g_c, or if at finite deformation g_c is not reached or the
        driving force is not known.

    Notes
    -----
    For linear scenes it is `critical_load_factor`. At finite deformation the square root of the
    driving force, which is proportional to small loads, is interpolated between load steps. The
    driving force is ``G_kink`` where strain at the tip is small. Else it is J, provided that the
    configurational force points straight ahead: J of a crack that would kink is below the energy
    release rate of the kink.
    """
    critical = values["critical_load_factor"]
    if not critical.size:
        return np.nan
    if not np.isnan(critical[0]).all():
        return float(np.nanmin(critical[0]))
    source = scene.geometry or scene.mesh_file
    regions = source.regions if source else []
    toughness = {scene.material.g_c, *(region.material.g_c for region in regions)}
    g_c = toughness.pop()
    if toughness or g_c is None:
        return np.nan
    moves = np.flatnonzero(moved(values["tip_x"], values["tip_y"]))
    still = int(moves[0]) + 1 if len(moves) else len(critical)
    straight = np.where(np.abs(values["cf_angle"]) < STRAIGHT, values["J"], np.nan)
    driving = np.where(np.isnan(values["G_kink"]), straight, values["G_kink"])[:still]
    # A tip that carries nothing has no J.
    most = np.nan_to_num(np.where(np.isnan(driving), KINKED * values["J"][:still], driving))
    largest = np.nan_to_num(driving).max(axis=1).clip(min=0.0)
    reached = np.concatenate([[0.0], np.sqrt(largest / g_c)])
    load = np.concatenate([[0.0], values["load_factor"][:still]])
    above = np.flatnonzero(most.max(axis=1) >= g_c) + 1
    if len(above):
        i = above[0]
        if (most[i - 1] >= g_c)[np.isnan(driving[i - 1])].any():
            return np.nan
        part = (1.0 - reached[i - 1]) / (reached[i] - reached[i - 1])
        return float(load[i - 1] + part * (load[i] - load[i - 1]))
    # After growth other criteria apply.
    return float(load[-1]) if len(moves) else np.nan


def moved(x: Values, y: Values) -> NDArray[np.bool_]:
    """Whether any tip has moved since the step before, (steps - 1,)."""
    found: NDArray[np.bool_] = np.hypot(np.diff(x, axis=0), np.diff(y, axis=0)) > 0.0
    return np.any(found, axis=1)
