"""Runs of extreme cases: what happened, and how far from what is known."""

from __future__ import annotations

import logging
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import cfmpm
import numpy as np
import xarray as xr
from cfmpm.errors import MeshError, SceneError, SolveError
from cfmpm.output.files import write_dataset
from cfmpm.scene import load_scene

from workflows.stability.settings import Case, Stability
from workflows.stability.slivers import write_plate

# What a run that calls its steps solved must know at each of them.
KNOWN = (
    *("J", "cf_norm", "cf_x", "cf_y", "strain_energy", "external_work", "residual_norm"),
    *("reaction_x", "reaction_y", "displacement_x", "displacement_y", "negative_pivots"),
)
# Overlap of crack faces, in elements at the tip, that counts as none.
TOUCH = 1e-3
log = logging.getLogger(__name__)


def write_cases(settings: Mapping[str, Any], path: str | Path) -> None:
    """Run all cases.

    Parameters
    ----------
    settings : mapping
        The block stability of the workflow's configuration.
    path : Path
        Of the netCDF file: one entry along the dimension case for each, and the paths of load
        along step, nan past their end.
    """
    study = Stability.model_validate(settings)
    rows: dict[str, xr.Dataset] = {}
    for group, name, case in each(study):
        row = run_case(study.scene, study.groups[group].replaced, case)
        row["group"], row["expected"] = group, case.ends
        row["within"] = np.nan if case.within is None else case.within
        row["reference"], row["error"] = _compared(case, row, rows)
        row["compared"], row["reference_from"] = case.compared, case.source or case.as_case or ""
        rows[name] = row.assign_coords(step=np.arange(1, row.sizes["step"] + 1))
        log.info("%s: %s, error %.1e", name, row.status.item(), row.error)
    dataset = xr.concat(rows.values(), xr.Variable("case", list(rows)), join="outer")
    dataset["held"] = _held(dataset)
    write_dataset(dataset, Path(path))


def each(study: Stability) -> Iterator[tuple[str, str, Case]]:
    """Each case with its group and its name, which has that of the group before it."""
    for group, of_group in study.groups.items():
        for name, case in of_group.cases.items():
            yield group, f"{group}/{name}", case


def run_case(scene_file: str, shared: Mapping[str, Any], case: Case) -> xr.Dataset:
    """Run a case and say what happened; no ending of the program is left out.

    Parameters
    ----------
    scene_file : str
    shared : mapping
        Values of the scene that the group replaces.
    case : Case

    Returns
    -------
    xarray.Dataset
        Scalars, and the path of the load along step.
    """
    with tempfile.TemporaryDirectory() as folder:
        replaced = {**shared, **case.replaced}
        if case.grid is not None:
            mesh = Path(folder) / "plate.msh"
            write_plate(mesh, case.grid.slivers, case.grid.thinness)
            replaced["family"] = None
            replaced["mesh_file"] = {"file": str(mesh), "cracks": ["crack"]}
            replaced["mesh"] = {"element": case.grid.element}
        try:
            history = cfmpm.run(load_scene(scene_file, replaced)).history
        except SceneError as error:
            return _nothing("refused", str(error))
        except (MeshError, SolveError) as error:
            return _nothing("failed", str(error))
    ending = history.attrs["ending"]
    status = "unstable" if ending.startswith("unstable") else "solved"
    last, top = history.isel(step=-1), history.sel(boundary="top")
    j, overlap = np.full(history.step.size, np.nan), 0.0
    if history.tip.size:
        j = history.J.max("tip").values
        overlap = max(float((-history.min_opening / history.tip_size).max()), 0.0)
    row = xr.Dataset(
        {
            "status": status,
            "message": ending,
            "warnings": history.attrs["warnings"],
            "J": float(j[-1]),
            "load_reached": float(last.load_factor),
            "negative_pivots": float(history.negative_pivots.max()),
            "unstable_points": float(last.unstable_points),
            "newton_iterations": float(last.newton_iterations),
            "substeps": float(last.substeps),
            "residual": float(history.residual_norm.max()),
            "overlap": overlap,
            "not_known": sum(int(history[name].isnull().sum()) for name in KNOWN),
        }
    )
    row["load_factor"] = ("step", history.load_factor.values)
    row["J_path"] = ("step", j)
    row["force"] = ("step", top.reaction_y.values)
    bottom = history.displacement_y.sel(boundary="bottom")
    row["elongation"] = ("step", (top.displacement_y - bottom).values)
    return row


def _nothing(status: str, message: str) -> xr.Dataset:
    """The row of a case without a state."""
    names = ("J", "load_reached", "negative_pivots", "unstable_points", "newton_iterations")
    row = xr.Dataset(dict.fromkeys((*names, "substeps", "residual", "overlap"), np.nan))
    row["status"], row["message"], row["warnings"], row["not_known"] = status, message, "", 0
    for name in ("load_factor", "J_path", "force", "elongation"):
        row[name] = ("step", np.full(1, np.nan))
    return row


def _compared(case: Case, row: xr.Dataset, rows: Mapping[str, xr.Dataset]) -> tuple[float, float]:
    """The value that is known, and the error relative to it; nan where nothing is."""
    found = _last(row[case.compared])
    known = case.exact
    if case.as_case is not None:
        known = case.times * _last(rows[case.as_case][case.compared])
    if known is None:
        return np.nan, np.nan
    if case.vanishes:
        return 0.0, abs(found / known)
    return known, abs(found / known - 1.0)


def _last(values: xr.DataArray) -> float:
    """The value of a row, or that at its last step."""
    return float(np.ravel(values)[-1])


def _held(dataset: xr.Dataset) -> xr.DataArray:
    """Whether a case ended as expected, as near to its reference as said, and clean."""
    clean = (dataset.not_known == 0) & ~(dataset.negative_pivots > 0) & ~(dataset.overlap > TOUCH)
    near = dataset.within.isnull() | (dataset.error <= dataset.within)
    return (dataset.status == dataset.expected) & near & clean
