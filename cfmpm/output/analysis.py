"""Quantities derived from a history: paths of the tips, resolved steps, energy balance."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from cfmpm.output.variables import ARRIVED_FLAGS

Floats = NDArray[np.float64]

# Smallest clearance for accurate results at a tip, in element sizes.
LIGAMENT = 3.0
# Change of the clearance by the way of a tip from which on it runs at an object, or from it: at
# 30 degrees and more.
RUNS_AT = 0.5


def resolved_steps(tip: xr.Dataset) -> NDArray[np.bool_]:
    """Steps in which the domains of a tip contain enough elements, (step,).

    Excluded are the last elements before an arrival, and steps with a small clearance.

    Parameters
    ----------
    tip : xarray.Dataset
        History of one tip.
    """
    names = ("tip_x", "tip_y", "tip_size", "tip_status")
    before = before_arrival(*(tip[name].values for name in names))
    return before & (tip["clearance"].values >= LIGAMENT * tip["tip_size"].values)


def before_arrival(x: Floats, y: Floats, h: Floats, status: Floats) -> NDArray[np.bool_]:
    """Steps of a tip except those within the last elements before an arrival, (step,).

    Parameters
    ----------
    x, y, h, status : (step,) float
        ``tip_x``, ``tip_y``, ``tip_size`` and ``tip_status`` of the tip.
    """
    rest = np.append(np.hypot(np.diff(x), np.diff(y))[::-1].cumsum()[::-1], 0.0)
    arrived = int(status[-1]) in ARRIVED_FLAGS
    return np.isfinite(h) & (rest > (LIGAMENT * h if arrived else -1.0))


def runs_at_object(x: Floats, y: Floats, clearance: Floats) -> NDArray[np.bool_]:
    """Steps in which a growing tip runs at the object that limits its clearance, or from it.

    On a grid of any size the last elements before a hole, an interface or another crack, and the
    first ones behind, are few: smaller ones do not bring clearance there. They do beside an object
    that a tip runs along. The first place of a tip is that of the scene.
    """
    run = np.hypot(np.diff(x), np.diff(y))
    quick = (run > 0.0) & (np.abs(np.diff(clearance)) >= RUNS_AT * run)
    return (np.append(quick, False) | np.append(False, quick)) & ((x != x[0]) | (y != y[0]))


def by_about(effect: float, name: str) -> str:
    """State a relative change by finite deformation, as the quantity of a name.

    It is infinite where it may be large and was not found.
    """
    if np.isinf(effect):
        return f"by an amount that is not found ({name}: inf)"
    return f"by about {100.0 * effect:.2g} % ({name})"


def in_steps(where: NDArray[np.bool_]) -> str:
    """Say which steps are meant, from the first to the last one."""
    first, last = np.flatnonzero(where)[[0, -1]] + 1
    if first == last:
        return f"in step {first}"
    count = np.count_nonzero(where)
    all_between = count == last - first + 1
    return f"in {'' if all_between else f'{count} of the '}steps {first} to {last}"


def parts_of_gap(history: xr.Dataset) -> tuple[float, float]:
    """Compare energy_gap, without its changes in jumps, with external work and fracture energy.

    Returns
    -------
    float, float
        The largest gap over the largest external work; the last gap over the last fracture energy.
        In a body under large compression nearly all work is stored as strain energy, so that the
        first ratio is not sensitive to errors of the crack.
    """
    lost = np.diff(history["energy_gap"].values, prepend=0.0)
    smooth = np.abs(np.where(history["jump"].values > 0.0, 0.0, lost).cumsum())
    work, spent = (np.abs(history[name].values) for name in ("external_work", "fracture_energy"))
    known = np.flatnonzero(np.isfinite(smooth) & (spent > 0.0))
    if not known.size or not np.nanmax(work) > 0.0:
        return 0.0, 0.0
    last = known[-1]
    return float(np.nanmax(smooth) / np.nanmax(work)), float(smooth[last] / spent[last])


def tip_path(history: xr.Dataset, tip: str) -> NDArray[np.float64]:
    """Return the path of a tip as distinct positions, (k, 2) [mm]."""
    of_tip = history.sel(tip=tip)
    places = np.column_stack([of_tip["tip_x"], of_tip["tip_y"]])
    places = places[np.isfinite(places).all(axis=1)]  # a study pads shorter runs with nan
    moved = np.ones(len(places), bool)
    moved[1:] = np.diff(places, axis=0).any(axis=1)
    return places[moved]


def new_length(history: xr.Dataset) -> NDArray[np.float64]:
    """Return the total crack growth of all tips at each step, (step,) [mm]."""
    places = history[["tip_x", "tip_y"]].transpose("step", "tip")
    steps = np.hypot(*(np.diff(places[name], axis=0) for name in ("tip_x", "tip_y")))
    return np.concatenate([[0.0], np.cumsum(steps.sum(axis=1))])


def energy_balance(history: xr.Dataset) -> xr.Dataset:
    """Return the energy balance of a run.

    Parameters
    ----------
    history : xarray.Dataset
        History of one run.

    Returns
    -------
    xarray.Dataset
        By step [N mm per mm of thickness]: ``external_work``, ``strain_energy``,
        ``fracture_energy``, for plastic materials ``plastic_work``, and ``missing``, the first
        minus the others. Under crack control ``missing`` is the error of the increments; at higher
        loads it contains the energy released beyond g_c. Without g_c it is nan as soon as a crack
        grows.
    """
    spent = ["strain_energy", "fracture_energy"]
    if "plastic_work" in history and history["plastic_work"].notnull().any():
        spent.append("plastic_work")
    terms = history[["external_work", *spent]]
    missing = terms["external_work"] - sum(terms[name] for name in spent)
    missing.attrs = {
        "units": history["external_work"].attrs.get("units", "N"),
        "long_name": "external work minus all other terms",
    }
    return terms.assign(missing=missing).assign_attrs(
        title=f"Energy balance of {history.attrs.get('title', 'a run')}"
    )
