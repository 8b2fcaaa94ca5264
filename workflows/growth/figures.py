"""Figures 9 to 16 of sections 5.2 to 5.5, each with the dataset behind it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import cycle
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from cfmpm.body.grid import Floats
from cfmpm.output.files import write_dataset
from cfmpm.plotting import curves
from cfmpm.plotting.style import BLACK, GREY, length_axes, panels
from cfmpm.scene import load_scene
from cfmpm.scene.geometry import BodyShape
from workflows.growth.datasets import segment_angles, steps, tip_path
from workflows.reference.path_points import reference

INCH = 25.4
# Holes of the beam that cracks come to, and their radius [mm].
BOTTOM, MIDDLE, HOLE = np.array([6.0, 2.75]) * INCH, np.array([6.0, 4.75]) * INCH, 0.25 * INCH
Paths = str | Path


def write_fig9(growth: Paths, picture: Paths, data: Paths) -> None:
    """Draw the angle of CF along the straight crack, at the tip and over the domain (5.2).

    Parameters
    ----------
    growth : Path
        From `datasets.write_growth`; as in all figures here.
    picture, data : Path
        The PNG and the netCDF file to be written.
    """
    dataset = xr.load_dataset(growth)
    with panels(Path(picture), (9.0, 3.8), 1, 2) as axes:
        for one, n in zip(axes.flat, (790, 2584), strict=True):
            run = steps(dataset, f"cf_{n}").isel(tip=0)
            ahead = run.cf_angle.notnull()
            # CF at the tip node is stored by its components; the tangent is that of the last
            # segment.
            tangent = np.append(0.0, segment_angles(tip_path(dataset, f"cf_{n}")))
            at_tip = np.degrees(np.arctan2(run.cf_tip_y, run.cf_tip_x)) - tangent
            x = run.tip_x.where(ahead)
            curves.draw_curve(one, x, at_tip, "tip node only", 1)
            curves.draw_curve(one, x, run.cf_angle, "domain", 0)
            near = float(x.where(run.domain_radius < _resolved(run)).min())
            one.axvspan(near, 500.0, color=GREY, alpha=0.15, lw=0, label="domain < 2 elements")
            one.set_title(_points(dataset, f"cf_{n}"))
            one.set_ylim(-10.0, 15.0)
            one.set_xlabel("x of the crack tip [mm]")
            one.set_ylabel("angle of CF from the crack [deg]")
            one.legend(loc="upper left", fontsize=7)
    write_dataset(dataset.sel(variant=["cf_790", "cf_2584"]), Path(data))


def write_fig10(growth: Paths, scene_file: str, picture: Paths, data: Paths) -> None:
    """Draw the trajectories of the edge crack, and how far they leave the middle (5.2)."""
    dataset = xr.load_dataset(growth)
    with panels(Path(picture), (11.0, 4.2), 1, 3) as axes:
        _draw_body(axes[0, 0], scene_file)
        _draw_path(axes[0, 0], tip_path(dataset, "cf_2584"), "CF direction", 0)
        length_axes(axes[0, 0])
        axes[0, 0].set_title(f"CF direction, {_points(dataset, 'cf_2584')}")
        for one, n in zip(axes.flat[1:], (790, 2584), strict=True):
            for k, (kind, label) in enumerate(
                {
                    "cf": "CF direction",
                    "hoop": "largest hoop stress",
                    "paper": "CF, paper's transfer",
                }.items()
            ):
                x, y = tip_path(dataset, f"{kind}_{n}").T
                curves.draw_curve(one, x, y - 500.0, f"{label} (ends at {y[-1] - 500:+.1f})", k)
            curves.draw_level(one, 0.0, "middle of the plate", line=":")
            one.set_title(_points(dataset, f"cf_{n}"))
            one.set_xlabel("x of the crack tip [mm]")
            one.set_ylabel("y - 500 [mm]")
            one.set_ylim(-6.0, 6.0)
            one.legend(loc="lower left", fontsize=7)
    write_dataset(dataset, Path(data))


def write_fig11(growth: Paths, scene_file: str, picture: Paths, data: Paths) -> None:
    """Draw the path under shear, the first steps and on to the edge; Figs 11 and 12 (5.3)."""
    dataset = xr.load_dataset(growth)
    with panels(Path(picture), (10.0, 4.4), 1, 2) as axes:
        _draw_body(axes[0, 0], scene_file)
        _draw_path(axes[0, 0], tip_path(dataset, "cf"), "CF direction", 0)
        length_axes(axes[0, 0])
        segments = len(tip_path(dataset, "cf")) - 1
        axes[0, 0].set_title(f"CF direction, {segments} segments")
        one = axes[0, 1]
        _draw_path(one, tip_path(dataset, "cf"), "CF direction", 0)
        _draw_path(one, tip_path(dataset, "paper"), "CF, paper's transfer", 1)
        _draw_path(one, tip_path(dataset, "t6_second_1.95"), "T6, second order, hoop stress", 2)
        _draw_reference(one, {"reference, increments of 1 mm": reference("shear_plate")})
        _body_axes(one)
        one.set_aspect("auto")
        one.set_xlim(34.0, 71.0)
        one.set_ylim(72.5, 80.5)
    write_dataset(dataset, Path(data))


def write_fig12(growth: Paths, picture: Paths, data: Paths) -> None:
    """Draw how the path under shear converges with the length of its segments (5.3)."""
    dataset = xr.load_dataset(growth)
    x, y = reference("shear_plate_limit").T
    with panels(Path(picture), (9.0, 3.8), 1, 2) as axes:
        for one, order in zip(axes.flat, ("first", "second"), strict=True):
            for k, (kind, label) in enumerate(
                {"hoop": "T3, hoop stress", "t6": "T6, hoop stress"}.items()
            ):
                chosen = [v for v in dataset.variant.values if v.startswith(f"{kind}_{order}")]
                paths = [tip_path(dataset, name) for name in chosen]
                lengths = [np.hypot(*np.diff(path, axis=0)[:-1].T).mean() for path in paths]
                missed = [np.abs(np.interp(x, *path.T) - y).max() for path in paths]
                curves.draw_curve(one, lengths, missed, label, k)
            curves.draw_level(one, 0.15, "0.15 mm")
            one.set_xlim(0.0, 2.8)
            one.set_ylim(0.0, 0.5)
            one.set_xlabel("mean length of a segment [mm]")
            one.set_ylabel("largest distance at x = 40, 50, 60 [mm]")
            one.set_title(f"direction of {order} order")
            one.legend(loc="upper left", fontsize=7)
    write_dataset(dataset, Path(data))


def write_fig13(growth: Paths, scene_file: str, picture: Paths, data: Paths) -> None:
    """Draw the paths of two cracks at two holes, and where they go on rollers (5.4)."""
    dataset = xr.load_dataset(growth)
    shown = {
        "cf": f"CF direction, T3, {_points(dataset, 'cf')}, and the paper's transfer",
        "hoop": "largest hoop stress, T3, half the size",
        "rollers": "edges free to move sideways, T6",
    }
    known = {
        "cf": {"hoop stress": "holes_hoop", "least energy": "holes_energy"},
        "hoop": {"hoop stress": "holes_hoop", "least energy": "holes_energy"},
        "rollers": {"reference on rollers": "holes_rollers"},
    }
    with panels(Path(picture), (7.0, 11.0), 3, 1) as axes:
        for one, (name, label) in zip(axes.flat, shown.items(), strict=True):
            _draw_body(one, scene_file)
            for k, tip in enumerate(dataset.tip.values):
                if name == "cf":
                    _draw_path(one, tip_path(dataset, "paper", tip), f"{tip}, paper's", 2 + k)
                _draw_path(one, tip_path(dataset, name, tip), tip, k)
            _draw_reference(one, {key: reference(file) for key, file in known[name].items()})
            _body_axes(one, (1.0, 1.0))
            one.set_title(label)
    write_dataset(dataset, Path(data))


def write_fig14(growth: Paths, picture: Paths, data: Paths) -> None:
    """Draw the driving force along the paths of the two cracks at fixed displacement (5.4)."""
    dataset = xr.load_dataset(growth)
    with panels(Path(picture), (9.0, 3.8), 1, 2) as axes:
        for one, name in zip(axes.flat, ("cf", "hoop"), strict=True):
            run = steps(dataset, name)
            for k, tip in enumerate(run.tip.values):
                alone = run.sel(tip=tip)
                curves.draw_curve(one, alone.crack_length, alone.cf_norm, str(tip), k)
            curves.draw_level(one, 1.0, "g_c")
            one.set_yscale("log")
            one.set_xlabel("length of the crack [mm]")
            one.set_ylabel("norm of CF [N/mm]")
            one.set_title("CF direction" if name == "cf" else "largest hoop stress, half the size")
            one.legend(loc="lower left", fontsize=7)
    write_dataset(dataset.sel(variant=["cf", "hoop"]), Path(data))


def write_fig15(growth: Paths, scene_file: str, picture: Paths, data: Paths) -> None:
    """Draw the paths in the beam with three holes, of three specimens (5.5)."""
    dataset = xr.load_dataset(growth)
    specimens = {
        "15_5": "a = 1.5 in, x = 5 in: the paper's I",
        "10_4": "a = 1.0 in, x = 4 in",
        "10_6": "a = 1.0 in, x = 6 in: perhaps the paper's II",
    }
    with panels(Path(picture), (10.0, 6.4), 1, 3) as axes:
        for one, (case, label) in zip(axes.flat, specimens.items(), strict=True):
            _draw_body(one, scene_file)
            _draw_path(one, tip_path(dataset, f"cf_{case}"), "CF direction, T3", 0)
            if f"paper_{case}" in dataset.variant:
                _draw_path(one, tip_path(dataset, f"paper_{case}"), "CF, paper's transfer", 1)
            _draw_path(one, tip_path(dataset, f"hoop_{case}"), "hoop stress, T6", 2)
            _draw_reference(one, {"reference": reference(f"beam_{case}")})
            _body_axes(one, (0.0, -0.12))
            one.set_xlim(85.0, 215.0)
            one.set_title(label)
    write_dataset(dataset, Path(data))


def write_fig16(
    growth: Paths, scene_file: str, sizes: Sequence[int], picture: Paths, data: Paths
) -> None:
    """Draw how the crack misses the bottom hole, on finer and finer grids (5.5).

    Parameters
    ----------
    growth : Path
    scene_file : str
    sizes : sequence of int
        Element sizes, coarse to fine [mm].
    picture, data : Path
    """
    dataset = xr.load_dataset(growth)
    with panels(Path(picture), (9.0, 4.4), 1, 2) as axes:
        a, b = axes.flat
        _draw_body(a, scene_file)
        for k, size in enumerate(sizes):
            _draw_path(a, tip_path(dataset, f"first_{size}"), f"size {size} mm", k)
        _draw_reference(
            a, {"remeshing": reference("beam_15_5"), "XFEM": reference("beam_15_5_xfem")}
        )
        _body_axes(a, (1.0, 1.0))
        a.set_xlim(128.0, 165.0)
        a.set_ylim(52.0, 92.0)
        a.set_title("direction of first order")
        for k, order in enumerate(("first", "second")):
            gaps = [gap_to_hole(tip_path(dataset, f"{order}_{size}"), BOTTOM) for size in sizes]
            curves.draw_curve(b, sizes, gaps, f"T3, hoop stress, {order} order", k)
        for label, file, line in (
            ("remeshing", "beam_15_5", "--"),
            ("XFEM", "beam_15_5_xfem", ":"),
        ):
            known = gap_to_hole(reference(file), BOTTOM)
            curves.draw_level(b, known, f"{label}: {known:.1f} mm", line=line)
        b.set_ylim(0.0, 6.0)
        b.set_xlabel("element size [mm]")
        b.set_ylabel("gap between path and bottom hole [mm]")
        b.legend(loc="upper left", fontsize=7)
    write_dataset(dataset, Path(data))


def distance_to_path(path: Floats, point: Floats) -> float:
    """Return the smallest distance from a point to a path [mm]."""
    start, along = path[:-1], np.diff(path, axis=0)
    part = np.clip(((point - start) * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
    return float(np.hypot(*(start + part[:, None] * along - point).T).min())


def gap_to_hole(path: Floats, hole: Floats) -> float:
    """Return the distance of a path from the edge of a hole, negative inside it [mm]."""
    return distance_to_path(path, hole) - HOLE


def _points(dataset: xr.Dataset, variant: str) -> str:
    """How many material points a variant begins with."""
    return f"{int(steps(dataset, variant).n_points[0])} points"


def _resolved(run: xr.Dataset) -> float:
    """Two mean segments: the radius below which a domain holds but tip elements [mm]."""
    return 2.0 * float(run.crack_length.diff("step")[:-1].mean())


def _draw_body(axes: Axes, scene_file: str) -> None:
    body = BodyShape.of(load_scene(scene_file))
    for ring in (body.polygon.exterior, *body.polygon.interiors):
        axes.plot(*np.array(ring.coords).T, color=BLACK, lw=0.8)


def _draw_path(axes: Axes, path: Floats, label: str, style: int) -> None:
    colour, marker = curves.STYLES[style]
    axes.plot(*path.T, color=colour, marker=marker, ms=2.2, lw=1.1, label=label)


def _draw_reference(axes: Axes, named: Mapping[str, Floats]) -> None:
    for (label, points), marker in zip(named.items(), cycle("sD")):
        axes.plot(*points.T, marker, ms=5.0, mew=0.8, mfc="none", mec=GREY, label=label)


def _body_axes(axes: Axes, anchor: tuple[float, float] | None = None) -> None:
    length_axes(axes)
    axes.legend(loc="upper left" if anchor else "best", bbox_to_anchor=anchor, fontsize=7)
