"""Figures 15 and 16 of section 5.5, the near-miss of the bottom hole, and paths on many grids."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import xarray as xr
from matplotlib.axes import Axes

from cfmpm.output.files import write_dataset
from cfmpm.plotting import curves
from cfmpm.plotting.style import panels
from cfmpm.scene import load_scene
from workflows.growth.beam_holes import BOTTOM, SPECIMENS, gap_to_hole
from workflows.growth.datasets import radius_of, tip_path
from workflows.growth.drawing import (
    AS_PRINTED,
    BEST,
    SMALL,
    WIDTH,
    draw_band,
    draw_body,
    draw_mesh,
    draw_path,
    draw_reference,
    legend_below,
)
from workflows.growth.grown_grids import grow
from workflows.growth.outcomes import beam_ending, outcomes, shares
from workflows.growth.specimens import draw_beam
from workflows.reference.path_points import reference

REMESHING, XFEM = "FEM that remeshes (own)", "XFEM"
# Which of the radii is one half of the crack, by specimen.
AS_IN_THE_PAPER = {"15_5": "R_19.05", "10_6": "R_12.7", "10_4": "R_12.7"}
HOW = {
    "R_12.7": "R = 12.7 mm",
    "R_19.05": "R = 19.05 mm",
    "twentieth": "R = 1.27 mm",
    "domains": "R = 12.7 mm, by domains",
}
Paths = str | Path
Variants = Mapping[str, Mapping[str, Any]]


def write_fig15(
    growth: Paths, scene_file: str, variants: Variants, picture: Paths, data: Paths
) -> None:
    """Draw the beam with its load, and its grids.

    Parameters
    ----------
    growth : Path
        From `datasets.write_growth`.
    scene_file : str
    variants : mapping of str to mapping
        What as_printed_15_5, as_printed_10_6 and best_15_5 replace in the scene.
    picture, data : Path
    """
    with panels(Path(picture), (WIDTH, 4.6), 2, 2) as axes:
        for one, case, a, b, title in (
            (axes[0, 0], "15_5", 38.1, 127.0, "case I, lengths [mm]"),
            (axes[0, 1], "10_6", 25.4, 101.6, "case II, as it is read here"),
        ):
            draw_beam(one, load_scene(scene_file, variants[f"as_printed_{case}"]), a, b)
            one.set_title(title)
        for one, name, title in (
            (axes[1, 0], "as_printed_15_5", "as printed"),
            (axes[1, 1], "best_15_5", "best"),
        ):
            grown = grow(scene_file, {**variants[name], "growth.increments": 1})
            draw_mesh(one, grown.first)
            draw_body(one, grown.scene)
            one.set_xlim(-12.0, 520.0)
            one.set_title(f"{title}, {grown.points} points")
    kept = ["as_printed_15_5", "as_printed_10_6", "best_15_5"]
    write_dataset(xr.load_dataset(growth).sel(variant=kept), Path(data))


def write_fig16(
    growth: Paths, scene_file: str, variants: Variants, picture: Paths, data: Paths
) -> None:
    """Draw the paths in both cases, the second by both readings, beside references."""
    dataset = xr.load_dataset(growth)
    with panels(Path(picture), (WIDTH, 4.6), 1, 3) as axes:
        for one, (case, label) in zip(axes.flat, SPECIMENS.items(), strict=True):
            draw_body(one, load_scene(scene_file, variants[f"as_printed_{case}"]))
            name = f"as_printed_{case}"
            text = f"as printed, R = {radius_of(dataset, name):g} mm"
            draw_path(one, tip_path(dataset, name), text, AS_PRINTED, segments=True)
            draw_path(one, tip_path(dataset, f"best_{case}"), "best", BEST, segments=False)
            known = {REMESHING: reference(f"beam_{case}")[::2]}
            if case == "15_5":
                known[XFEM] = reference("beam_15_5_xfem")[::2]
            draw_reference(one, known)
            _holes_in_view(one)
            one.set_title(label.replace(" (", "\n(").replace(" as", "\nas"), fontsize=8)
            legend_below(one, crack=True)
    write_dataset(dataset, Path(data))


def write_near_miss_beam(
    growth: Paths, scene_file: str, sizes: Sequence[int], picture: Paths, data: Paths
) -> None:
    """Draw how the crack misses the bottom hole, on finer and finer grids.

    Parameters
    ----------
    growth : Path
    scene_file : str
    sizes : sequence of int
        Element sizes, coarse to fine [mm].
    picture, data : Path
    """
    dataset = xr.load_dataset(growth)
    with panels(Path(picture), (WIDTH, 3.6), 1, 2) as axes:
        a, b = axes.flat
        draw_body(a, load_scene(scene_file))
        for k, size in enumerate(sizes):
            colour = curves.STYLES[k][0]
            path = tip_path(dataset, f"first_{size}")
            draw_path(a, path, f"size {size} mm", colour, segments=True)
        draw_reference(a, {REMESHING: reference("beam_15_5"), XFEM: reference("beam_15_5_xfem")})
        a.set_xlim(128.0, 165.0)
        a.set_ylim(52.0, 92.0)
        a.set_title("T3, hoop stress, first order")
        legend_below(a, 2)
        for k, order in enumerate(("first", "second")):
            gaps = [gap_to_hole(tip_path(dataset, f"{order}_{size}"), BOTTOM) for size in sizes]
            curves.draw_curve(b, sizes, gaps, f"T3, hoop stress, {order} order", k)
        for label, file, line in ((REMESHING, "beam_15_5", "--"), (XFEM, "beam_15_5_xfem", ":")):
            known = gap_to_hole(reference(file), BOTTOM)
            curves.draw_level(b, known, f"{label}: {known:.1f} mm", line=line)
        b.set_ylim(0.0, 6.0)
        b.set_xlabel("element size [mm]")
        b.set_ylabel("gap between path and bottom hole [mm]")
        legend_below(b)
    write_dataset(dataset, Path(data))


def write_scatter_beam(
    scatter: Paths, scene_file: str, variants: Variants, picture: Paths, data: Paths
) -> None:
    """Draw the paths on ten grids, and how many of them end where.

    Parameters
    ----------
    scatter : Path
        Of the study scatter_beam.
    scene_file : str
    variants : mapping of str to mapping
        As in `write_fig15`, of all specimens.
    picture, data : Path
    """
    dataset = xr.load_dataset(scatter)
    with panels(Path(picture), (WIDTH, 8.6), len(HOW), len(SPECIMENS)) as axes:
        for row, (how, text) in zip(axes, HOW.items(), strict=True):
            for one, case in zip(row, SPECIMENS, strict=True):
                draw_body(one, load_scene(scene_file, variants[f"as_printed_{case}"]))
                found = outcomes(dataset, "crack_1", case=case, how=how)
                draw_band(one, [each.path for each in found], "", AS_PRINTED)
                ends = [f"{n} {end}" for end, n in shares(found, beam_ending).items()]
                told = "\n".join([f"of {len(found)} grids:", *ends])
                one.text(178.0, 3.0, told, fontsize=5.5, va="bottom")
                printed = " (as printed)" if how == AS_IN_THE_PAPER[case] else ""
                one.set_title(f"{_short(case)}\n{text}{printed}", fontsize=SMALL)
                one.set_xlim(85.0, 335.0)
                one.set_ylim(-3.0, 206.0)
                one.set_xlabel("x [mm]", labelpad=0.0)
    write_dataset(dataset[["tip_x", "tip_y", "tip_status", "n_points", "run_status"]], Path(data))


def _short(case: str) -> str:
    return SPECIMENS[case].replace(" (", ": ").replace(" as ", ": ").rstrip(")")


def _holes_in_view(axes: Axes) -> None:
    axes.set_xlim(90.0, 265.0)
    axes.set_ylim(-4.0, 207.0)
