"""What the stability study looks at in the result of a case, as a measure of a study."""

from __future__ import annotations

import numpy as np
import xarray as xr

from cfmpm.state import Result

# What a run that calls its steps solved must know at each of them.
KNOWN = (
    *("J", "cf_norm", "cf_x", "cf_y", "strain_energy", "external_work", "residual_norm"),
    *("reaction_x", "reaction_y", "displacement_x", "displacement_y"),
)


def path_of_load(result: Result) -> xr.Dataset:
    """The path of the load along step, its last state, and what must never be.

    ``J_path``, ``force`` and ``elongation`` are those of the plate as a whole; ``overlap`` is that
    of crack faces in elements at the tip, ``not_known`` counts unknown numbers.
    """
    history = result.history
    last, top = history.isel(step=-1), history.sel(boundary="top")
    bottom = history.displacement_y.sel(boundary="bottom")
    j, overlap = np.full(history.step.size, np.nan), 0.0
    if history.tip.size:
        j = history.J.max("tip").values
        overlap = max(float((-history.min_opening / history.tip_size).max()), 0.0)
    return xr.Dataset(
        {
            "J_path": ("step", j),
            "force": ("step", top.reaction_y.values),
            "elongation": ("step", (top.displacement_y - bottom).values),
            "load_path": ("step", history.load_factor.values),
            "J_reached": float(j[-1]),
            "load_reached": float(last.load_factor),
            "unstable_points_reached": float(last.unstable_points),
            "newton_iterations_reached": float(last.newton_iterations),
            "substeps_reached": float(last.substeps),
            "residual": float(history.residual_norm.max()),
            "overlap": overlap,
            "not_known": sum(int(history[name].isnull().sum()) for name in KNOWN),
        }
    )
