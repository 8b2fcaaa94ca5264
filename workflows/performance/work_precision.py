"""Error against run time: stationary cracks, by cfmpm and scikit-fem, and paths of growing cracks.

All runs are members of parameter studies, solved one after the other in one warm process.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial, reduce
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline
from shapely import LineString, distance, points

from cfmpm.body.grid import Floats
from cfmpm.linear.solvers import available
from cfmpm.meshing.sizes import mesh_size, resolved_grading
from cfmpm.output.files import write_dataset
from cfmpm.output.provenance import provenance
from cfmpm.scene import Scene, load_scene
from cfmpm.study.reading import Plan, study_from_dict
from workflows.performance.timed_run import PHASES
from workflows.reference.path_points import reference as path_points
from workflows.study.solved import solved, without_failures

QUANTITIES = ("G", "J", "K_I", "K_II")
# What a run is part of; all else that is told of it before it is run are values on axes.
OF_RUNS = ("problem", "part", "series")
# Leave to the program what grid and domains, and how a crack grows.
DEFAULT: dict[str, Any] = {"mesh": {}, "fracture": {}}
DEFAULT_GROWTH = DEFAULT | {"growth": {}}

Row = dict[str, Any]
Axes = Mapping[str, Sequence[Any]]
# From a member of a study, its scene and what is known of it, to what is told of it.
Told = Callable[[Scene, xr.Dataset], list[Row]]


@dataclass(frozen=True)
class Sweep:
    """A study of runs of one problem.

    Attributes
    ----------
    about : mapping
        What the runs are part of.
    keys : list of str
        Of the scene, whose values are told of each run by their last words.
    plan : Plan
    told : callable
        From the scene and the values of a member to the rows of the dataset.
    """

    about: Row
    keys: list[str]
    plan: Plan
    told: Told

    def rows(self, dataset: xr.Dataset) -> Iterator[Row]:
        """What the study has found, a run each."""
        for member in self.plan.members:
            place = zip(self.plan.axes, member.index, strict=True)
            one = dataset.isel({axis.name: i for axis, i in place})
            values = {key.split(".")[-1]: _at(member.scene, key) for key in self.keys}
            for row in self.told(member.scene, one):
                yield self.about | values | _settled(member.scene) | row


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
    sweeps: list[Sweep] = []  # all scenes are read before the first runs
    for name, problem in stationary.items():
        sweeps += _stationary({"problem": name}, repeats, **problem)
    for name, problem in paths.items():
        sweeps += _paths({"problem": name}, repeats, **problem)
    datasets = solved([sweep.plan for sweep in sweeps])
    rows: list[Row] = []
    for sweep, dataset in zip(sweeps, datasets, strict=True):
        rows += sweep.rows(without_failures(dataset))
    told = provenance(load_scene(next(iter(stationary.values()))["scene"]))
    attributes = {key: told[key] for key in ("Conventions", "source", "references", "versions")}
    attributes["title"] = "Error against run time"
    keys = dict.fromkeys(key.split(".")[-1] for sweep in sweeps for key in sweep.keys)
    attributes["axes"] = " ".join(["formulation", *keys])
    grown = (key for problem in paths.values() for one in problem["axes"] for key in one)
    ways = dict.fromkeys(key.split(".")[-1] for key in grown if key.startswith("growth."))
    attributes["ways"] = " ".join(ways)
    write_dataset(_dataset(rows).assign_attrs(attributes), Path(path))


def _stationary(
    about: Row,
    repeats: int,
    scene: str,
    exact: Mapping[str, float],
    solvers: Sequence[str],
    solved: Mapping[str, Axes],
    axes: Sequence[Axes],
    radii: Sequence[float],
    replaced: Mapping[str, Any],
) -> Iterator[Sweep]:
    """The runs of a stationary crack, and what each is part of."""
    keys = _beside_the_grid([*solved.values(), *axes])
    study = partial(_study, scene, repeats)
    at_rest = partial(_at_rest, exact=exact)
    largest = {**replaced, "fracture": {}}
    small = load_scene(scene, dict(replaced)).kinematics != "finite"
    for series, grids in solved.items():
        part = about | {"part": "solvers", "series": series}
        installed = {"solver": [one for one in solvers if available(one)]}
        yield Sweep(part, keys, study(largest, {**grids, **installed}), at_rest)
        if small:
            plan = study({**largest, "solver": "superlu"}, grids, "phases_and_fem")
            yield Sweep(part, keys, plan, partial(_by_fem, exact=exact))
        finest = {key: values[-1:] for key, values in grids.items()}
        plan = study({**replaced, "fracture.radii": list(radii)}, finest)
        yield Sweep(about | {"part": "radius", "series": series}, keys, plan, at_rest)
    for one in axes:
        yield Sweep(about | {"part": "grading"}, keys, study(largest, one), at_rest)
    yield Sweep(about | {"part": "default"}, keys, study({**replaced, **DEFAULT}, {}), at_rest)


def _paths(
    about: Row,
    repeats: int,
    scene: str,
    reference: str,
    axes: Sequence[Axes],
    replaced: Mapping[str, Any],
    tip: str | None,
    release: str | None,
) -> Iterator[Sweep]:
    """The runs of a growing crack."""
    keys = _beside_the_grid(axes)
    study = partial(_study, scene, repeats)
    grown = partial(
        _grown,
        known=path_points(reference),
        tip=tip,
        release=None if release is None else path_points(release),
    )
    for one in axes:
        yield Sweep(about | {"part": "path"}, keys, study(replaced, one), grown)
    plan = study({**replaced, **DEFAULT_GROWTH}, {})
    yield Sweep(about | {"part": "default"}, keys, plan, grown)


def _study(
    scene: str, repeats: int, replaced: Mapping[str, Any], axes: Axes, measure: str = "phases"
) -> Plan:
    """The study of all combinations on some axes; of the scene as it is where there are none."""
    product: dict[str, Any] = {
        f"axis_{i}": {"key": key, "values": list(values)}
        for i, (key, values) in enumerate(axes.items())
    }
    return study_from_dict(
        {
            "name": "runs",
            "base": str(Path(scene).absolute()),
            "replace": {key: value for key, value in replaced.items() if key not in axes},
            "product": product or {"scene": {"variants": {"as_is": {}}}},
            "measure": f"workflows.performance.timed_run:{measure}",
            "repeats": repeats,
        }
    )


def _beside_the_grid(axes: Iterable[Axes]) -> list[str]:
    """The keys on which a problem has axes, but for those that `_settled` tells in its words."""
    keys = dict.fromkeys(key for one in axes for key in one)
    return [key for key in keys if key.split(".")[0] not in ("mesh", "formulation", "updated")]


def _at(scene: Scene, key: str) -> Any:
    """The value of a key."""
    return reduce(getattr, key.split("."), scene)


def _settled(scene: Scene) -> Row:
    """Formulation, and the numbers of the grid [mm], which a default leaves to the program."""
    grading = resolved_grading(scene)
    size = mesh_size(scene)
    formulation, how = scene.formulation, scene.updated
    if formulation == "updated":
        formulation = f"{formulation}, {how.grid} grid, by {how.integration}"
    return {
        "formulation": formulation,
        "element": scene.mesh.element,
        "size": size,
        "tip_size": grading.tip_size if grading else size,
        "growth": grading.growth if grading else np.nan,
    }


def _steps(one: xr.Dataset) -> xr.Dataset:
    """The steps that a member has, along step."""
    if "step" not in one.dims:
        return one.expand_dims("step")
    return one.isel(step=np.flatnonzero(one.load_factor.notnull()))


def _timed(one: xr.Dataset, n_unknowns: float) -> Row:
    """Values of every run by cfmpm."""
    return {
        "cpu": float(one.cpu_time),
        "seconds": one.seconds.values,
        "n_unknowns": int(n_unknowns),
        "program": "cfmpm",
        "solver": str(one.solver.item()),
    }


def _at_rest(scene: Scene, one: xr.Dataset, exact: Mapping[str, float]) -> list[Row]:
    """A stationary crack at each domain radius that was asked for; else at the largest alone."""
    last = _steps(one).isel(step=-1, tip=0)
    chosen = [-1] if isinstance(scene.fracture.radii, int) else range(last.sizes["radius"])
    # A state before the full load is not a result.
    names = QUANTITIES if last.load_factor >= 1.0 else ()
    rows = []
    for i in chosen:
        found = {name: float(last[f"{name}_radius"][i]) for name in names}
        told = {"error": _errors(found, exact), "radius": float(last.domain_radius[i])}
        rows.append(_timed(one, last.n_unknowns) | told)
    return rows


def _by_fem(scene: Scene, one: xr.Dataset, exact: Mapping[str, float]) -> list[Row]:
    """The same grid by scikit-fem."""
    radius = float(_steps(one).domain_radius.isel(step=-1, tip=0, radius=-1))
    rows = []
    for solver in one.fem_solver.values:
        fem = one.sel(fem_solver=solver)
        found = {name: float(fem[f"fem_{name}"]) for name in QUANTITIES}
        rows.append(
            {
                "cpu": float(fem.fem_cpu),
                "seconds": fem.fem_seconds.values,
                "n_unknowns": int(fem.fem_n_unknowns),
                "program": "scikit-fem",
                "solver": str(solver),
                "error": _errors(found, exact),
                "radius": radius,
            }
        )
    return rows


def _errors(found: Mapping[str, float], exact: Mapping[str, float]) -> list[float]:
    """Relative errors of `QUANTITIES`, nan where unknown; J is compared with G."""
    known = {**exact, "J": exact["G"]}
    return [
        abs(found[q] / known[q] - 1.0) if q in found and q in known else np.nan for q in QUANTITIES
    ]


def _grown(
    scene: Scene, one: xr.Dataset, *, known: Floats, tip: str | None, release: Floats | None
) -> list[Row]:
    """A path, how far it is from known points of it, and how far off G is along it."""
    steps = _steps(one)
    of_tip = steps.isel(tip=0) if tip is None else steps.sel(tip=tip)
    path = LineString(np.column_stack([of_tip.tip_x, of_tip.tip_y]))
    row = _timed(one, steps.n_unknowns[0])
    row["distance"] = float(distance(path, points(known)).max())
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
