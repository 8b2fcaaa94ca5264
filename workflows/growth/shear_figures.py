"""Figures 11 and 12 of section 5.3, convergence of the path, and paths on many grids."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from cfmpm.output.files import write_dataset
from cfmpm.plotting import curves
from cfmpm.plotting.style import length_axes, panels
from cfmpm.scene import load_scene
from workflows.growth.datasets import radius_of, tip_path
from workflows.growth.drawing import (
    AS_PRINTED,
    BEST,
    RESET,
    SMALL,
    WIDTH,
    draw_band,
    draw_body,
    draw_grown,
    draw_mesh,
    draw_path,
    draw_reference,
    legend_below,
)
from workflows.growth.grown_grids import grow
from workflows.growth.outcomes import outcomes
from workflows.growth.specimens import draw_sheared
from workflows.reference.path_points import reference

KINDS = ("as printed", "best")
# After how many steps the paper shows the crack.
SHOWN = (3, 10, 15)
REMESHING = "FEM that remeshes (own), 1 mm"
HOW = {
    "as_printed": "as printed: R = a/2",
    "twentieth": "R = a/20",
    "domains": "R = a/2, by domains",
}
Paths = str | Path
Variants = Mapping[str, Mapping[str, Any]]


def write_fig11(
    growth: Paths, scene_file: str, variants: Variants, picture: Paths, data: Paths
) -> None:
    """Draw the plate, its load and its grid.

    Parameters
    ----------
    growth : Path
        From `datasets.write_growth`.
    scene_file : str
    variants : mapping of str to mapping
        What as_printed and best replace in the scene.
    picture, data : Path
    """
    with panels(Path(picture), (WIDTH, 4.6), 1, 3) as axes:
        draw_sheared(axes[0, 0], load_scene(scene_file))
        axes[0, 0].set_title("load, lengths [mm]")
        for one, name, label in zip(axes[0, 1:], ("as_printed", "best"), KINDS, strict=True):
            grown = grow(scene_file, {**variants[name], "growth.increments": 1})
            draw_mesh(one, grown.first)
            draw_body(one, grown.scene)
            one.set_title(f"{label}, {grown.points} points")
            one.set_xlim(-6.0, 80.0)
            one.set_ylim(-22.0, 182.0)
    write_dataset(xr.load_dataset(growth).sel(variant=["as_printed", "best"]), Path(data))


def write_fig12(
    growth: Paths, scene_file: str, variants: Variants, picture: Paths, data: Paths
) -> None:
    """Draw the crack after 3, 10 and 15 steps, and its path beside others."""
    dataset = xr.load_dataset(growth)
    path = tip_path(dataset, "as_printed")
    grown = grow(scene_file, variants["as_printed"], SHOWN)
    with panels(Path(picture), (WIDTH, 5.0), 2, 2) as axes:
        for one, steps in zip(axes.flat, SHOWN, strict=False):
            done = min(steps, len(path) - 1)
            draw_grown(one, grown.after.get(done, grown.last), grown.scene, [path[: done + 1]])
            one.set_title(f"as printed, {done} steps")
            one.set_xlim(-1.0, 71.0)
            one.set_ylim(54.0, 96.0)
        last = axes[1, 1]
        draw_body(last, grown.scene)
        label = f"as printed, {grown.points} points, R = {radius_of(dataset, 'as_printed'):g} mm"
        draw_path(last, path, label, AS_PRINTED, segments=True)
        draw_path(last, tip_path(dataset, "best"), "best", BEST, segments=False)
        reset = tip_path(dataset, "reset_5")
        draw_path(last, reset, "as printed, grid reset, 5 MPa", RESET, segments=True)
        draw_reference(last, {REMESHING: reference("shear_plate")})
        last.set_aspect("auto")
        last.set_xlim(28.0, 71.0)
        last.set_ylim(70.0, 82.0)
        last.set_title("beside FEM")
        last.legend(loc="lower left", fontsize=SMALL)
    write_dataset(dataset, Path(data))


def write_convergence_shear(growth: Paths, picture: Paths, data: Paths) -> None:
    """Draw how the path converges with the length of its segments."""
    dataset = xr.load_dataset(growth)
    x, y = reference("shear_plate_limit").T
    kinds = {"cf": "T3, direction of CF", "hoop": "T3, hoop stress", "t6": "T6, hoop stress"}
    with panels(Path(picture), (WIDTH, 3.2), 1, 2) as axes:
        for one, order in zip(axes.flat, ("first", "second"), strict=True):
            for k, (kind, label) in enumerate(kinds.items()):
                chosen = [v for v in dataset.variant.values if v.startswith(f"{kind}_{order}")]
                paths = [tip_path(dataset, name) for name in chosen]
                lengths = [np.hypot(*np.diff(path, axis=0)[:-1].T).mean() for path in paths]
                missed = [np.abs(np.interp(x, *path.T) - y).max() for path in paths]
                curves.draw_curve(one, lengths, missed, label, k)
            curves.draw_level(one, 0.15, "0.15 mm: bar of the table")
            one.set_xlim(0.0, 2.8)
            one.set_ylim(0.0, 0.5)
            one.set_xlabel("mean length of a segment [mm]")
            one.set_ylabel("largest distance from the limit [mm]")
            one.set_title(f"direction of {order} order")
            legend_below(one, 2)
    write_dataset(dataset, Path(data))


def write_scatter_shear(scatter: Paths, scene_file: str, picture: Paths, data: Paths) -> None:
    """Draw the paths on grids around that of the paper."""
    dataset = xr.load_dataset(scatter)
    scene = load_scene(scene_file)
    with panels(Path(picture), (WIDTH, 3.0), 1, 3) as axes:
        for one, (how, label) in zip(axes.flat, HOW.items(), strict=True):
            draw_body(one, scene)
            found = outcomes(dataset, "crack_1", how=how)
            draw_band(one, [each.path for each in found], f"{len(found)} grids", AS_PRINTED)
            draw_reference(one, {REMESHING: reference("shear_plate")[::4]})
            length_axes(one)
            one.set_aspect("auto")
            one.set_xlim(28.0, 71.0)
            one.set_ylim(69.0, 82.0)
            one.set_title(label, fontsize=SMALL)
            legend_below(one, crack=True)
    write_dataset(dataset[["tip_x", "tip_y", "tip_status", "n_points", "run_status"]], Path(data))
