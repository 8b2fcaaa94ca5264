"""Figures 4 to 7 of section 5.1, each with the dataset behind it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from cfmpm.output.files import write_dataset
from cfmpm.plotting import Mesh, draw_grid
from cfmpm.plotting.curves import draw_curve, draw_level, draw_power
from cfmpm.plotting.style import BLUE, GREY, VERMILLION, panels
from cfmpm.scene import load_scene
from cfmpm.scene.specimens.single_edge import SingleEdge
from workflows.section_5_1.datasets import OF_GRIDS
from workflows.section_5_1.nodal_forces import draw_nodal_forces
from workflows.section_5_1.plate import draw_plate, frame_plate
from workflows.section_5_1.settings import SERIES

NORM = "norm of CF [N/mm]"
ANGLE = "angle of CF [deg]"
# Width of a page in print: 170 mm [inch].
WIDE = 6.6
SMALL = 7
AT_TIP, BEST = "tip node only", "best: T6 graded to the tip"
# Radii of the domain that the paper names for its two grids [mm]: 5.1, pages 10 and 11.
STATED = {2584: 20.0, 8068: 10.0}


def write_fig4(
    grids: str | Path,
    drawn: Sequence[str],
    scene_file: str,
    radius: float,
    picture: str | Path,
    data: str | Path,
) -> None:
    """Draw the plate with its load, and discretisations with their material points.

    Parameters
    ----------
    grids : Path
        From `datasets.write_datasets`.
    drawn : sequence of str
        Which grids, by their names in the study.
    scene_file : str
        Of a plate under traction.
    radius : float
        Of the domain [mm].
    picture, data : Path
        The PNG and the netCDF file to be written.
    """
    dataset = xr.load_dataset(grids).sel(grid=list(drawn))
    dataset = dataset.drop_vars(["cf_node_x", "cf_node_y"])
    plate = load_scene(scene_file).family
    assert isinstance(plate, SingleEdge)
    columns = (len(drawn) + 2) // 2
    with panels(Path(picture), (WIDE, 9.2), 2, columns) as axes:
        draw_plate(axes.flat[0], plate, radius)
        axes.flat[0].set_title("geometry and load")
        for one, name in zip(axes.flat[1:], drawn, strict=False):
            grid = dataset.sel(grid=name)
            mesh, _ = _mesh(grid)
            draw_grid(one, mesh, width=0.25)
            points = _kept(grid.point_x, grid.point_y)
            size = 2.2 * np.sqrt(790 / len(points))
            one.plot(*points.T, "o", color=BLUE, ms=min(size, 2.2), mew=0.0)
            one.plot([0.0, plate.crack_length], 2 * [plate.height / 2], color=VERMILLION, lw=1.2)
            one.set_title(f"{_element(name)}, {len(points)} points")
            frame_plate(one, plate)
        for one in axes.flat:
            one.label_outer()
        for one in axes.flat[len(drawn) + 1 :]:
            one.set_visible(False)
    write_dataset(dataset, Path(data))


def write_fig5(
    series: Mapping[str, str | Path],
    radius: float,
    converged: float,
    picture: str | Path,
    data: str | Path,
) -> None:
    """Draw norm and angle of CF against the number of points; tip and domain, MPM and FEM.

    Parameters
    ----------
    series : mapping of str to Path
        T3 and T6_graded, from `datasets.write_datasets`.
    radius : float
        Of the domain [mm].
    converged : float
        G of the plate [N/mm].
    picture, data : Path
    """
    dataset = xr.load_dataset(series["T3"]).sel(radius=radius)
    best = xr.load_dataset(series["T6_graded"]).sel(radius=radius)
    around = f"domain, R = {radius:g} mm"
    with panels(Path(picture), (WIDE, 6.4), 2, 2) as axes:
        for row, scheme in enumerate(("MPM", "FEM")):
            one, further = dataset.sel(scheme=scheme), best.sel(scheme=scheme)
            for column, name in enumerate(("norm", "angle")):
                at = axes[row, column]
                for part, label, style in (("cf_tip", AT_TIP, 1), ("cf", around, 0)):
                    draw_curve(at, one.n_points, one[f"{part}_{name}"], label, style)
                draw_curve(at, further.n_points, further[f"cf_{name}"], BEST, 2, hollow=True)
                at.set_title(f"{name}, {scheme}, T3")
                at.set_xscale("log")
                at.set_xlabel("material points [1]" if row == 0 else "triangles [1]")
                if row == 1:
                    at.lines[0].set_xdata(one.n_elements)
                    at.lines[1].set_xdata(one.n_elements)
                    at.lines[2].set_xdata(further.n_elements)
        _norm_and_angle(axes[:, 0], axes[:, 1], dataset.handbook, converged)
    kept = best[["cf_norm", "cf_angle", "n_points", "n_elements"]].rename(grid="graded")
    dataset = dataset.assign({f"best_{k}": v for k, v in kept.data_vars.items()})
    write_dataset(dataset.assign_attrs(converged=converged), Path(data))


def write_fig6(
    series: Mapping[str, str | Path],
    grids: str | Path,
    swept: Sequence[int],
    radius: float,
    converged: float,
    picture: str | Path,
    data: str | Path,
) -> None:
    """Draw CF against the domain radius, and the CF of the nodes around the tip.

    Parameters
    ----------
    series : mapping of str to Path
        T3 and T6_graded, from `datasets.write_datasets`.
    grids : Path
        From `datasets.write_datasets`.
    swept : sequence of int
        Which grids.
    radius : float
        Of the domain in the pictures [mm].
    converged : float
        G of the plate [N/mm].
    picture, data : Path
    """
    sweep = xr.load_dataset(series["T3"]).sel(scheme="MPM", grid=list(swept))
    best = xr.load_dataset(series["T6_graded"]).sel(scheme="MPM").isel(grid=-1)
    vectors = xr.load_dataset(grids).sel(grid=[f"T3_{wanted}" for wanted in swept])
    with panels(Path(picture), (WIDE, 7.6), 2, 2) as axes:
        axes[0, 0].figure.get_layout_engine().set(wspace=0.06)
        for row, wanted in enumerate(swept):
            one = sweep.sel(grid=wanted)
            points = int(one.n_points)
            _draw_sweep(axes[row, 0], one, best, wanted)
            axes[row, 0].set_title(f"CF by the radius, {points} points")
            mesh, force = _mesh(vectors.isel(grid=row))
            draw_nodal_forces(
                axes[row, 1], mesh, force, int(vectors.tip_node.isel(grid=row)), radius
            )
            axes[row, 1].set_title(f"CF of the nodes, {points} points")
    names = ["cf_norm", "cf_angle", "cf_tip_norm", "cf_tip_angle", "J", "n_points"]
    further = {f"best_{name}": best[name].drop_vars("grid") for name in names[:2]}
    dataset = sweep[names].assign(further)
    dataset = dataset.assign(
        {
            name: (vectors[name].dims, vectors[name].values)
            for name in OF_GRIDS
            if name != "n_points"
        }
    )
    dataset.attrs |= {"handbook": sweep.handbook, "converged": converged}
    write_dataset(dataset, Path(data))


def _draw_sweep(axes: Axes, sweep: xr.Dataset, best: xr.Dataset, wanted: int) -> None:
    """Norm on the left and angle on the right against the radius, as in the paper's Fig. 6."""
    draw_curve(axes, sweep.radius, sweep.cf_norm, "norm", 0)
    draw_curve(axes, best.radius, best.cf_norm, "norm, best: T6 graded", 0, hollow=True, line="")
    axes.set_ylabel(NORM)
    axes.set_ylim(0.13, 0.27)
    axes.set_xlim(0, 95)
    axes.set_xlabel("domain radius R [mm]")
    right = axes.twinx()
    right.spines["right"].set_visible(True)
    draw_curve(right, sweep.radius, sweep.cf_angle, "angle (right axis)", 1)
    right.set_ylabel(ANGLE)
    right.set_ylim(-1.0, 3.2)
    right.axhline(0.0, color=GREY, lw=0.6, zorder=0)
    radius = STATED[wanted]
    axes.axvline(radius, color=GREY, ls=":", lw=1.0)
    axes.annotate(
        f" paper: settled\n from {radius:g} mm", (radius, 0.134), color=GREY, fontsize=SMALL
    )
    lines = [*axes.get_lines()[:2], right.get_lines()[0]]
    axes.legend(
        lines,
        [str(one.get_label()) for one in lines],
        loc="lower right",
        fontsize=SMALL,
        bbox_to_anchor=(1.0, 0.28),
    )


def write_fig7(
    series: Mapping[str, str | Path],
    radius: float,
    converged: float,
    picture: str | Path,
    data: str | Path,
) -> None:
    """Draw T3 against T6: norm and angle of CF against points.

    Parameters
    ----------
    series : mapping of str to Path
        T3, T6 and T6_graded, from `datasets.write_datasets`.
    radius : float
        Of the domain [mm].
    converged : float
        G of the plate [N/mm].
    picture, data : Path
    """
    found = {name: xr.load_dataset(series[name]).sel(radius=radius) for name in SERIES}
    with panels(Path(picture), (WIDE, 3.6), 1, 2) as axes:
        for k, (name, label) in enumerate(SERIES.items()):
            one = found[name].sel(scheme="MPM")
            for at, quantity in zip(axes.flat, ("cf_norm", "cf_angle"), strict=True):
                draw_curve(at, one.n_points, one[quantity], label, k, hollow=name == "T6_graded")
        for at, title in zip(axes.flat, ("norm", "angle"), strict=True):
            at.set_title(f"{title}, R = {radius:g} mm")
            at.set_xscale("log")
            at.set_xlabel("material points [1]")
        _norm_and_angle(axes[:, 0], axes[:, 1], found["T3"].handbook, converged)
    names = ["cf_norm", "cf_angle", "n_points", "n_unknowns"]
    dataset = xr.concat(
        [found[name][names] for name in ("T3", "T6")], "element", combine_attrs="drop_conflicts"
    ).assign_coords(element=["T3", "T6"])
    further = found["T6_graded"][names].rename(grid="graded")
    dataset = dataset.assign({f"best_{k}": v for k, v in further.data_vars.items()})
    write_dataset(dataset.assign_attrs(converged=converged), Path(data))


def write_error(
    series: Mapping[str, str | Path],
    radius: float,
    converged: float,
    picture: str | Path,
    data: str | Path,
) -> None:
    """Draw what an unknown buys: norm of CF and its error against the number of unknowns.

    Parameters
    ----------
    series, radius, converged, picture, data
        As of `write_fig7`.
    """
    found = {name: xr.load_dataset(series[name]).sel(radius=radius) for name in SERIES}
    with panels(Path(picture), (WIDE, 3.4), 1, 2) as axes:
        for k, (name, label) in enumerate(SERIES.items()):
            one = found[name].sel(scheme="MPM")
            draw_curve(axes[0, 0], one.n_unknowns, one.cf_norm, label, k)
            draw_curve(axes[0, 1], one.n_unknowns, abs(one.cf_norm / converged - 1.0), label, k)
        first = found["T3"].sel(scheme="MPM").isel(grid=0)
        start = float(first.n_unknowns)
        error = 1.8 * abs(float(first.cf_norm) / converged - 1.0)
        draw_power(axes[0, 1], (start, 40 * start), error, -0.5, "order h")
        for one in axes.flat:
            one.set_xscale("log")
            one.set_xlabel("unknowns [1]")
        axes[0, 0].set_ylabel(NORM)
        axes[0, 0].set_ylim(0.13, 0.27)
        _levels(axes[0, 0], found["T3"].handbook, converged)
        axes[0, 0].legend(loc="lower right", fontsize=SMALL)
        axes[0, 1].set_yscale("log")
        axes[0, 1].set_ylabel("|CF / converged - 1| [1]")
    names = ["cf_norm", "n_points", "n_unknowns"]
    dataset = xr.concat(
        [one[names].sel(scheme="MPM").rename(grid="member") for one in found.values()],
        "element",
        join="outer",
        combine_attrs="drop_conflicts",
    ).assign_coords(element=list(SERIES))
    write_dataset(dataset.assign_attrs(converged=converged), Path(data))


def _norm_and_angle(
    norms: Sequence[Axes], angles: Sequence[Axes], handbook: float, converged: float
) -> None:
    for one in norms:
        one.set_ylabel(NORM)
        one.set_ylim(0.12, 0.265)
        _levels(one, handbook, converged)
        one.legend(loc="lower right", fontsize=7)
    for one in angles:
        one.set_ylabel(ANGLE)
        one.set_ylim(-2.9, 1.3)
        draw_level(one, 0.0, "along the crack", line=":")
        one.legend(loc="lower right", fontsize=7)


def _levels(axes: Axes, handbook: float, converged: float) -> None:
    """The paper's analytical line and the answer of the plate itself."""
    draw_level(axes, handbook, f"{handbook:.4f}: handbook, infinite strip (paper)")
    draw_level(axes, converged, f"{converged:.4f}: this plate, converged", line=":")


def _element(name: str) -> str:
    """What a grid of the study is called in a figure."""
    return "best: T6" if "graded" in name else name.split("_")[0]


def _kept(x: xr.DataArray, y: xr.DataArray) -> np.ndarray:
    """Places without unused ones, (n, 2)."""
    places = np.column_stack([x, y])
    return places[~np.isnan(places[:, 0])]


def _mesh(grid: xr.Dataset) -> tuple[Mesh, np.ndarray]:
    """One grid without its unused places, and the CF of its nodes (n, 2) if it is kept."""
    triangles = grid.triangle.values
    triangles = triangles[triangles[:, 0] >= 0].astype(np.int64)
    nodes = _kept(grid.node_x, grid.node_y)
    force = _kept(grid.cf_node_x, grid.cf_node_y) if "cf_node_x" in grid else np.zeros((0, 2))
    return Mesh(nodes, triangles, np.arange(len(triangles))), force
