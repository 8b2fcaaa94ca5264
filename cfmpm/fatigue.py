"""Fatigue: how many cycles of load a crack takes along a path that is known."""

from __future__ import annotations

import numpy as np
import xarray as xr

from cfmpm.grid import Floats


def paris_cycles(
    history: xr.Dataset,
    C: float,
    m: float,
    threshold: float = 0.0,
    load_ratio: float = 0.0,
    maximum_load: float = 1.0,
) -> xr.DataArray:
    """Integrate Paris' law da/dN = C dK^m along the path of each tip.

    Parameters
    ----------
    history : xarray.Dataset
        Of a run under crack control: the path, and K at every step with its load factor.
    C : float
        [mm/cycle / (MPa mm^0.5)^m]. A constant for m/cycle and MPa m^0.5 is to be multiplied by
        1000 / 1000^(m/2).
    m : float
    threshold : float, optional
        Range of K at and below which a crack arrests [MPa mm^0.5].
    load_ratio : float, optional
        Least load over greatest, in [0, 1).
    maximum_load : float, optional
        Greatest load of a cycle, as a factor on the loads of the scene.

    Returns
    -------
    (step, tip) xarray.DataArray
        Cycles from the start to each step; infinite from where a tip would have arrested.

    Notes
    -----
    The range is dK = (1 - R) K_eq with K_eq = sqrt(K_I^2 + K_II^2) = sqrt(E' G) at the greatest
    load, Irwin's energy release rate (1957): on a path that turns to where K_II vanishes every
    other mixture of the modes gives the same; a K_I below zero counts as zero. 1 / dK^m is
    integrated over the length by the trapezoidal rule; where K is not known at the end of a
    segment, as on arrival, it is taken to be that at its start. Each tip is integrated by itself:
    with several tips, the path is that of a load that is raised, at which the most loaded ones run
    first, and cycles of different tips are not simultaneous.
    """
    factor = history["load_factor"].values[:, None]
    k_1, k_2 = (history[name].values / factor for name in ("K_I", "K_II"))
    span = (1.0 - load_ratio) * maximum_load * np.hypot(np.maximum(k_1, 0.0), k_2)
    with np.errstate(divide="ignore"):
        cycles_per_length = np.where(span <= threshold, np.inf, 1.0 / (C * span**m))
    cycles_per_length = _last_known(cycles_per_length)
    grown = np.hypot(np.diff(history["tip_x"], axis=0), np.diff(history["tip_y"], axis=0))
    mean = 0.5 * (cycles_per_length[:-1] + cycles_per_length[1:])
    spent = np.zeros_like(mean)
    np.multiply(mean, grown, out=spent, where=grown > 0.0)
    cycles = np.concatenate([np.zeros_like(k_1[:1]), np.cumsum(spent, axis=0)])
    attributes = {
        "units": "1",
        "long_name": "cycles of load from the start of growth, by Paris' law",
        "comment": f"C {C:g} mm/cycle / (MPa mm0.5)^m, m {m:g}, threshold {threshold:g} MPa mm0.5, "
        f"load ratio {load_ratio:g}, greatest load {maximum_load:g} of the scene's",
    }
    return xr.DataArray(cycles, history["K_I"].coords, ("step", "tip"), attrs=attributes)


def _last_known(values: Floats) -> Floats:
    """Put the last value of a column that is known in the place of nan, (step, tip)."""
    known = np.where(np.isnan(values), 0, np.arange(len(values))[:, None])
    return np.take_along_axis(values, np.maximum.accumulate(known, axis=0), axis=0)
