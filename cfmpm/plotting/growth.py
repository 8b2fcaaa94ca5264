"""Curves of crack growth: load, force, angles, stress intensity factors, energies."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from numpy.typing import NDArray

from cfmpm.body.grid import Floats
from cfmpm.output.analysis import energy_balance, new_length
from cfmpm.output.variables import TIP_STATUS
from cfmpm.plotting.curves import STYLES, draw_curve
from cfmpm.plotting.style import BLACK, BLUE, GREY, LIGHT_GREY, ORANGE, VERMILLION, as_label

# Colour and marker both differ, so that the parts can be distinguished without colour; line styles
# would not be visible on short parts.
PARTS = {
    "none": (BLACK, ".", "no growth"),
    "stable": (BLUE, "o", "stable: the force rises"),
    "unstable": (ORANGE, "s", "unstable: the force falls"),
    "snap_back": (VERMILLION, "^", "snap-back"),
    "undefined": (GREY, "x", "at constant load"),
}
# Largest number of steps with a written number.
NUMBERED = 5


def draw_load_displacement(
    axes: Axes, history: xr.Dataset, boundary: str, component: str | None = None
) -> Axes:
    """Draw force against displacement of a loaded part, with stable and unstable crack growth.

    Parameters
    ----------
    axes : Axes
    history : xarray.Dataset
    boundary : str
        Name of the loaded part.
    component : {"x", "y"}, optional
        Default: that of the larger force.

    Returns
    -------
    Axes
        Force and displacement are positive along the first force. Stable and unstable parts of
        growth are marked at the state at which they start; some states have the number of their
        step.
    """
    part = history.sel(boundary=boundary)
    if component is None:
        component = max("xy", key=lambda axis: float(np.abs(part[f"reaction_{axis}"]).max()))
    force, motion = part[f"reaction_{component}"].values, part[f"displacement_{component}"].values
    sense = -1.0 if force[0] < 0.0 else 1.0
    points = sense * np.column_stack([motion, force])
    colour, _, label = PARTS["none"]
    start = np.array([(0.0, 0.0), points[0]])
    axes.plot(*start.T, color=colour, lw=1.1, label=label)
    _draw_parts(axes, history, points, {"none"})
    _number(axes, history, points)
    direction = f"{'-' if sense < 0.0 else ''}{component}"
    axes.set_xlabel(f"displacement of {as_label(boundary)} along {direction} [mm]")
    axes.set_ylabel(f"force along {direction} [N/mm]")
    axes.legend()
    return axes


def draw_load(axes: Axes, history: xr.Dataset) -> Axes:
    """Draw the load factor against the growth of all cracks, with its stable and unstable parts.

    Parameters
    ----------
    axes : Axes
    history : xarray.Dataset
        Of a growth run under crack control.

    Returns
    -------
    Axes
    """
    solved = history.isel(step=np.flatnonzero(np.isfinite(history["load_factor"].values)))
    points = np.column_stack([new_length(solved), solved["load_factor"]])
    _draw_parts(axes, solved, points, set())
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("growth of all cracks together [mm]")
    axes.set_ylabel("load factor [1]")
    axes.legend()
    return axes


def _draw_parts(axes: Axes, history: xr.Dataset, points: Floats, named: set[str]) -> None:
    """Draw a curve over the steps, with a style for each kind of growth; some have labels."""
    flags = history["stability"]
    parts = np.array(flags.attrs["flag_meanings"].split())[flags.values[:-1]]
    parts = np.where(np.diff(new_length(history)) > 0.0, parts, "none")
    for first, last in _runs(parts):
        curve = points[first : last + 1]
        if not np.diff(curve[np.isfinite(curve).all(axis=1)], axis=0).any():
            continue  # not visible, so without a label
        colour, marker, label = PARTS[parts[first]]
        shown = "_" if parts[first] in named else label
        named.add(parts[first])
        style: dict[str, Any] = {"color": colour, "marker": marker, "ms": 3.5, "mew": 0.8}
        axes.plot(*curve.T, lw=1.1, markevery=list(range(last - first)), label=shown, **style)
    end = points[np.isfinite(points).all(axis=1)][-1]
    axes.plot(*end, "o", color=BLACK, ms=3.5, zorder=3)


def _number(axes: Axes, history: xr.Dataset, points: Floats) -> None:
    """Write the numbers of some steps beside their points, if these are far enough apart."""
    known = np.flatnonzero(np.isfinite(points).all(axis=1))
    extent = np.ptp(points[known], axis=0)
    shown: list[Floats] = []
    for i in known[np.linspace(0, len(known) - 1, NUMBERED).astype(int)]:
        place = np.divide(points[i], extent, out=np.zeros(2), where=extent > 0.0)
        if all(np.hypot(*(place - other)) > 0.1 for other in shown):
            shown.append(place)
            text = f"step {int(history['step'][i]) if 'step' in history.coords else i + 1}"
            axes.annotate(text, points[i], (5, 3), textcoords="offset points", fontsize=7)


def _runs(words: NDArray[np.str_]) -> list[tuple[int, int]]:
    """First index, and the one after the last, of each sequence of equal words."""
    ends = np.flatnonzero(words[1:] != words[:-1]) + 1
    bounds = [0, *ends.tolist(), len(words)]
    return [(a, b) for a, b in pairwise(bounds) if b > a]


def draw_steps(axes: Axes, history: xr.Dataset, tip: str) -> Axes:
    """Draw J and the norm of CF at a tip against the load factor.

    Parameters
    ----------
    axes : Axes
    history : xarray.Dataset
        Of several load steps.
    tip : str

    Returns
    -------
    Axes
    """
    of_tip = history.sel(tip=tip)
    for style, (name, label) in enumerate({"J": "J", "cf_norm": "|CF|"}.items()):
        draw_curve(axes, of_tip["load_factor"], of_tip[name], label, style, hollow=style == 1)
    axes.set_xlabel("load factor [1]")
    axes.set_ylabel(f"energy release rate, force at {as_label(tip)} [N/mm]")
    axes.legend()
    return axes


def draw_factors(axes: Axes, history: xr.Dataset) -> Axes:
    """Draw the stress intensity factors along each path.

    Parameters
    ----------
    axes : Axes
    history : xarray.Dataset
        Of a growth run.

    Returns
    -------
    Axes
        Increments in which a tip does not grow are omitted.
    """
    named = {"K_I": "$K_I$", "K_II": "$K_{II}$"}
    _draw_along_paths(axes, history, named)
    axes.set_ylabel("stress intensity factor [MPa mm$^{1/2}$]")
    axes.legend()
    return axes


def draw_angles(axes: Axes, history: xr.Dataset) -> Axes:
    """Draw the angle of the configurational force and the kink angle along each path.

    Parameters
    ----------
    axes : Axes
    history : xarray.Dataset
        Of a growth run.

    Returns
    -------
    Axes
        Angles are from the tangent of the tip: both are zero where a crack grows straight ahead.
        Increments in which a tip does not grow are omitted.
    """
    named = {"kink_angle": "largest hoop stress", "cf_angle": "configurational force"}
    _draw_along_paths(axes, history, named)
    axes.set_ylabel("angle from the tangent [°]")
    axes.legend()
    return axes


def _draw_along_paths(axes: Axes, history: xr.Dataset, named: dict[str, str]) -> None:
    """Draw two quantities of each tip against its growth, the second with open markers, dashed."""
    axes.axhline(0.0, color=LIGHT_GREY, lw=0.8, zorder=1)
    for i, name in enumerate(history["tip"].values):
        colour, marker = STYLES[i % len(STYLES)]
        of_tip = history.sel(tip=name)
        steps = np.hypot(np.diff(of_tip["tip_x"]), np.diff(of_tip["tip_y"]))
        grown = np.concatenate([[0.0], np.cumsum(steps)])
        runs = of_tip["tip_status"].values == TIP_STATUS.index("growing")
        line: dict[str, Any] = {"color": colour, "lw": 1.1, "ms": 3.0, "marker": marker}
        for (key, called), dashes, inside in zip(
            named.items(), ("-", "--"), (colour, "none"), strict=True
        ):
            values, label = of_tip[key].values[runs], f"{as_label(name)}: {called}"
            if np.isnan(values).all():  # K is not defined at finite deformation
                continue
            axes.plot(grown[runs], values, dashes, mfc=inside, label=label, **line)
    axes.set_xlabel("growth of the tip along its path [mm]")


def draw_cycles(axes: Axes, history: xr.Dataset) -> Axes:
    """Draw the growth of each tip against the load cycles.

    Parameters
    ----------
    axes : Axes
    history : xarray.Dataset
        Of a run of fatigue crack growth.

    Returns
    -------
    Axes
    """
    for i, name in enumerate(history["tip"].values):
        of_tip = history.sel(tip=[name])
        draw_curve(axes, history["cycles"], new_length(of_tip), str(name), i)
    axes.set_xlabel("load cycles [1]")
    axes.set_ylabel("growth of the tip along its path [mm]")
    axes.legend()
    return axes


def draw_energy(axes: Axes, history: xr.Dataset) -> Axes:
    """Draw the energy balance against crack growth.

    Parameters
    ----------
    axes : Axes
    history : xarray.Dataset
        Of a growth run.

    Returns
    -------
    Axes
        With the terms of `output.analysis.energy_balance`.
    """
    balance, grown = energy_balance(history), new_length(history)
    for name, label, style, line in (
        ("external_work", "external work", 6, "-"),
        ("strain_energy", "strain energy", 0, "-"),
        ("fracture_energy", "fracture energy", 1, "-"),
        ("plastic_work", "plastic work", 2, "-"),
        ("missing", "missing: external work - others", 4, "--"),
    ):
        # There is no fracture energy under fatigue, and no plastic work in an elastic body.
        if name in balance and balance[name].notnull().any():
            draw_curve(axes, grown, balance[name], label, style, line=line)
    axes.set_xlabel("growth of all cracks together [mm]")
    axes.set_ylabel("energy per thickness [N mm/mm]")
    axes.legend()
    return axes
