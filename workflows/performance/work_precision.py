"""Error against run time: cracks at rest, by cfmpm and scikit-fem, and paths of growing ones."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial, reduce
from pathlib import Path
from typing import Any

import cfmpm
import numpy as np
import xarray as xr
from cfmpm.body.grid import Floats
from cfmpm.linear.solvers import available, select
from cfmpm.meshing.sizes import mesh_size, resolved_grading
from cfmpm.output.files import write_dataset
from cfmpm.output.provenance import provenance
from cfmpm.scene import Scene, load_scene
from scipy.interpolate import CubicSpline
from scipy.sparse import csr_array
from shapely import LineString, distance, points
from skfem import solver_direct_scipy

from workflows.performance.settings import combinations
from workflows.reference import plate_fem
from workflows.reference.path_points import reference as path_points

QUANTITIES = ("G", "J", "K_I", "K_II")
PHASES = ("mesh", "solve", "post")
# What a run is part of; all else that is told of it before it is run are values on axes.
OF_RUNS = ("problem", "part", "series")
# Leave to the program what grid and domains, and how a crack grows.
DEFAULT: dict[str, Any] = {"mesh": {}, "fracture": {}}
DEFAULT_GROWTH = DEFAULT | {"growth": {}}
log = logging.getLogger(__name__)

Row = dict[str, Any]
Task = Callable[[int], list[Row]]


def measure(
    path: str | Path,
    *,
    repeats: int,
    stationary: Mapping[str, Mapping[str, Any]],
    paths: Mapping[str, Mapping[str, Any]],
) -> None:
    """Measure all problems.

    Parameters
    ----------
    path : Path
        Of the netCDF file; dimension run, with a coordinate for each key of a scene on which a
        problem has an axis, and dimensions quantity and phase. Attributes, parted by blanks:
        ``axes``, the names of the coordinates beside element, grid and solver; ``ways``, those of
        them that are keys of growth.
    repeats : int
        Of which the fastest counts.
    stationary, paths : mapping
        By name, what `settings.StationaryProblem` and `settings.PathProblem` hold.
    """
    tasks: list[tuple[Row, Task]] = []  # all scenes are read before the first runs
    for name, problem in stationary.items():
        tasks += [({"problem": name} | about, task) for about, task in _stationary(**problem)]
    for name, problem in paths.items():
        tasks += [({"problem": name} | about, task) for about, task in _paths(**problem)]
    rows: list[Row] = []
    for about, task in tasks:
        rows += [about | row for row in task(repeats)]
        log.info("%s: %.2f s", about, rows[-1]["cpu"])
    told = provenance(load_scene(next(iter(stationary.values()))["scene"]))
    attributes = {key: told[key] for key in ("Conventions", "source", "references", "versions")}
    attributes["title"] = "Error against run time"
    named = dict.fromkeys(key for about, _ in tasks for key in about)
    attributes["axes"] = " ".join(["formulation", *(key for key in named if key not in OF_RUNS)])
    grown = (key for problem in paths.values() for one in problem["axes"] for key in one)
    ways = dict.fromkeys(key.split(".")[-1] for key in grown if key.startswith("growth."))
    attributes["ways"] = " ".join(ways)
    write_dataset(_dataset(rows).assign_attrs(attributes), Path(path))


def _stationary(
    scene: str,
    exact: Mapping[str, float],
    solvers: Sequence[str],
    solved: Mapping[str, Mapping[str, Any]],
    axes: Sequence[Mapping[str, Any]],
    radii: Sequence[float],
    replaced: Mapping[str, Any],
) -> Iterator[tuple[Row, Task]]:
    """The runs of a stationary crack, and what each is part of."""
    read = partial(_read, scene, _beside_the_grid([*solved.values(), *axes]))
    for series, grids in solved.items():
        for grid in combinations(grids):
            here = {**replaced, **grid}
            told, scenarios = {}, []
            for solver in filter(available, solvers):
                told, scenario = read({**here, "fracture": {}, "solver": solver})
                scenarios.append(scenario)
            about = {"part": "solvers", "series": series, **told}
            yield about, partial(_compare, scenarios, exact)
        told, finest = read({**here, "fracture.radii": list(radii)})
        yield {"part": "radius", "series": series, **told}, partial(_solve, finest, exact)
    for one in axes:
        for values in combinations(one):
            told, scenario = read({**replaced, **values, "fracture": {}})
            yield {"part": "grading", **told}, partial(_solve, scenario, exact)
    told, scenario = read({**replaced, **DEFAULT})
    yield {"part": "default", **told}, partial(_solve, scenario, exact)


def _paths(
    scene: str,
    reference: str,
    axes: Sequence[Mapping[str, Any]],
    replaced: Mapping[str, Any],
    tip: str | None,
    release: str | None,
) -> Iterator[tuple[Row, Task]]:
    """The runs of a growing crack."""
    read = partial(_read, scene, _beside_the_grid(axes))
    known = path_points(reference)
    grow = partial(_grow, known=known, tip=tip, release=release and path_points(release))
    for one in axes:
        for values in combinations(one):
            told, scenario = read({**replaced, **values})
            yield {"part": "path", **told}, partial(grow, scenario)
    told, scenario = read({**replaced, **DEFAULT_GROWTH})
    yield {"part": "default", **told}, partial(grow, scenario)


def _beside_the_grid(axes: Iterable[Mapping[str, Any]]) -> list[str]:
    """The keys on which a problem has axes, but for those that `_settled` tells in its words."""
    keys = dict.fromkeys(key for one in axes for key in one)
    return [key for key in keys if key.split(".")[0] not in ("mesh", "formulation", "updated")]


def _read(scene: str, keys: Sequence[str], replaced: Mapping[str, Any]) -> tuple[Row, Scene]:
    """A scene with values replaced, and what then stands at the keys, by their last words."""
    scenario = load_scene(scene, replaced)
    return {key.split(".")[-1]: reduce(getattr, key.split("."), scenario) for key in keys}, scenario


def _compare(scenarios: Sequence[Scene], exact: Mapping[str, float], repeats: int) -> list[Row]:
    """One grid by all solvers, and by scikit-fem where strain is small."""
    rows = []
    for scenario in scenarios:
        result, found = _run(scenario, exact, repeats)
        rows += found
    if scenario.kinematics == "finite":
        return rows
    mesh = min(row["seconds"][0] for row in rows)
    for solver, solve in _fem_solvers().items():
        row = _solve_by_fem(result, exact, solve, repeats)
        # The grid is taken over as it is: it costs what it costs.
        row["seconds"][0] = mesh
        row["cpu"] += mesh
        rows.append(row | {"program": "scikit-fem", "solver": solver})
    return rows


def _solve(scenario: Scene, exact: Mapping[str, float], repeats: int) -> list[Row]:
    return _run(scenario, exact, repeats)[1]


def _run(
    scenario: Scene, exact: Mapping[str, float], repeats: int
) -> tuple[cfmpm.Result, list[Row]]:
    """Run a scene, and compare each domain radius that was asked for; else the largest alone."""
    cpu, runs = [], []
    for _ in range(repeats):
        start = time.process_time()
        result = cfmpm.run(scenario)
        cpu.append(time.process_time() - start)
        runs.append(_phases(result.history))
    step = result.history.isel(step=-1, tip=0)
    shared = {
        "cpu": min(cpu),
        "seconds": np.min(runs, axis=0),
        "n_unknowns": int(step.n_unknowns),
        "program": "cfmpm",
        "solver": result.history.attrs["solver"],
        **_settled(scenario),
    }
    chosen = [-1] if isinstance(scenario.fracture.radii, int) else range(step.sizes["radius"])
    # A state on the way to the load is no answer.
    names = QUANTITIES if step.load_factor >= 1.0 else ()
    rows = []
    for i in chosen:
        found = {name: float(step[f"{name}_radius"][i]) for name in names}
        radius = float(step.domain_radius[i])
        rows.append(shared | {"error": _errors(found, exact), "radius": radius})
    return result, rows


def _settled(scenario: Scene) -> Row:
    """Formulation, and the numbers of the grid [mm], which a default leaves to the program."""
    grading = resolved_grading(scenario)
    size = mesh_size(scenario)
    formulation, how = scenario.formulation, scenario.updated
    if formulation == "updated":
        formulation = f"{formulation}, {how.grid} grid, by {how.integration}"
    return {
        "formulation": formulation,
        "element": scenario.mesh.element,
        "size": size,
        "tip_size": grading.tip_size if grading else size,
        "growth": grading.growth if grading else np.nan,
    }


def _phases(history: xr.Dataset) -> list[float]:
    """Wall time of a run by `PHASES` [s]."""
    of_phase = history.wall_time.sum("step")
    mesh, post = float(of_phase.sel(phase="grid")), float(of_phase.sel(phase="fracture"))
    return [mesh, float(of_phase.sum()) - mesh - post, post]


def _errors(found: Mapping[str, float], exact: Mapping[str, float]) -> list[float]:
    """Relative errors of `QUANTITIES`, nan where unknown; J is compared with G."""
    known = {**exact, "J": exact["G"]}
    return [
        abs(found[q] / known[q] - 1.0) if q in found and q in known else np.nan for q in QUANTITIES
    ]


def _fem_solvers() -> dict[str, Callable[[Any, Floats], Floats]]:
    """scikit-fem's own choice, and the fastest solver of cfmpm for a fair comparison."""
    found: dict[str, Callable[[Any, Floats], Floats]] = {"its default": solver_direct_scipy()}
    if available("cholmod"):
        found["cholmod"] = lambda K, b: select(len(b), "cholmod").factor(csr_array(K)).solve(b).x
    return found


def _solve_by_fem(
    result: cfmpm.Result,
    exact: Mapping[str, float],
    solve: Callable[[Any, Floats], Floats],
    repeats: int,
) -> Row:
    """Run scikit-fem on the grid of a result."""
    grid, scene = result.grid, result.scene
    tip = grid.nodes[grid.tips[0].node]
    radius = float(result.history.domain_radius[0, 0, -1])
    plate = plate_fem.plate_of(scene, grid)
    cpu, runs = [], []
    for _ in range(repeats):
        begun, start = time.process_time(), time.perf_counter()
        system = plate_fem.assemble(plate, degree=grid.element.order)
        solution = plate_fem.solve(system, solve)
        solved = time.perf_counter()
        found = {"J": plate_fem.j_integral(solution, tip, radius)}
        found["K_I"], found["K_II"] = plate_fem.intensity_factors(solution, tip, radius)
        runs.append([0.0, solved - start, time.perf_counter() - solved])
        cpu.append(time.process_time() - begun)
    found["G"] = plate.release_rate(found["K_I"], found["K_II"])
    return {
        "cpu": min(cpu),
        "seconds": np.min(runs, axis=0),
        "n_unknowns": len(solution.displacement) - len(system.held),
        "error": _errors(found, exact),
        "radius": radius,
        **_settled(scene),
    }


def _grow(
    scenario: Scene,
    repeats: int,
    *,
    known: Floats,
    tip: str | None,
    release: Floats | None,
) -> list[Row]:
    """A path, how far it is from known points of it, and how far off G is along it."""
    cpu, runs = [], []
    for _ in range(repeats):
        start = time.process_time()
        history = cfmpm.run(scenario).history
        cpu.append(time.process_time() - start)
        runs.append(_phases(history))
    of_tip = history.isel(tip=0) if tip is None else history.sel(tip=tip)
    path = LineString(np.column_stack([of_tip.tip_x, of_tip.tip_y]))
    row = {
        "cpu": min(cpu),
        "seconds": np.min(runs, axis=0),
        "n_unknowns": int(history.n_unknowns[0]),
        "program": "cfmpm",
        "solver": history.attrs["solver"],
        "distance": float(distance(path, points(known)).max()),
        **_settled(scenario),
    }
    if release is not None:
        G = CubicSpline(*release.T, extrapolate=False)(of_tip.tip_x)
        row["error"] = [float(np.nanmax(np.abs(of_tip.G / G - 1.0))), *[np.nan] * 3]
    return [row]


def _dataset(rows: Sequence[Row]) -> xr.Dataset:
    """All runs, one after the other."""
    missing = [np.nan] * len(QUANTITIES)
    measured = ("cpu", "seconds", "error", "distance", "n_unknowns")
    named = dict.fromkeys(key for row in rows for key in row if key not in measured)
    return xr.Dataset(
        {
            "cpu": (
                "run",
                _column(rows, "cpu"),
                _said("s", "CPU time of the fastest of some warm runs, from the scene to the end"),
            ),
            "seconds": (
                ("run", "phase"),
                [row["seconds"] for row in rows],
                _said("s", "wall time by phase, the least of some warm runs"),
            ),
            "error": (
                ("run", "quantity"),
                [row.get("error", missing) for row in rows],
                _said("1", "relative error; J is compared with G"),
            ),
            "distance": (
                "run",
                _column(rows, "distance"),
                _said("mm", "largest distance of the points known from the path"),
            ),
            "n_unknowns": (
                "run",
                _column(rows, "n_unknowns"),
                _said("1", "free degrees of freedom, at the start"),
            ),
        },
        {
            "phase": list(PHASES),
            "quantity": list(QUANTITIES),
            **{key: ("run", _column(rows, key)) for key in named},
        },
    )


def _column(rows: Iterable[Row], key: str) -> list[Any]:
    """The values of one key; where a row has none, nan or, among words, an empty word."""
    values = [row.get(key) for row in rows]
    if any(isinstance(value, str) for value in values):
        return ["" if value is None else str(value) for value in values]
    return [np.nan if value is None else float(value) for value in values]


def _said(units: str, long_name: str) -> dict[str, str]:
    return {"units": units, "long_name": long_name}
