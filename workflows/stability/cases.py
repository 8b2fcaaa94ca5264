"""Runs of extreme cases: what happened, and how far from what is known."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from cfmpm.errors import SceneError
from cfmpm.output.files import write_dataset
from cfmpm.scene import Scene, load_scene
from cfmpm.study.layout import STATUS
from cfmpm.study.reading import study_from_dict
from workflows.stability.closed_forms import CLOSED_FORMS
from workflows.stability.settings import Case, Stability
from workflows.stability.slivers import write_plate
from workflows.study.solved import solved

# Overlap of crack faces, in elements at the tip, that counts as none.
TOUCH = 1e-3
# What became of a case, in place of the words of a study.
WORDS = {"done": "solved"}
# Of the study, by the names that cases have for it.
REACHED = {
    "J": "J_reached",
    "load_reached": "load_reached",
    "unstable_points": "unstable_points_reached",
    "newton_iterations": "newton_iterations_reached",
    "substeps": "substeps_reached",
    "residual": "residual",
    "overlap": "overlap",
    "not_known": "not_known",
    "load_factor": "load_path",
    "J_path": "J_path",
    "force": "force",
    "elongation": "elongation",
    "length": "length_path",
    "cycles": "cycles_path",
    "K_I": "K_I_reached",
    "K_II": "K_II_reached",
    "aside": "aside_reached",
}


def write_cases(settings: Mapping[str, Any], workers: int, path: str | Path) -> None:
    """Run all cases, as the variants of one study.

    Parameters
    ----------
    settings : mapping
        The block stability of the workflow's configuration.
    workers : int
        Processes.
    path : Path
        Of the netCDF file: one entry along the dimension case for each, and the paths of load
        along step, nan past their end.
    """
    study = Stability.model_validate(settings)
    cases = {name: case for _, name, case in each(study)}
    with tempfile.TemporaryDirectory() as folder:
        variants = {
            name: _replaced(study.groups[group].replaced, case, name, Path(folder))
            for group, name, case in each(study)
        }
        refused = {
            name: reason
            for name, case in cases.items()
            if case.ends == "refused" and (reason := _refusal(study.scene, variants[name]))
        }
        run = {name: variants[name] for name in cases if name not in refused}
        dataset = _solved(study.scene, run, workers).reindex(case=list(cases))
    for name, reason in refused.items():
        for key, text in (("status", "refused"), ("message", reason), ("warnings", "")):
            dataset[key].loc[{"case": name}] = text
    dataset["not_known"] = dataset.not_known.fillna(0.0)
    dataset["group"] = "case", [group for group, _, _ in each(study)]
    scenes = {name: load_scene(study.scene, variants[name]) for name in cases if cases[name].along}
    write_dataset(_with_references(dataset, cases, scenes), Path(path))


def each(study: Stability) -> Iterator[tuple[str, str, Case]]:
    """Each case with its group and its name, which has that of the group before it."""
    for group, of_group in study.groups.items():
        for name, case in of_group.cases.items():
            yield group, f"{group}/{name}", case


def _replaced(shared: Mapping[str, Any], case: Case, name: str, folder: Path) -> dict[str, Any]:
    """What a case replaces in the scene; its grid of slivers, if it has one, is written."""
    replaced = {**shared, **case.replaced}
    if case.grid is not None:
        mesh = folder / f"{name.replace('/', '_')}.msh"
        write_plate(mesh, case.grid.slivers, case.grid.thinness)
        replaced["family"] = None
        replaced["mesh_file"] = {"file": str(mesh), "cracks": ["crack"]}
        replaced["mesh"] = {"element": case.grid.element}
    return replaced


def _refusal(scene_file: str, replaced: Mapping[str, Any]) -> str:
    """Why a scene is refused; empty where it is not."""
    try:
        load_scene(scene_file, replaced)
    except SceneError as error:
        return str(error)
    return ""


def _solved(scene_file: str, variants: Mapping[str, Any], workers: int) -> xr.Dataset:
    """What happened in each case that is not refused."""
    plan = study_from_dict(
        {
            "name": "stability",
            "base": scene_file,
            "measure": "workflows.stability.path_of_load:path_of_load",
            "product": {"case": {"variants": dict(variants)}},
        }
    )
    (dataset,) = solved([plan], workers)
    words = [WORDS.get(word, word) for word in STATUS]
    failed = dataset.reason != ""
    return xr.Dataset(
        {
            "status": ("case", [words[i] for i in dataset.status.values]),
            "message": dataset.reason.where(failed, dataset.ending),
            "warnings": dataset.warnings.where(dataset.status != STATUS.index("failed"), ""),
            **{name: dataset[of].drop_attrs() for name, of in REACHED.items()},
        }
    )


def _with_references(
    dataset: xr.Dataset, cases: Mapping[str, Case], scenes: Mapping[str, Scene]
) -> xr.Dataset:
    """How each case should end, what is known of it, and whether that has held."""
    reference, error = zip(
        *(
            _along(dataset.sel(case=name), case.along, scenes[name])
            if case.along is not None
            else _compared(dataset, name, case)
            for name, case in cases.items()
        ),
        strict=True,
    )
    columns = {
        "expected": [case.ends for case in cases.values()],
        "within": [np.nan if case.within is None else case.within for case in cases.values()],
        "reference": list(reference),
        "error": list(error),
        "compared": [
            CLOSED_FORMS[case.along][0] if case.along else case.compared for case in cases.values()
        ],
        "reference_from": [case.source or case.as_case or "" for case in cases.values()],
    }
    dataset = dataset.assign({name: ("case", column) for name, column in columns.items()})
    return dataset.assign(held=_held(dataset))


def _compared(dataset: xr.Dataset, name: str, case: Case) -> tuple[float, float]:
    """The value that is known, and the error relative to it; nan where nothing is."""
    values = dataset[case.compared]
    known = case.exact
    if case.as_case is not None:
        known = case.times * _last(values.sel(case=case.as_case))
    if known is None:
        return np.nan, np.nan
    found = _last(values.sel(case=name))
    if case.vanishes:
        return 0.0, abs(found / known)
    return known, abs(found / known - 1.0)


def _along(row: xr.Dataset, form: str, scene: Scene) -> tuple[float, float]:
    """The last value of a closed form, and the largest error along the steps relative to it."""
    name, known_at = CLOSED_FORMS[form]
    there = np.isfinite(row[name].values) & np.isfinite(row.length.values)
    if np.count_nonzero(there) < 2:
        return np.nan, np.nan
    found = row[name].values[there]
    known = known_at(scene, row.length.values[there], row.load_factor.values[there])
    errors = np.abs(found - known)[known > 0.0] / known[known > 0.0]
    return float(known[-1]), float(errors.max())


def _last(values: xr.DataArray) -> float:
    """The value of a case, or that at its last step."""
    known = values.values[np.isfinite(values.values)]
    return float(known[-1]) if known.size else np.nan


def _held(dataset: xr.Dataset) -> xr.DataArray:
    """Whether a case ended as expected, as near to its reference as said, and clean."""
    clean = (dataset.not_known == 0) & ~(dataset.overlap > TOUCH)
    near = dataset.within.isnull() | (dataset.error <= dataset.within)
    return (dataset.status == dataset.expected) & near & clean
