"""The page that says which defaults follow from error against run time."""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from cfmpm.body.grid import Floats
from workflows.performance.pareto import pareto_front
from workflows.reporting.html_page import html_image, html_page, html_table, write_text

# Equal cost is up to a tenth more time; better is less than half the error.
SAME_PRICE, BETTER = 1.1, 0.5
KNOWN = ("G", "K_I", "K_II")
GRID = ("element", "size", "tip_size", "growth", "refine")
PATH = "the path [mm]"
Way = tuple[str, ...]


def write_defaults(data: str | Path, pictures: Mapping[str, str | Path], page: str | Path) -> None:
    """Write the page.

    Parameters
    ----------
    data : Path
        From `work_precision.measure`.
    pictures : mapping of str to Path
        By caption; they go into the page.
    page : Path
    """
    dataset = xr.load_dataset(data)
    stationary = dataset.isel(run=np.flatnonzero(np.isnan(dataset.distance)))
    parts = [
        "<p>Each default is compared with all other runs: the smallest error for at most its CPU "
        f"time (plus a tenth), and the smallest CPU time for at most its error. Another choice is "
        f"better if it has less than {BETTER:g} of the error for at most this CPU time; otherwise "
        "the default <q>stays</q>. There is one default for all problems: a choice that is better "
        "for one of them is compared below over all.</p>\n",
        html_table(*_against_the_best(dataset)),
        "<h2>Numbers of the grading</h2>\n<p>The Pareto-optimal gradings, "
        "over all problems with a stationary crack, small strain and finite: CPU time by the "
        "geometric mean, error by the worst quantity of the worst problem, both relative to the "
        "default's.</p>\n",
        html_table(*_gradings(stationary)),
        "<h2>Element, grading, formulation</h2>\n<p>The smallest error with each value for at most "
        "the CPU time of the default (plus a tenth), for any choice of the others except the "
        "settings of growth; in brackets the number of its runs, of any cost, that reached their "
        "load. Uniform grids of the paths are with or without refinement around the tip.</p>\n",
        html_table(*_values_of_axes(dataset)),
        "<h2>Settings of growth</h2>\n<p>On a single grid the error of a path is partly random. "
        "Direction and order are therefore compared with the default on every grid that was run "
        "with all of them: error of the path relative to that of the default, as the geometric "
        "mean over the grids of a problem and over all problems. In brackets the smallest and the "
        "largest on one grid.</p>\n",
        html_table(*_ways(dataset)),
        "<h2>Solver and domain radius</h2>\n<p>The default solver follows from the times on the "
        "largest grid of each kind: the default is compared with the fastest. The radius follows "
        "from the errors there: that of the default is compared with the smallest.</p>\n",
        html_table(*_solver_and_radius(stationary)),
        *(
            f"<h2>{html.escape(caption)}</h2>\n{html_image(picture, caption)}\n"
            for caption, picture in pictures.items()
        ),
    ]
    write_text(html_page("Defaults by error against run time", "".join(parts)), page)


def worst_error(runs: xr.Dataset) -> Floats:
    """The largest error of the quantities known, (run,)."""
    return runs.error.sel(quantity=list(KNOWN)).max("quantity").values


@dataclass(frozen=True)
class Measured:
    """The runs of a problem by cfmpm at the radius that it chooses."""

    problem: str
    of: str  # what the error is of
    runs: xr.Dataset
    error: Floats
    default: int  # which run


def _measured(dataset: xr.Dataset) -> Iterator[Measured]:
    """All problems; one with a path has its errors apart from those of the values along it."""
    for problem in dict.fromkeys(dataset.problem.values):
        here = (dataset.problem == problem) & (dataset.program == "cfmpm")
        runs = dataset.isel(run=np.flatnonzero(here & (dataset.part != "radius")))
        (default,) = (int(i) for i in np.flatnonzero(runs.part == "default"))
        along = ""
        if np.isfinite(runs.distance[default]):
            along = " along the path"
            yield Measured(str(problem), PATH, runs, runs.distance.values, default)
        error = worst_error(runs)
        if np.isfinite(error[default]):
            known = [q for q in KNOWN if np.isfinite(runs.error.sel(quantity=q)[default])]
            yield Measured(str(problem), " and ".join(known) + along, runs, error, default)


def _against_the_best(dataset: xr.Dataset) -> tuple[list[str], list[list[str]], list[str]]:
    """A line for each problem: its default, what is better for that price, what is cheaper."""
    head = ["problem", "error of", "default", "best for its price", "cheapest as good", "verdict"]
    rows, classes = [], []
    for one in _measured(dataset):
        error, cost, default = one.error, one.runs.cpu.values, one.default
        affordable = np.flatnonzero(cost <= SAME_PRICE * cost[default])
        best = affordable[np.nanargmin(error[affordable])]
        as_good = np.flatnonzero(error <= error[default])
        cheapest = as_good[np.argmin(cost[as_good])]
        beaten = error[best] < BETTER * error[default]
        cells = [_told(one.runs.isel(run=i), error[i]) for i in (default, best, cheapest)]
        rows.append([one.problem, one.of, *cells, _verdict(not beaten)])
        classes.append("no" if beaten else "yes")
    return head, rows, classes


def _verdict(stays: bool) -> str:
    return "stays" if stays else "another is better"


def _values_of_axes(dataset: xr.Dataset) -> tuple[list[str], list[list[str]], list[str]]:
    """A line for each axis of each problem: the least error by each value for the same price."""
    head = ["axis", "problem", "error of", "default", "others", "verdict"]
    rows, classes = [], []
    ways = dataset.attrs["ways"].split()
    axes = [axis for axis in dataset.attrs["axes"].split() if axis not in ways]
    grading = np.where(np.isnan(dataset.growth), "uniform", "graded")
    dataset = dataset.assign_coords(grading=("run", grading))
    for axis in ("element", "grading", *axes):
        for one in _measured(dataset):
            runs, error, default = one.runs, one.error, one.default
            values = runs[axis].values
            chosen = values[default]
            others = [value for value in dict.fromkeys(values) if value not in (chosen, "")]
            if chosen != chosen or not others:  # left to the program, or no axis of this problem
                continue
            compared = runs.cpu.values <= SAME_PRICE * runs.cpu.values[default]
            for way in ways:
                words = runs[way].values.astype(str)
                compared &= words == words[default]
            least, told = [], []
            for value in (chosen, *others):
                here = values == value
                found = error[here & compared & np.isfinite(error)]
                least.append(found.min(initial=np.inf))
                price = f"{least[-1]:.1e}" if found.size else "none for this price"
                came = f"{np.isfinite(error[here]).sum()} of {here.sum()}"
                told.append(f"{value}: {price} ({came})")
            verdict, mark = "best", "yes"
            if least[0] > min(least[1:]):
                stays = BETTER * least[0] <= min(least[1:])
                verdict, mark = _verdict(stays), "in-part" if stays else "no"
            rows.append([axis, one.problem, one.of, told[0], "; ".join(told[1:]), verdict])
            classes.append(mark)
    return head, rows, classes


def _ways(dataset: xr.Dataset) -> tuple[list[str], list[list[str]], list[str]]:
    """A line for each way to grow: its error on the same grids relative to the default's."""
    names = dataset.attrs["ways"].split()
    ratios: dict[Way, dict[str, Floats]] = {}
    for one in _measured(dataset):
        if one.of != PATH:
            continue
        paths = np.flatnonzero(one.runs.part == "path")
        keys = [
            tuple(str(one.runs[name].values[i]) for name in names) for i in range(len(one.error))
        ]
        chosen = keys[one.default]
        by_grid: dict[Way, dict[Way, float]] = {}
        for i in paths:
            grid = tuple(str(one.runs[name].values[i]) for name in GRID)
            by_grid.setdefault(grid, {})[keys[i]] = one.error[i]
        ways = dict.fromkeys(keys[i] for i in paths)
        whole = [errors for errors in by_grid.values() if errors.keys() >= {chosen, *ways}]
        if not whole:
            continue
        for way in ways:
            found = np.array([errors[way] / errors[chosen] for errors in whole])
            ratios.setdefault(way, {})[one.problem] = found
    problems = list(dict.fromkeys(problem for of in ratios.values() for problem in of))
    rows, classes = [], []
    for way, of in ratios.items():
        means = {problem: float(np.exp(np.log(found).mean())) for problem, found in of.items()}
        cells = [
            f"{means[problem]:.2f} ({of[problem].min():.2f} to {of[problem].max():.2f}, "
            f"{of[problem].size} grids)"
            if problem in of
            else ""
            for problem in problems
        ]
        mean = float(np.exp(np.mean(np.log(list(means.values())))))
        told = "the default" if way == chosen else _verdict(mean >= BETTER)
        rows.append([*way, *cells, f"{mean:.2f}", f"{max(means.values()):.2f}", told])
        classes.append("yes" if mean >= BETTER else "no")
    return [*names, *problems, "all", "worst problem", "verdict"], rows, classes


def _told(run: xr.Dataset, error: float) -> str:
    """Description of a run."""
    words = [str(run.element.item()), f"size {float(run['size']):.3g}"]
    if np.isfinite(run.growth):
        words.append(f"tip {float(run.tip_size):.2g}, growth {float(run.growth):g}")
    else:
        words.append("uniform")
    for name in run.attrs["axes"].split():
        value = run[name].item()
        if value != "" and value == value:
            words.append(f"{name} {value:g}" if isinstance(value, float) else f"{name} {value}")
    return f"{', '.join(words)}: {error:.1e} in {float(run.cpu):.3f} s"


def _solver_and_radius(dataset: xr.Dataset) -> tuple[list[str], list[list[str]], list[str]]:
    """A line for each kind of grid of each problem."""
    head = ["problem", "grids", "solver chosen", "fastest", "radius chosen", "best", "verdict"]
    rows, classes = [], []
    compared = dataset.isel(run=np.flatnonzero(np.isin(dataset.part, ("solvers", "radius"))))
    kinds = zip(compared.problem.values, compared.series.values, strict=True)
    for problem, series in dict.fromkeys(kinds):
        here = (compared.problem == problem) & (compared.series == series)
        runs = compared.isel(run=np.flatnonzero(here & (compared.program == "cfmpm")))
        radii = np.flatnonzero(runs.part == "radius")
        finest = runs.n_unknowns == runs.n_unknowns[radii[0]]
        solved = np.flatnonzero((runs.part == "solvers") & finest)
        solver = str(runs.solver[radii[0]].item())
        (chosen,) = solved[(runs.solver[solved] == solver).values]
        fastest = solved[np.argmin(runs.cpu.values[solved])]
        error = worst_error(runs)
        best = radii[np.argmin(error[radii])]
        stays = (
            runs.cpu[chosen] <= SAME_PRICE * runs.cpu[fastest]
            and BETTER * error[chosen] <= error[best]
        )
        rows.append(
            [
                *(str(problem), str(series)),
                *(
                    f"{runs.solver[i].item()}: {float(runs.cpu[i]):.3f} s"
                    for i in (chosen, fastest)
                ),
                *(f"{float(runs.radius[i]):.3g} mm: {error[i]:.1e}" for i in (chosen, best)),
                _verdict(stays),
            ]
        )
        classes.append("yes" if stays else "no")
    return head, rows, classes


def _gradings(dataset: xr.Dataset) -> tuple[list[str], list[list[str]], list[str]]:
    """The Pareto-optimal gradings, relative to the default's."""
    ratios: dict[tuple[str, float, float, float], dict[str, tuple[float, float]]] = {}
    problems = list(_measured(dataset))
    for one in problems:
        runs, default = one.runs, one.default
        here = np.isin(runs.part, ("grading", "default")) & np.isfinite(runs.growth.values)
        for name in dataset.attrs["axes"].split():  # of everything else what the default has
            values = runs[name].values.astype(str)
            here &= values == values[default]
        for i in (*np.flatnonzero(here), default):
            size = float(runs["size"][i])
            # Sizes of the problems are parts of their bodies, up to rounding.
            key = (
                str(runs.element[i].item()),
                round(size / float(runs["size"][default]), 1),
                float(f"{float(runs.tip_size[i]) / size:.1g}"),
                float(runs.growth[i]),
            )
            ratio = float(runs.cpu[i] / runs.cpu[default]), one.error[i] / one.error[default]
            ratios.setdefault(key, {})[one.problem] = ratio
    chosen = key
    common = [key for key, found in ratios.items() if len(found) == len(problems)]
    cost = [np.exp(np.mean([np.log(c) for c, _ in ratios[key].values()])) for key in common]
    error = [max(e for _, e in ratios[key].values()) for key in common]
    shown = {*pareto_front(cost, error), common.index(chosen)}
    head = ["element", "size / default's", "tip size / size", "growth", "CPU time", "error", ""]
    rows, classes = [], []
    for i in sorted(shown, key=lambda i: cost[i]):
        better = cost[i] <= SAME_PRICE and error[i] < BETTER
        told = "the default" if common[i] == chosen else "better" if better else ""
        numbers = [f"{value}" for value in common[i]]
        rows.append([*numbers, f"{cost[i]:.2f}", f"{error[i]:.3f}", told])
        classes.append("no" if better else "yes")
    return head, rows, classes
