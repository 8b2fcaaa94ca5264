"""Datasets of section 5.1: the stationary edge crack, by cfmpm and by an independent FEM."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from cfmpm.output.files import write_dataset
from cfmpm.scene.model import Scene
from cfmpm.scene.specimens.single_edge import SingleEdge
from cfmpm.study.reading import Plan, load_study, study_from_dict
from workflows.section_5_1.fem_beside import FORCE, angle
from workflows.study.solved import solved, without_failures

# Name: units, long name.
VARIABLES = {
    "cf_norm": (FORCE, "norm of the configurational force on a domain (paper eq 27)"),
    "cf_angle": ("degree", "angle of the configurational force on a domain"),
    "cf_tip_norm": (FORCE, "norm of the configurational force on the tip node (paper eq 26)"),
    "cf_tip_angle": ("degree", "angle of the configurational force on the tip node"),
    "J": (FORCE, "domain integral in a ring from half the radius to the radius"),
    "strain_energy": ("N", "strain energy per mm of thickness (N mm/mm)"),
    "cf_difference": ("1", "largest difference of the nodal CF around the tip, over the largest"),
    "n_points": ("1", "material points"),
    "n_elements": ("1", "triangles"),
    "n_unknowns": ("1", "free degrees of freedom"),
}


def handbook_energy_release_rate(scene: Scene) -> float:
    """Return G [N/mm] of an edge crack in an infinitely long strip under tension.

    Brown and Srawley's polynomial (1966), which the paper takes for its analytical solution.
    """
    plate = scene.family
    if not isinstance(plate, SingleEdge) or plate.traction is None or scene.plane != "strain":
        raise ValueError("the handbook formula is for a single edge crack under traction")
    x = plate.crack_length / plate.width
    shape = 1.12 - 0.231 * x + 10.55 * x**2 - 21.72 * x**3 + 30.39 * x**4
    k_1 = shape * plate.traction * np.sqrt(np.pi * plate.crack_length)
    return float(k_1**2 * (1.0 - scene.material.nu**2) / scene.material.E)


def write_datasets(
    study_file: str,
    drawn: Sequence[int],
    workers: int,
    series: Mapping[str, str | Path],
    grids: str | Path,
) -> None:
    """Solve one scene on several grids, by cfmpm and by FEM on the same grids.

    Parameters
    ----------
    study_file : str
        As in `settings.Section51`.
    drawn : sequence of int
        Grids of T3 that are kept with the configurational force of their nodes, for pictures.
    workers : int
        Processes.
    series : mapping of str to Path
        netCDF files by series: dimensions scheme, grid, radius.
    grids : Path
        netCDF file: dimensions grid, node, face; unused places hold nan and -1.
    """
    plan = load_study(study_file)
    study, of_nodes = solved([plan, _of_grids(plan, drawn)], workers)
    handbook = handbook_energy_release_rate(plan.members[0].scene)
    for name, path in series.items():
        dataset = _of_series(without_failures(study), name).assign_attrs(handbook=handbook)
        dataset.attrs["title"] = "Single edge crack, cfmpm and FEM on the same grids"
        write_dataset(dataset, Path(path))
    of_nodes = without_failures(of_nodes)
    kept = of_nodes[["node_x", "node_y", "tip_node"]].assign(
        cf_x=of_nodes.cf_node_x,
        cf_y=of_nodes.cf_node_y,
        triangle=of_nodes.triangle.fillna(-1).astype(np.int32),
    )
    kept["tip_node"] = kept.tip_node.astype(int)
    write_dataset(_numbered(kept), Path(grids))


def _of_grids(plan: Plan, drawn: Sequence[int]) -> Plan:
    """The study of the grids that are kept whole."""
    meshes = plan.study.product["grid"].values
    grid = {"key": "mesh", "values": {f"T3_{n}": meshes[f"T3_{n}"] for n in sorted(set(drawn))}}
    measure = "workflows.section_5_1.fem_beside:nodal_forces"
    study = {
        "name": "grids",
        "base": dict(plan.base),
        "product": {"grid": grid},
        "measure": measure,
    }
    return study_from_dict(study, plan.folder)


def _of_series(study: xr.Dataset, name: str) -> xr.Dataset:
    """The grids of one series, with a dimension scheme for cfmpm and FEM."""
    chosen = [label for label in study.grid.values if label.rpartition("_")[0] == name]
    one = study.sel(grid=chosen).isel(tip=0, drop=True)
    tip = np.stack([one.cf_tip_x, one.cf_tip_y], axis=-1)
    own: dict[str, Any] = {
        "cf_norm": one.cf_norm_radius,
        "cf_angle": one.cf_angle_radius,
        "cf_tip_norm": one.cf_tip_x.copy(data=np.hypot(*tip.T)),
        "cf_tip_angle": one.cf_tip_x.copy(data=angle(tip)),
        "J": one.J_radius,
        "strain_energy": one.strain_energy,
    }
    scheme = xr.Variable("scheme", ["MPM", "FEM"])
    dataset = xr.Dataset(
        {
            key: xr.concat([values, one[f"fem_{key}"]], scheme, combine_attrs="override")
            for key, values in own.items()
        }
    )
    counts = ("cf_difference", "n_points", "n_elements", "n_unknowns")
    dataset = dataset.assign({key: one[key] for key in counts}).assign_attrs(study.attrs)
    for key, (units, long_name) in VARIABLES.items():
        dataset[key].attrs = {"units": units, "long_name": long_name}
    return _numbered(dataset)


def _numbered(dataset: xr.Dataset) -> xr.Dataset:
    """Grids by the number of triangles in the paper, in place of their names in the study."""
    wanted = [int(label.rpartition("_")[2]) for label in dataset.grid.values]
    told = "triangles of the paper's grid, to which this one is nearest"
    return dataset.assign_coords(grid=("grid", wanted, {"long_name": told}))
