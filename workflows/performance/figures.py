"""Plots of run time against error and against size."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator

from cfmpm.plotting.curves import draw_curve, draw_power
from cfmpm.plotting.style import BLACK, panels
from workflows.performance.pareto import pareto_front

CPU = "CPU time, mesh to values at the tip [s]"


def draw_work_precision(data: str | Path, picture: str | Path) -> None:
    """Draw errors at stationary cracks against CPU time, the Pareto front, and the defaults.

    Parameters
    ----------
    data : Path
        From `work_precision.measure`; as in all plots here but the last.
    picture : Path
    """
    dataset = xr.load_dataset(data)
    dataset = dataset.isel(run=np.flatnonzero(np.isnan(dataset.distance)))
    grids = np.where(np.isnan(dataset.growth), "uniform", "graded")
    named = zip(dataset.element.values, grids, dataset.formulation.values, strict=True)
    kinds = [f"{element} {grid}, {how}".removesuffix(", total") for element, grid, how in named]
    dataset = dataset.assign_coords(kind=("run", kinds))
    styles = sorted(set(kinds), key=lambda kind: (kind.count(","), kind))
    shown = [
        (runs, quantity)
        for _, runs in dataset.groupby("problem")
        for quantity in _quantities(runs.sel(run=runs.part == "default"))
    ]
    with _plots(picture, len(shown)) as axes:
        for one, (runs, quantity) in zip(axes, shown, strict=True):
            _draw_stationary(one, runs, quantity, styles)
            one.set_title(f"{runs.problem.values[0]}: {quantity}")
            one.set_ylabel(f"relative error of {quantity} [1]")
            one.set_xlabel(CPU)
            one.legend(fontsize=7)


def draw_paths(data: str | Path, picture: str | Path) -> None:
    """Draw the error of each path, and of G along it where that is known, against CPU time."""
    dataset = xr.load_dataset(data)
    dataset = dataset.isel(run=np.flatnonzero(np.isfinite(dataset.distance)))
    shown = []
    for problem, runs in dataset.groupby("problem"):
        shown.append((problem, "distance from the known path [mm]", runs, runs.distance))
        G = runs.error.sel(quantity="G")
        if np.isfinite(G).any():
            shown.append(
                (f"{problem}: G", "largest relative error of G along the path [1]", runs, G)
            )
    with _plots(picture, len(shown)) as axes:
        for one, (title, told, runs, error) in zip(axes, shown, strict=True):
            _draw_ways(one, runs, error)
            one.set_title(title)
            one.set_ylabel(told)
            one.set_xlabel("CPU time of the whole path [s]")
            one.legend(fontsize=7)


@contextmanager
def _plots(picture: str | Path, number: int) -> Iterator[list[Axes]]:
    """Open a figure of plots with two logarithmic axes."""
    columns = (number + 1) // 2
    with panels(Path(picture), (5.5 * columns, 8.6), 2, columns) as axes:
        plots = list(axes.flat)
        for empty in plots[number:]:
            empty.set_visible(False)
        yield plots[:number]
        for one in plots[:number]:
            one.set_xscale("log")
            one.set_yscale("log")
            one.xaxis.set_minor_locator(LogLocator(subs=(2, 5)))
            one.xaxis.set_major_formatter("{x:g}")
            one.xaxis.set_minor_formatter("{x:g}")


def _quantities(default: xr.Dataset) -> list[str]:
    """The quantity that is drawn for a stationary crack: K if it is known, else G."""
    known = np.isfinite(default.error.isel(run=0))
    return [name for name in ("K_I", "K_II") if known.sel(quantity=name)] or ["G"]


def _draw_stationary(axes: Axes, runs: xr.Dataset, quantity: str, styles: Sequence[str]) -> None:
    error = runs.error.sel(quantity=quantity)
    own = (runs.program == "cfmpm") & np.isin(runs.part, ("solvers", "grading", "default"))
    for style, kind in enumerate(styles):
        chosen = np.flatnonzero(own & (runs.kind == kind) & np.isfinite(error))
        if chosen.size:
            draw_curve(axes, runs.cpu[chosen], error[chosen], kind, style, line=" ")
    for element, name, style in (("T3", "P1", 4), ("T6", "P2", 5)):
        chosen = np.flatnonzero((runs.program == "scikit-fem") & (runs.element == element))
        best = chosen[pareto_front(runs.cpu[chosen], error[chosen])]
        if best.size:
            label = f"scikit-fem {name}, on the same grids"
            draw_curve(axes, runs.cpu[best], error[best], label, style, line=" ", hollow=True)
    _draw_front(axes, runs.cpu[own], error[own])
    _draw_default(axes, runs, error)


def _draw_ways(axes: Axes, runs: xr.Dataset, error: xr.DataArray) -> None:
    """By direction and order; open marks are T3."""
    ways = dict.fromkeys(zip(runs.direction.values, runs.order.values, strict=True))
    for style, (direction, order) in enumerate(sorted(ways)):
        for element, hollow in (("T6", False), ("T3", True)):
            here = (runs.direction == direction) & (runs.order == order)
            here &= (runs.element == element) & (runs.part == "path")
            chosen = np.flatnonzero(here)
            if chosen.size:
                label = f"{direction}, order {order:g}, {element}"
                x, y = runs.cpu[chosen], error[chosen]
                draw_curve(axes, x, y, label, style, line=" ", hollow=hollow)
    _draw_front(axes, runs.cpu, error)
    _draw_default(axes, runs, error)


def _draw_front(axes: Axes, cost: xr.DataArray, error: xr.DataArray) -> None:
    front = pareto_front(cost, error)
    line = {"color": BLACK, "lw": 0.9, "drawstyle": "steps-post", "zorder": 1}
    axes.plot(cost[front], error[front], label="best for its price", **line)


def _draw_default(axes: Axes, runs: xr.Dataset, error: xr.DataArray) -> None:
    (here,) = np.flatnonzero(runs.part == "default")
    mark = {"color": BLACK, "ms": 13.0, "mfc": "yellow", "zorder": 5}
    axes.plot(runs.cpu[here], error[here], "*", label="the defaults of cfmpm", **mark)


def draw_grading(data: str | Path, picture: str | Path) -> None:
    """Draw the effect of grading and domain radius on error and CPU time."""
    dataset = xr.load_dataset(data)
    with panels(Path(picture), (12.0, 7.6), 2, 3) as axes:
        for row, (problem, quantity) in zip(
            axes, (("edge crack", "G"), ("shear plate", "K_I")), strict=True
        ):
            runs = dataset.isel(run=np.flatnonzero(dataset.problem == problem))
            (default,) = np.flatnonzero(runs.part == "default")
            graded = (runs.part == "grading") & (runs.element == runs.element[default])
            size = _nearest(runs["size"][graded], runs["size"][default])
            graded &= runs["size"] == size
            for k, growth in enumerate(np.unique(runs.growth[graded])):
                chosen = np.flatnonzero(graded & (runs.growth == growth))
                x = runs.tip_size[chosen] / size
                label = f"growth {growth:g}"
                draw_curve(row[0], x, runs.error.sel(quantity=quantity)[chosen], label, k)
                draw_curve(row[1], x, runs.cpu[chosen], label, k)
            at = float(runs.tip_size[default] / runs["size"][default])
            error = runs.error.sel(quantity=quantity)
            for one, value in ((row[0], error[default]), (row[1], runs.cpu[default])):
                one.plot(at, value, "*", color=BLACK, ms=13, mfc="yellow", label="default")
                one.set_xlabel("element size at the tip / away from it [1]")
            row[0].set_title(f"{problem}, T6, size {size:g} mm")
            row[0].set_ylabel(f"relative error of {quantity} [1]")
            row[1].set_ylabel(CPU)
            series = runs.series[runs.part == "radius"].values
            for k, name in enumerate(dict.fromkeys(series)):
                chosen = np.flatnonzero((runs.part == "radius") & (runs.series == name))
                draw_curve(row[2], runs.radius[chosen], error[chosen], f"{name}, finest", k)
            row[2].set_xlabel("domain radius [mm]")
            row[2].set_ylabel(f"relative error of {quantity} [1]")
            for one in row:
                one.set_xscale("log")
                one.set_yscale("log")
                one.legend(fontsize=7)


def _nearest(values: xr.DataArray, wanted: xr.DataArray) -> float:
    found = np.unique(values)
    return float(found[np.argmin(np.abs(np.log(found / float(wanted))))])


def draw_solvers(data: str | Path, picture: str | Path) -> None:
    """Draw the wall time of assembly, solution and stress of all solvers on the same grids."""
    dataset = xr.load_dataset(data)
    compared = (dataset.part == "solvers") & (dataset.problem == dataset.problem[0])
    runs = dataset.isel(run=np.flatnonzero(compared))
    seconds = runs.seconds.sel(phase="solve")
    with panels(Path(picture), (10.0, 4.4), 1, 2) as axes:
        for one, element in zip(axes.flat, ("T3", "T6"), strict=True):
            pairs = dict.fromkeys(zip(runs.program.values, runs.solver.values, strict=True))
            for k, (program, solver) in enumerate(pairs):
                here = (runs.program == program) & (runs.solver == solver)
                chosen = np.flatnonzero(here & (runs.element == element) & np.isnan(runs.growth))
                chosen = chosen[np.argsort(runs.n_unknowns[chosen].values)]
                line = "--" if program == "scikit-fem" else "-"
                label = f"{program}, {solver}"
                draw_curve(one, runs.n_unknowns[chosen], seconds[chosen], label, k, line=line)
            one.set_title(f"{element}, uniform grids")
            one.set_xlabel("unknowns [1]")
            one.set_ylabel("wall time of assembly, solution and stress [s]")
            one.set_xscale("log")
            one.set_yscale("log")
            one.legend(fontsize=7)


def draw_scaling(data: str | Path, picture: str | Path) -> None:
    """Draw the wall time of each phase, and the memory, against the number of points.

    Parameters
    ----------
    data : Path
        From `scaling.measure`.
    picture : Path
    """
    dataset = xr.load_dataset(data)
    alone = dataset.isel(threads=0)
    with panels(Path(picture), (11.0, 8.0), 2, dataset.sizes["element"]) as axes:
        for (times, memory), element in zip(axes.T, dataset.element.values, strict=True):
            one = alone.sel(element=element)
            for k, phase in enumerate(one.phase.values):
                label = f"{phase} ~ n^{float(one.exponent.sel(phase=phase)):.2f}"
                draw_curve(times, one.n_points, one.wall_time.sel(phase=phase), label, k)
            for k, threads in enumerate(dataset.threads.values):
                runs = dataset.sel(element=element, threads=threads)
                total = runs.wall_time.sum("phase", min_count=1)
                label = f"all, {threads} thread{'s' if threads > 1 else ''}"
                draw_curve(times, one.n_points, total, label, -1, line="-:"[k] if k < 2 else "--")
                draw_curve(memory, one.n_points, runs.memory / 1e3, label, k)
            ends = float(one.n_points.min()), float(one.n_points.max())
            first = float(one.wall_time.sum("phase", min_count=1).isel(rank=0))
            draw_power(times, ends, 2.0 * first, 1.0, "n")
            times.set_title(f"{element}: phases, exponents fitted from 10 000 points")
            times.set_ylabel("wall time [s]")
            memory.set_ylabel("peak memory of the process [GB]")
            for panel in (times, memory):
                panel.set_xscale("log")
                panel.set_yscale("log")
                panel.set_xlabel("material points [1]")
                panel.legend(fontsize=7)
