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
    of crack faces in elements at the tip, ``not_known`` counts unknown numbers. ``aside_reached``
    is the largest distance of a tip from the height at which it started, over the length that it
    has grown; ``length_path`` and ``cycles_path`` are those of the first crack along step.
    """
    history = result.history
    last, top = history.isel(step=-1), history.sel(boundary="top")
    bottom = history.displacement_y.sel(boundary="bottom")
    j, overlap = np.full(history.step.size, np.nan), 0.0
    of_tip = dict.fromkeys(("K_I", "K_II", "aside"), np.nan)
    length = np.full(history.step.size, np.nan)
    if history.tip.size:
        j = history.J.max("tip").values
        of_tip = {name: float(abs(last[name].values[0])) for name in ("K_I", "K_II")}
        length = history.crack_length.values[:, 0]
        moved = abs(history.tip_y - history.tip_y.isel(step=0)).max().item()
        grown = length[-1] - length[0]
        of_tip["aside"] = moved / grown if grown > 0.0 else np.nan
        overlap = max(float((-history.min_opening / history.tip_size).max()), 0.0)
    return xr.Dataset(
        {
            "J_path": ("step", j),
            "force": ("step", top.reaction_y.values),
            "elongation": ("step", (top.displacement_y - bottom).values),
            "load_path": ("step", history.load_factor.values),
            "length_path": ("step", length),
            "cycles_path": ("step", history.get("cycles", history.load_factor * np.nan).values),
            **{f"{name}_reached": value for name, value in of_tip.items()},
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
