"""Figures 4 to 7 of section 5.1, each with the dataset behind it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from cfmpm.output.files import write_dataset
from cfmpm.plotting import Mesh, draw_grid, draw_tip_forces
from cfmpm.plotting.curves import draw_curve, draw_level, draw_power
from cfmpm.plotting.style import panels

NORM = "norm of CF [N/mm]"
ANGLE = "angle of CF [deg]"


def write_fig4(
    grids: str | Path, drawn: Sequence[int], picture: str | Path, data: str | Path
) -> None:
    """Draw four of the discretisations.

    Parameters
    ----------
    grids : Path
        From `datasets.write_datasets`.
    drawn : sequence of int
        Which grids.
    picture, data : Path
        The PNG and the netCDF file to be written.
    """
    dataset = xr.load_dataset(grids).sel(grid=list(drawn))
    dataset = dataset[["node_x", "node_y", "triangle", "tip_node"]]
    with panels(Path(picture), (9.0, 4.6), 1, len(drawn)) as axes:
        for one, wanted in zip(axes.flat, drawn, strict=True):
            mesh, _ = _mesh(dataset.sel(grid=wanted))
            draw_grid(one, mesh)
            one.set_title(f"{len(mesh.faces)} points, T3")
            one.label_outer()
    write_dataset(dataset, Path(data))


def write_fig5(
    series: str | Path, radius: float, converged: float, picture: str | Path, data: str | Path
) -> None:
    """Draw norm and angle of CF against the number of points; tip and domain, MPM and FEM.

    Parameters
    ----------
    series : Path
        Of T3, from `datasets.write_datasets`.
    radius : float
        Of the domain [mm].
    converged : float
        G of the plate [N/mm].
    picture, data : Path
    """
    dataset = xr.load_dataset(series).sel(radius=radius)
    mpm, fem = dataset.sel(scheme="MPM"), dataset.sel(scheme="FEM")
    n = mpm.n_points
    around = f"domain, R = {radius:g} mm"
    with panels(Path(picture), (9.0, 6.6), 2, 2) as axes:
        draw_curve(axes[0, 0], n, mpm.cf_tip_norm, "tip node only", 1)
        draw_curve(axes[0, 0], n, mpm.cf_norm, around, 0)
        draw_curve(axes[0, 1], n, mpm.cf_tip_angle, "tip node only", 1)
        draw_curve(axes[0, 1], n, mpm.cf_angle, around, 0)
        for one, name in ((axes[1, 0], "norm"), (axes[1, 1], "angle")):
            for part, label, style in (("cf_tip", "tip node only", 1), ("cf", around, 0)):
                draw_curve(one, n, fem[f"{part}_{name}"], f"FEM, {label}", style, hollow=True)
                draw_curve(one, n, mpm[f"{part}_{name}"], f"MPM, {label}", style)
        axes[1, 0].set_title(
            f"nodal CF of MPM and FEM differ by {float(dataset.cf_difference.max()):.0e}"
        )
        for one in axes.flat:
            _points_axis(one)
            one.margins(y=0.25)
        _norm_and_angle(axes[:, 0], axes[:, 1], dataset.handbook, converged)
    write_dataset(dataset.assign_attrs(converged=converged), Path(data))


def write_fig6(
    series: str | Path,
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
    series, grids : Path
        Of T3, from `datasets.write_datasets`.
    swept : sequence of int
        Which grids.
    radius : float
        Of the domain in the pictures [mm].
    converged : float
        G of the plate [N/mm].
    picture, data : Path
    """
    swept = list(swept)
    sweep = xr.load_dataset(series).sel(scheme="MPM", grid=swept)
    vectors = xr.load_dataset(grids).sel(grid=swept)
    with panels(Path(picture), (9.0, 9.4), 2, 2) as axes:
        for k, wanted in enumerate(swept):
            one = sweep.sel(grid=wanted)
            label = f"{int(one.n_points)} points"
            draw_curve(axes[0, 0], one.radius, one.cf_norm, label, k)
            draw_curve(axes[0, 1], one.radius, one.cf_angle, label, k)
            mesh, force = _mesh(vectors.sel(grid=wanted))
            tip = int(vectors.tip_node.sel(grid=wanted))
            draw_tip_forces(axes[1, k], mesh, force, tip, radius)
            axes[1, k].set_title(label)
            axes[1, k].legend(loc="upper left", bbox_to_anchor=(0.0, -0.14))
        for one in axes[0]:
            one.set_xlabel("domain radius R [mm]")
            one.set_xlim(left=0)
        _norm_and_angle(axes[0, :1], axes[0, 1:], sweep.handbook, converged)
    names = ["cf_norm", "cf_angle", "cf_tip_norm", "cf_tip_angle", "J", "n_points"]
    dataset = xr.merge([sweep[names], vectors], combine_attrs="drop_conflicts")
    dataset.attrs |= {"handbook": sweep.handbook, "converged": converged}
    write_dataset(dataset, Path(data))


def write_fig7(
    series: dict[str, str | Path],
    radius: float,
    converged: float,
    picture: str | Path,
    data: str | Path,
) -> None:
    """Draw T3 against T6: norm of CF against points and unknowns, and its error.

    Parameters
    ----------
    series : dict of str to Path
        T3, T6 and T6_graded, from `datasets.write_datasets`.
    radius : float
        Of the domain [mm].
    converged : float
        G of the plate [N/mm], from which the error is counted.
    picture, data : Path
    """
    uniform = {name: xr.load_dataset(series[name]) for name in ("T3", "T6")}
    graded = xr.load_dataset(series["T6_graded"])
    curves = {
        "T3, one point a triangle": uniform["T3"],
        "T6, three points a triangle": uniform["T6"],
        "T6, graded to the tip (not in the paper)": graded,
    }
    with panels(Path(picture), (11.0, 4.2), 1, 3) as axes:
        a, b, c = axes.flat
        for k, (label, whole) in enumerate(curves.items()):
            one = whole.sel(scheme="MPM", radius=radius)
            draw_curve(a, one.n_points, one.cf_norm, label, k)
            draw_curve(b, one.n_unknowns, one.cf_norm, label, k)
            draw_curve(c, one.n_unknowns, np.abs(one.cf_norm / converged - 1.0), label, k)
        first = uniform["T3"].sel(scheme="MPM", radius=radius).isel(grid=0)
        start = float(first.n_unknowns)
        error = 1.6 * abs(float(first.cf_norm) / converged - 1.0)
        draw_power(c, (start, 40 * start), error, -0.5, "order h")
        c.set_yscale("log")
        c.set_ylabel("|CF / converged - 1| [1]")
        _points_axis(a)
        for one in (b, c):
            one.set_xscale("log")
            one.set_xlabel("unknowns [1]")
        for one in (a, b):
            one.set_ylabel(NORM)
            one.set_ylim(0.13, 0.27)
            _levels(one, first.handbook, converged)
        a.legend(loc="lower right", fontsize=7)
    dataset = xr.concat(uniform.values(), "element", combine_attrs="drop_conflicts")
    dataset = dataset.assign_coords(element=list(uniform)).sel(radius=radius)
    add = graded.sel(radius=radius, scheme="MPM", drop=True)[["cf_norm", "n_points", "n_unknowns"]]
    dataset = dataset.assign({f"graded_{k}": v.rename(grid="graded") for k, v in add.items()})
    write_dataset(dataset.assign_attrs(converged=converged), Path(data))


def _norm_and_angle(
    norms: Sequence[Axes], angles: Sequence[Axes], handbook: float, converged: float
) -> None:
    for one in norms:
        one.set_ylabel(NORM)
        _levels(one, handbook, converged)
        one.legend(loc="lower right", fontsize=7)
    for one in angles:
        one.set_ylabel(ANGLE)
        draw_level(one, 0.0, "along the crack", line=":")
        one.legend(loc="lower right", fontsize=7)


def _levels(axes: Axes, handbook: float, converged: float) -> None:
    """The paper's analytical line and the answer of the plate itself."""
    draw_level(axes, handbook, f"{handbook:.4f}: handbook, infinitely long strip (paper)")
    draw_level(axes, converged, f"{converged:.6f}: this plate, converged", line=":")


def _points_axis(axes: Axes) -> None:
    axes.set_xscale("log")
    axes.set_xlabel("material points [1]")


def _mesh(grid: xr.Dataset) -> tuple[Mesh, np.ndarray]:
    """One grid without its unused places, and the CF of its nodes (n, 2) if it is kept."""
    triangles = grid.triangle.values
    triangles = triangles[triangles[:, 0] >= 0].astype(np.int64)
    n = triangles.max() + 1
    nodes = np.column_stack([grid.node_x, grid.node_y])[:n]
    force = np.column_stack([grid.cf_x, grid.cf_y])[:n] if "cf_x" in grid else np.zeros((0, 2))
    return Mesh(nodes, triangles, np.arange(len(triangles))), force
