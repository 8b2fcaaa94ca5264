"""Figures of crack paths, and of the configurational force along them."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline
from numpy.typing import ArrayLike, NDArray

from cfmpm.body.grid import Floats, Grid
from cfmpm.output.analysis import tip_path
from cfmpm.output.variables import ARRIVED, TIP_STATUS
from cfmpm.plotting.curves import STYLES
from cfmpm.plotting.mesh import Mesh, draw_grid
from cfmpm.plotting.style import BLACK, LIGHT_GREY, REGIONS, as_label, length_axes
from cfmpm.scene.geometry import BodyShape
from cfmpm.scene.model import Scene

# Marker and label of a tip at the end.
ENDS = {
    "growing": (">", "still growing"),
    "stopped": ("s", "stopped"),
    "arrived": ("X", "arrived"),
    "severed": ("D", "in a severed body"),
}
# Length of the longest arrow, relative to the size of the body.
LONGEST = 0.06
# Distance between two arrows of a tip, in the same unit.
APART = 0.065


def draw_paths(
    axes: Axes,
    history: xr.Dataset,
    body: Scene | Grid | Mesh,
    reference: ArrayLike | Mapping[str, ArrayLike] | None = None,
) -> Axes:
    """Draw the paths of the crack tips over the outline of the body and its holes.

    Parameters
    ----------
    axes : Axes
    history : xarray.Dataset
        Of a growth run.
    body : Scene or Grid or Mesh
        A scene gives the outline and the initial cracks; a grid is drawn with its elements.
    reference : (k, 2) float or mapping of str to (k, 2) float, optional
        Points of other paths to compare with [mm], by their name in the legend.

    Returns
    -------
    Axes
        With a dot at each increment; the marker at the end of a path is the status of its tip.
    """
    _draw_body(axes, body)
    history = _own_tips(history)
    found = {_end(history.sel(tip=name)) for name in history["tip"].values}
    for i, name in enumerate(history["tip"].values):
        colour, _ = STYLES[i % len(STYLES)]
        path = tip_path(history, str(name))
        axes.plot(*path.T, "-o", color=colour, lw=1.2, ms=2.0, zorder=4, label=as_label(name))
        marker, _ = ENDS[_end(history.sel(tip=name))]
        axes.plot(*path[-1], marker, color=colour, mec="white", ms=7.0, mew=0.5, zorder=5)
    for end, (marker, label) in ENDS.items():
        if end in found:
            axes.plot([], [], marker, color=BLACK, mec="white", ms=7.0, mew=0.5, label=label)
    if reference is not None:
        named = reference if isinstance(reference, Mapping) else {"reference": reference}
        for (name, points), marker in zip(named.items(), cycle("s^Dv")):
            style: dict[str, Any] = {"mfc": "none", "mec": BLACK, "ms": 4.5, "mew": 0.8}
            axes.plot(*np.asarray(points, float).T, marker, zorder=3, label=name, **style)
    return _framed(axes)


def draw_tip_cf(axes: Axes, history: xr.Dataset, body: Scene | Grid | Mesh) -> Axes:
    """Draw the configurational force on the largest domain at each position of each tip.

    Parameters
    ----------
    axes : Axes
    history : xarray.Dataset
    body : Scene or Grid or Mesh
        As in `draw_paths`.

    Returns
    -------
    Axes
        All arrows have the same scale; the legend has the smallest and the largest norm at each
        tip. Where positions are close together, some have no arrow.
    """
    _draw_body(axes, body)
    history = _own_tips(history)
    size = float(np.ptp(corners_of(body), axis=0).max())
    scale = float(np.nanmax(history["cf_norm"].values, initial=0.0)) / (LONGEST * size) or 1.0
    for i, name in enumerate(history["tip"].values):
        colour, _ = STYLES[i % len(STYLES)]
        of_tip = history.sel(tip=name)
        norm = of_tip["cf_norm"].values
        axes.plot(*tip_path(history, str(name)).T, "-", color=BLACK, lw=0.8, zorder=3)
        if np.isnan(norm).all():
            continue
        places = np.column_stack([of_tip["tip_x"], of_tip["tip_y"]])
        shown = _apart(places, np.isfinite(norm), APART * size)
        x, y, cf_x, cf_y = (of_tip[k].values[shown] for k in ("tip_x", "tip_y", "cf_x", "cf_y"))
        label = f"{as_label(name)}: |CF| {_range(norm)} N/mm"
        axes.quiver(
            *(x, y, cf_x, cf_y),
            angles="xy",
            scale_units="xy",
            scale=scale,
            width=0.003,
            minlength=0.0,
            color=colour,
            label=label,
            zorder=4,
        )
        axes.update_datalim(np.column_stack([x + cf_x / scale, y + cf_y / scale]))
    return _framed(axes)


def _own_tips(history: xr.Dataset) -> xr.Dataset:
    """The history without tips of other members of a study, which have no position."""
    return history.dropna("tip", how="all", subset=["tip_x"])


def _end(of_tip: xr.Dataset) -> str:
    """The key of `ENDS` for the status of a tip."""
    known = np.flatnonzero(np.isfinite(of_tip["tip_x"].values))  # a study pads shorter runs
    status = TIP_STATUS[int(of_tip["tip_status"][known[-1]])]
    return "arrived" if status in ARRIVED else status


def corners_of(body: Scene | Grid | Mesh) -> Floats:
    """Return points that span a body, (k, 2) [mm]."""
    if isinstance(body, Scene):
        return np.array(BodyShape.of(body).outline.exterior.coords)
    return body.nodes


def _apart(places: Floats, eligible: NDArray[np.bool_], distance: float) -> list[int]:
    """Choose eligible positions, each at least a given distance from the one before."""
    chosen: list[int] = []
    for i in np.flatnonzero(eligible).tolist():
        if not chosen or np.hypot(*(places[i] - places[chosen[-1]])) >= distance:
            chosen.append(i)
    return chosen


def _range(values: Floats) -> str:
    low, high = (f"{bound(values):.4g}" for bound in (np.nanmin, np.nanmax))
    return low if low == high else f"{low} to {high}"


def _framed(axes: Axes) -> Axes:
    axes.autoscale_view()
    length_axes(axes)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return axes


def _draw_body(axes: Axes, body: Scene | Grid | Mesh) -> None:
    """Draw the elements of a grid, or outline, holes and initial cracks of a scene."""
    if not isinstance(body, Scene):
        draw_grid(axes, body, colour=LIGHT_GREY, width=0.3)
        return
    shape = BodyShape.of(body)
    polygon = shape.polygon
    parts = []
    for part in getattr(polygon, "geoms", [polygon]):
        rings = [part.exterior, *part.interiors]
        parts.append(
            PathPatch(Outline.make_compound_path(*(Outline(ring.coords) for ring in rings)))
        )
    axes.add_collection(
        PatchCollection(parts, facecolor=REGIONS[0], edgecolor=BLACK, linewidth=0.8)
    )
    lines = [np.array(crack.points) for crack in shape.geometry.cracks]
    axes.add_collection(LineCollection(lines, colors=BLACK, linewidths=1.8, zorder=3))
