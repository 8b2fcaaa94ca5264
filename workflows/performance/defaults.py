"""The page that says which defaults follow from error against run time."""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from workflows.page import html_image, html_page, html_table, write_text
from workflows.performance.pareto import pareto_front

# Of equal price is what takes up to a tenth more time; better is what makes half the error.
SAME_PRICE, BETTER = 1.1, 0.5
KNOWN = ("G", "K_I", "K_II")


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
        "<p>Each default against all that was measured: the least error for at most its CPU time "
        f"(and a tenth), and the least time for at most its error. Another one is called better "
        f"if for that price it makes less than {BETTER:g} of the error.</p>\n",
        html_table(*_against_the_best(dataset)),
        "<h2>Element, grading, formulation, growth</h2>\n<p>The least error that is to be had with "
        "each value for at most the CPU time of the default (and a tenth), whatever else is chosen "
        "with it; in brackets how many of its runs, whatever they cost, came to their load. From "
        "the lines that say <q>best</q> the default follows. Where it <q>stays</q>, another makes "
        "less, but more than half of the error: these curves do not decide. Direction and order "
        "of growth are such, and chosen for paths that pass by holes or run straight. The grids "
        "of the path are of one size everywhere or refined as the tip runs; the default alone is "
        "graded from the start.</p>\n",
        html_table(*_values_of_axes(dataset)),
        "<h2>Solver and domain radius</h2>\n<p>The default solver follows from the times on the "
        "largest grid of each kind: the one that is chosen against the fastest. The radius follows "
        "from the errors there: at the one that is chosen against the least at any.</p>\n",
        html_table(*_solver_and_radius(stationary)),
        "<h2>Numbers of the grading</h2>\n<p>Of all gradings those that no other one beats, "
        "over the problems of small strain together, which scikit-fem solves too: CPU time by the "
        "geometric mean, error by the worst quantity of the worst problem, both relative to the "
        "default's, which is as good as any where no line has less of both. A tip finer than the "
        "default's, a hundredth of the size, is the better choice for small strain "
        "(<code>mesh.grading.tip_size</code>). It is not the default, as the same grids serve "
        "finite deformation, where finer tips take more steps, and Hencky's law loses its "
        "stability the sooner (Fig. 8).</p>\n",
        html_table(*_gradings(_of(stationary, "scikit-fem"))),
        *(
            f"<h2>{html.escape(caption)}</h2>\n{html_image(picture, caption)}\n"
            for caption, picture in pictures.items()
        ),
    ]
    write_text(html_page("Defaults by error against run time", "".join(parts)), page)


def _of(dataset: xr.Dataset, program: str) -> xr.Dataset:
    """The problems that a program has solved."""
    solved = dataset.problem[dataset.program == program]
    return dataset.isel(run=np.flatnonzero(dataset.problem.isin(solved)))


def worst_error(runs: xr.Dataset) -> xr.DataArray:
    """The largest error of the quantities known, or the distance of a path, (run,)."""
    return runs.error.sel(quantity=list(KNOWN)).max("quantity").fillna(runs.distance)


def _problems(dataset: xr.Dataset) -> Iterator[tuple[str, xr.Dataset, int]]:
    """The runs of each problem by cfmpm at the radius that it chooses, and which is the default."""
    for problem in dict.fromkeys(dataset.problem.values):
        here = (dataset.problem == problem) & (dataset.program == "cfmpm")
        runs = dataset.isel(run=np.flatnonzero(here & (dataset.part != "radius")))
        (default,) = np.flatnonzero(runs.part == "default")
        yield str(problem), runs, int(default)


def _against_the_best(dataset: xr.Dataset) -> tuple[list[str], list[list[str]], list[str]]:
    """A line for each problem: its default, what is better for that price, what is cheaper."""
    head = ["problem", "error of", "default", "best for its price", "cheapest as good", "verdict"]
    rows, classes = [], []
    for problem, runs, default in _problems(dataset):
        error, cost = worst_error(runs).values, runs.cpu.values
        affordable = np.flatnonzero(cost <= SAME_PRICE * cost[default])
        best = affordable[np.nanargmin(error[affordable])]
        as_good = np.flatnonzero(error <= error[default])
        cheapest = as_good[np.argmin(cost[as_good])]
        beaten = error[best] < BETTER * error[default]
        of = "the path [mm]" if np.isfinite(runs.distance[default]) else "the worst of G, K_I, K_II"
        cells = [_told(runs.isel(run=i), error[i]) for i in (default, best, cheapest)]
        rows.append([problem, of, *cells, "another is better" if beaten else "stays"])
        classes.append("no" if beaten else "yes")
    return head, rows, classes


def _values_of_axes(dataset: xr.Dataset) -> tuple[list[str], list[list[str]], list[str]]:
    """A line for each axis of each problem: the least error by each value for the same price."""
    head = ["axis", "problem", "default", "others", "verdict"]
    rows, classes = [], []
    grading = np.where(np.isnan(dataset.growth), "uniform", "graded")
    dataset = dataset.assign_coords(grading=("run", grading))
    for axis in ("element", "grading", *dataset.attrs["axes"].split()):
        for problem, runs, default in _problems(dataset):
            error, values = worst_error(runs).values, runs[axis].values
            chosen = values[default]
            others = [value for value in dict.fromkeys(values) if value not in (chosen, "")]
            if chosen != chosen or not others:  # left to the program, or no axis of this problem
                continue
            cheap = runs.cpu.values <= SAME_PRICE * runs.cpu.values[default]
            least, told = [], []
            for value in (chosen, *others):
                here = values == value
                found = error[here & cheap & np.isfinite(error)]
                least.append(found.min(initial=np.inf))
                price = f"{least[-1]:.1e}" if found.size else "none for this price"
                came = f"{np.isfinite(error[here]).sum()} of {here.sum()}"
                told.append(f"{value}: {price} ({came})")
            verdict, mark = "best", "yes"
            if least[0] > min(least[1:]):
                stays = BETTER * least[0] <= min(least[1:])
                verdict, mark = ("stays", "in-part") if stays else ("another is better", "no")
            rows.append([axis, problem, told[0], "; ".join(told[1:]), verdict])
            classes.append(mark)
    return head, rows, classes


def _told(run: xr.Dataset, error: float) -> str:
    """The numbers of a run in words."""
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
        error = worst_error(runs).values
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
                "stays" if stays else "another is better",
            ]
        )
        classes.append("yes" if stays else "no")
    return head, rows, classes


def _gradings(dataset: xr.Dataset) -> tuple[list[str], list[list[str]]]:
    """The gradings that no other beats, relative to the default's."""
    ratios: dict[tuple[str, float, float, float], list[tuple[float, float]]] = {}
    problems = dict.fromkeys(dataset.problem.values)
    for problem in problems:
        runs = dataset.isel(run=np.flatnonzero(dataset.problem == problem))
        error = worst_error(runs).values
        (default,) = np.flatnonzero(runs.part == "default")
        for i in np.flatnonzero(np.isin(runs.part, ("grading", "default"))):
            size = float(runs["size"][i])
            # Sizes of the problems are parts of their bodies, up to rounding.
            key = (
                str(runs.element[i].item()),
                round(size / float(runs["size"][default]), 1),
                float(f"{float(runs.tip_size[i]) / size:.1g}"),
                float(runs.growth[i]),
            )
            ratio = float(runs.cpu[i] / runs.cpu[default]), float(error[i] / error[default])
            ratios.setdefault(key, []).append(ratio)
    common = [key for key, found in ratios.items() if len(found) >= len(problems)]
    cost = [np.exp(np.mean([np.log(c) for c, _ in ratios[key]])) for key in common]
    error = [max(e for _, e in ratios[key]) for key in common]
    head = ["element", "size / default's", "tip size / size", "growth", "CPU time", "error"]
    rows: Sequence[list[str]] = [
        [*(f"{value}" for value in common[i]), f"{cost[i]:.2f}", f"{error[i]:.3f}"]
        for i in pareto_front(cost, error)
    ]
    return head, list(rows)
