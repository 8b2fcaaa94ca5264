"""Figures 13 and 14 of section 5.4, driving force, supports, and paths on many grids."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from cfmpm.body.grid import Floats
from cfmpm.output.files import write_dataset
from cfmpm.plotting import curves
from cfmpm.plotting.style import panels
from cfmpm.scene import load_scene
from workflows.growth.datasets import radius_of, steps, tip_path
from workflows.growth.drawing import (
    AS_PRINTED,
    BEST,
    RESET,
    WIDTH,
    draw_arrows,
    draw_band,
    draw_body,
    draw_grown,
    draw_mesh,
    draw_path,
    draw_reference,
    legend_below,
    write_lines,
)
from workflows.growth.grown_grids import grow
from workflows.growth.outcomes import holes_ending, outcomes, shares
from workflows.growth.specimens import draw_two_holes
from workflows.reference.path_points import reference

TIPS = ("left_crack", "right_crack")
REMESHING, XFEM = "FEM that remeshes (own)", "XFEM of the benchmark"
HOW = {
    "as_printed": "as printed: R = 0.5 mm = a/2",
    "twentieth": "R = 0.05 mm = a/20",
    "twice": "R = 1 mm = a",
    "domains": "R = 0.5 mm, by domains",
}
Paths = str | Path
Variants = Mapping[str, Mapping[str, Any]]


def both_cracks(left: Floats) -> list[Floats]:
    """Return the path of the left crack and that of the right one, by symmetry (k, 2) [mm]."""
    return [left, [20.0, 10.0] - left]


def write_fig13(
    growth: Paths, scene_file: str, variants: Variants, picture: Paths, data: Paths
) -> None:
    """Draw the plate with two holes, its load and its grids.

    Parameters
    ----------
    growth : Path
        From `datasets.write_growth`.
    scene_file : str
    variants : mapping of str to mapping
        What as_printed and best replace in the scene.
    picture, data : Path
    """
    scene = load_scene(scene_file)
    with panels(Path(picture), (WIDTH, 5.0), 2, 2) as axes:
        draw_two_holes(axes[0, 0], scene, lengths=True)
        axes[0, 0].set_title("lengths [mm]")
        draw_two_holes(axes[0, 1], scene, lengths=False)
        axes[0, 1].set_title("load")
        for one, name, label in zip(
            axes[1], ("as_printed", "best"), ("as printed", "best"), strict=True
        ):
            grown = grow(scene_file, {**variants[name], "growth.increments": 1})
            draw_mesh(one, grown.first)
            draw_body(one, grown.scene)
            one.set_title(f"{label}, {grown.points} points")
            _frame(one)
    write_dataset(xr.load_dataset(growth).sel(variant=["as_printed", "best"]), Path(data))


def write_fig14(
    growth: Paths, scene_file: str, variants: Variants, picture: Paths, data: Paths
) -> None:
    """Draw the paths of both cracks beside those of FEM."""
    dataset = xr.load_dataset(growth)
    known = both_cracks(reference("holes_remeshing"))
    with panels(Path(picture), (WIDTH, 4.7), 2, 2) as axes:
        for one, name, label in (
            (axes[0, 0], "as_printed", "as printed"),
            (axes[1, 0], "best", "best"),
        ):
            grown = grow(scene_file, variants[name])
            draw_grown(one, grown.last, grown.scene, [tip_path(dataset, name, t) for t in TIPS])
            radius = f", R = {radius_of(dataset, name):g} mm" if name == "as_printed" else ""
            one.set_title(f"MPM, {label}, {grown.points} points{radius}", fontsize=8)
            _frame(one)
        scene = load_scene(scene_file)
        # Its grid, which is made anew in each step, is not stored.
        draw_body(axes[0, 1], scene)
        draw_arrows(axes[0, 1], [path[1:] for path in known])
        axes[0, 1].set_title("FEM that remeshes (own)", fontsize=8)
        _frame(axes[0, 1])
        beside = axes[1, 1]
        draw_body(beside, scene)
        for name, label, colour in (
            ("best", "MPM, best", BEST),
            ("as_printed", "MPM, as printed", AS_PRINTED),
        ):
            for tip in TIPS:
                text = label if tip == "left_crack" else ""
                path = tip_path(dataset, name, tip)
                draw_path(beside, path, text, colour, segments=name == "as_printed")
        for tip in TIPS:
            text = "grid reset, u = 0.2 mm" if tip == "left_crack" else ""
            draw_path(beside, tip_path(dataset, "reset_tenth", tip), text, RESET, segments=True)
        draw_reference(beside, {REMESHING: known[0], XFEM: reference("holes_hoop")[::2]})
        draw_reference(beside, {"": known[1]})
        beside.set_title("all of them", fontsize=8)
        _frame(beside)
        legend_below(beside, 2)
    write_dataset(dataset, Path(data))


def write_driving_force_holes(growth: Paths, scene_file: str, picture: Paths, data: Paths) -> None:
    """Draw the driving force along the paths, and the path with edges free to move sideways."""
    dataset = xr.load_dataset(growth)
    with panels(Path(picture), (WIDTH, 3.0), 1, 3) as axes:
        for one, name in zip(axes.flat, ("as_printed", "best"), strict=False):
            run = steps(dataset, name)
            for k, tip in enumerate(TIPS):
                alone = run.sel(tip=tip)
                text = tip.replace("_", " ")
                path = np.column_stack([alone.crack_length, alone.cf_norm])
                draw_path(one, path, text, (BEST, AS_PRINTED)[k], segments=k == 1)
            curves.draw_level(one, 1.0, "toughness: 1 N/mm")
            one.set_yscale("log")
            one.set_xlabel("length of the crack [mm]")
            one.set_ylabel("norm of CF [N/mm]")
            one.set_title(name.replace("_", " "))
            legend_below(one)
        last = axes[0, 2]
        draw_body(last, load_scene(scene_file))
        for tip in TIPS:
            label = "edges free sideways, T6" if tip == "left_crack" else ""
            draw_path(last, tip_path(dataset, "rollers", tip), label, BEST, segments=False)
        draw_reference(last, {REMESHING: reference("holes_rollers")})
        last.set_title("on rollers")
        legend_below(last)
    write_dataset(dataset.sel(variant=["as_printed", "best", "rollers"]), Path(data))


def write_scatter_holes(scatter: Paths, scene_file: str, picture: Paths, data: Paths) -> None:
    """Draw the paths of both cracks on ten grids, and tell how they end."""
    dataset = xr.load_dataset(scatter)
    scene = load_scene(scene_file)
    with panels(Path(picture), (WIDTH, 7.6), 4, 2) as axes:
        for (one, beside), (how, label) in zip(axes, HOW.items(), strict=True):
            draw_body(one, scene)
            lines = []
            for tip, colour in zip(TIPS, (AS_PRINTED, BEST), strict=True):
                found = outcomes(dataset, tip, how=how)
                draw_band(one, [each.path for each in found], "", colour)
                lines.append(f"{tip.replace('_', ' ')}, {len(found)} grids:")
                lines += [f"    {n} {end}" for end, n in shares(found, holes_ending).items()]
            draw_reference(one, {REMESHING: reference("holes_remeshing")[::2]})
            one.set_title(label, fontsize=8)
            _frame(one)
            write_lines(beside, lines)
    write_dataset(dataset[["tip_x", "tip_y", "tip_status", "n_points", "run_status"]], Path(data))


def _frame(axes: Axes) -> None:
    axes.set_xlim(-0.6, 20.6)
    axes.set_ylim(-0.4, 10.4)
