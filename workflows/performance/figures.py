"""Plots of run time against error and against size."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from cfmpm.plotting.curves import draw_curve, draw_power
from cfmpm.plotting.style import panels


def draw_work_precision(data: str | Path, picture: str | Path) -> None:
    """Draw the error of J against wall time and against unknowns.

    Parameters
    ----------
    data : Path
        From `work_precision.measure`.
    picture : Path
    """
    dataset = xr.load_dataset(data)
    times = {
        "mesh, solve and post": dataset.seconds.sum("phase"),
        "solve alone: assembly, factorisation, stress": dataset.seconds.sel(phase="solve"),
    }
    names = list(dict.fromkeys(dataset.series.values))
    with panels(Path(picture), (11.0, 8.4), 2, 2) as axes:
        for k, series in enumerate(names):
            _draw_best(axes[0, 0], dataset, times["mesh, solve and post"], series, k)
            here = (dataset.series == series) & (dataset.program == "cfmpm")
            one = dataset.isel(run=np.flatnonzero(here & (dataset.solver == _first(dataset))))
            draw_curve(axes[0, 1], one.n_unknowns, one.error, series, k)
        for one_axes, series in zip(axes[1], (names[0], names[-1]), strict=True):
            here = dataset.series == series
            pairs = dict.fromkeys(
                zip(dataset.program[here].values, dataset.solver[here].values, strict=True)
            )
            for k, (program, solver) in enumerate(pairs):
                run = np.flatnonzero(
                    here & (dataset.program == program) & (dataset.solver == solver)
                )
                seconds = times["solve alone: assembly, factorisation, stress"].isel(run=run)
                draw_curve(
                    one_axes,
                    seconds,
                    dataset.error.isel(run=run),
                    f"{program}, {solver}",
                    k,
                    line="--" if program == "scikit-fem" else "-",
                )
            one_axes.set_title(f"{series}: all solvers, without mesh")
            one_axes.set_xlabel("wall time of assembly, solution and stress [s]")
        axes[0, 0].set_title("full: cfmpm, dashed: scikit-fem; fastest solver of each")
        axes[0, 0].set_xlabel("wall time with mesh and post-processing [s]")
        axes[0, 1].set_title("the grids: cfmpm and scikit-fem agree to round-off")
        axes[0, 1].set_xlabel("unknowns")
        for one_axes in axes.flat:
            one_axes.set_xscale("log")
            one_axes.set_yscale("log")
            one_axes.set_ylabel("|J / converged - 1|")
            one_axes.legend(fontsize=7)


def draw_scaling(data: str | Path, picture: str | Path) -> None:
    """Draw the wall time of each phase against the number of points.

    Parameters
    ----------
    data : Path
        From `scaling.measure`.
    picture : Path
    """
    dataset = xr.load_dataset(data)
    with panels(Path(picture), (10.0, 4.6), 1, dataset.sizes["element"]) as axes:
        for one_axes, element in zip(axes.flat, dataset.element.values, strict=True):
            one = dataset.sel(element=element)
            for k, phase in enumerate(one.phase.values):
                label = f"{phase} ~ n^{float(one.exponent.sel(phase=phase)):.2f}"
                draw_curve(one_axes, one.n_points, one.wall_time.sel(phase=phase), label, k)
            total = one.wall_time.sum("phase", min_count=1)
            draw_curve(one_axes, one.n_points, total, "all", -1)
            ends = float(one.n_points.min()), float(one.n_points.max())
            draw_power(one_axes, ends, 2.0 * float(total.isel(rank=0)), 1.0, "n")
            one_axes.set_title(f"{element}: phases, exponents fitted from 10 000 points")
            one_axes.set_xscale("log")
            one_axes.set_yscale("log")
            one_axes.set_xlabel("material points")
            one_axes.set_ylabel("wall time [s]")
            one_axes.legend(fontsize=7)


def _draw_best(
    axes: Axes, dataset: xr.Dataset, seconds: xr.DataArray, series: str, style: int
) -> None:
    """Of each program the fastest solver on each grid."""
    for program, line in (("cfmpm", "-"), ("scikit-fem", "--")):
        here = np.flatnonzero((dataset.series == series) & (dataset.program == program))
        unknowns = dataset.n_unknowns.isel(run=here).values
        fastest = [
            here[unknowns == n][int(np.argmin(seconds.isel(run=here[unknowns == n]).values))]
            for n in np.unique(unknowns)
        ]
        label = series if program == "cfmpm" else "_nolegend_"
        draw_curve(
            axes,
            seconds.isel(run=fastest),
            dataset.error.isel(run=fastest),
            label,
            style,
            line=line,
            hollow=program == "scikit-fem",
        )


def _first(dataset: xr.Dataset) -> str:
    return str(dataset.solver[0].item())
