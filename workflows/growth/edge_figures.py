"""Figures 9 and 10 of section 5.2, and what becomes of the crack on many grids."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from cfmpm.body.grid import Floats
from cfmpm.output.files import write_dataset
from cfmpm.plotting.style import VERMILLION, panels
from workflows.growth.datasets import radius_of, segment_angles, steps, tip_path
from workflows.growth.drawing import (
    AS_PRINTED,
    BEST,
    SMALL,
    WIDTH,
    draw_band,
    draw_grown,
    legend_below,
)
from workflows.growth.grown_grids import grow
from workflows.growth.outcomes import outcomes, range_of_angles

# The paper's ranges of the angle [deg], by points.
RANGES = {790: (-1.5, 1.5), 2584: (-1.2, 1.0)}
# A segment that turns by less keeps the direction of the last one [deg].
STRAIGHT_ON = 1e-6
COLOURS = {790: AS_PRINTED, 2584: VERMILLION}
HOW = {
    "as_printed": "as printed: R = 50 mm",
    "twice": "R = 100 mm",
    "domains": "R = 50 mm, by domains",
}
Paths = str | Path


def write_fig9(growth: Paths, picture: Paths, data: Paths) -> None:
    """Draw the angle of each segment over the length of the crack.

    Parameters
    ----------
    growth : Path
        From `datasets.write_growth`.
    picture, data : Path
        The PNG and the netCDF file to be written.
    """
    dataset = xr.load_dataset(growth)
    with panels(Path(picture), (WIDTH, 3.9), 1, 3) as axes:
        for n, colour in COLOURS.items():
            for one, kind in zip(axes.flat, ("as_printed", "reset"), strict=False):
                name = f"{kind}_{n}"
                _draw_angles(one, dataset, name, _points(dataset, name), colour, "o-")
        _draw_angles(axes[0, 2], dataset, "best", _points(dataset, "best"), BEST, ".-")
        radius = f"R = {radius_of(dataset, 'as_printed_790'):g} mm"
        titles = (f"as printed, {radius}", f"grid reset, {radius}", "best")
        for one, title in zip(axes.flat, titles, strict=True):
            for n, ends in RANGES.items():
                line = {"color": COLOURS[n], "lw": 0.9, "ls": "--"}
                for end, label in zip(ends, (f"paper's range, {n}", None), strict=True):
                    one.axhline(end, label=label, zorder=1, **line)
            one.set_title(title, fontsize=8)
            one.set_xlim(95.0, 505.0)
            one.set_ylim(-2.2, 2.2)
            one.set_xlabel("crack length [mm]")
            one.set_ylabel("angle of growth [deg]")
            legend_below(one)
    write_dataset(dataset, Path(data))


def write_fig10(
    growth: Paths,
    scene_file: str,
    variants: Mapping[str, Mapping[str, Any]],
    picture: Paths,
    data: Paths,
) -> None:
    """Draw the path in the plate on its grid.

    Parameters
    ----------
    growth : Path
    scene_file : str
    variants : mapping of str to mapping
        What as_printed_790, as_printed_2584 and best replace in the scene.
    picture, data : Path
    """
    dataset = xr.load_dataset(growth)
    with panels(Path(picture), (WIDTH, 4.4), 1, 3) as axes:
        for one, name in zip(axes.flat, ("as_printed_790", "as_printed_2584", "best"), strict=True):
            grown = grow(scene_file, variants[name])
            path = tip_path(dataset, name)
            draw_grown(one, grown.last, grown.scene, [path])
            how = "best" if name == "best" else f"R = {radius_of(dataset, name):g} mm"
            end = f"{len(path) - 1} segments,\nends at {path[-1, 1]:.1f} mm"
            one.set_title(f"{grown.points} points,\n{how}, {end}")
    write_dataset(dataset, Path(data))


def write_scatter_edge(scatter: Paths, picture: Paths, data: Paths) -> None:
    """Draw the paths, and the ranges of their angles, on grids around those of the paper.

    Parameters
    ----------
    scatter : Path
        Of the study scatter_edge.
    picture, data : Path
    """
    dataset = xr.load_dataset(scatter)
    with panels(Path(picture), (WIDTH, 5.0), 2, 3) as axes:
        for column, (how, label) in enumerate(HOW.items()):
            found = outcomes(dataset, "crack_1", how=how)
            for n, colour in COLOURS.items():
                near = [one for one in found if (one.points > 1500) == (n > 1500)]
                top, below = axes[:, column]
                draw_band(top, [one.path - [0.0, 500.0] for one in near], f"near {n}", colour)
                ranges = np.array([range_of_angles(one) for one in near])
                places = np.arange(len(near)) + (0.0 if n < 1500 else len(near) + 1.0)
                _draw_ranges(below, places, ranges, colour)
            top.set_title(label, fontsize=SMALL)
            top.set_xlabel("x of the crack tip [mm]")
            top.set_ylabel("y - 500 [mm]")
            top.set_ylim(-10.0, 10.0)
            legend_below(top, 2)
            for n, ends in RANGES.items():
                for end in ends:
                    below.axhline(end, color=COLOURS[n], lw=0.9, ls="--")
            below.set_xticks([])
            below.set_xlabel("grids")
            below.set_ylabel("angles of growth [deg]")
            below.set_ylim(-5.0, 5.0)
    write_dataset(dataset[["tip_x", "tip_y", "tip_status", "n_points", "run_status"]], Path(data))


def _draw_angles(
    axes: Axes, dataset: xr.Dataset, name: str, label: str, colour: str, style: str
) -> None:
    path = tip_path(dataset, name)
    length = 100.0 + np.append(0.0, np.cumsum(np.hypot(*np.diff(path, axis=0).T)))
    middle = 0.5 * (length[1:] + length[:-1])
    angles = segment_angles(path)
    axes.plot(middle, angles, style, color=colour, lw=1.1, ms=3.5, label=label)
    kept = np.append(False, np.abs(np.diff(angles)) < STRAIGHT_ON)
    if kept.any():
        label = "straight on: R < 2 elements"
        style = {"color": colour, "ms": 3.5, "mfc": "white", "ls": "none", "label": label}
        axes.plot(middle[kept], angles[kept], "o", **style)


def _draw_ranges(axes: Axes, places: Floats, ranges: Floats, colour: str) -> None:
    axes.vlines(places, ranges[:, 0], ranges[:, 1], color=colour, lw=1.6)
    for column in ranges.T:
        axes.plot(places, column, "_", color=colour, ms=4.0)


def _points(dataset: xr.Dataset, variant: str) -> str:
    """How many material points a variant begins with."""
    return f"{int(steps(dataset, variant).n_points[0])} points"
