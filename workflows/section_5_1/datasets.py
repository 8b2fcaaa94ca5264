"""Datasets of section 5.1: the stationary edge crack, by cfmpm and by an independent FEM."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from cfmpm.output.files import write_dataset
from cfmpm.scene import load_scene
from cfmpm.scene.model import Scene
from cfmpm.scene.specimens.single_edge import SingleEdge
from workflows.section_5_1.fem_beside import FORCE, angle
from workflows.study.solved import without_failures

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
    "run_time": ("s", "wall time of the run by cfmpm"),
}


# Of a grid that is drawn.
OF_GRIDS = ("node_x", "node_y", "cf_node_x", "cf_node_y", "triangle", "tip_node", "n_points")
POINTS = ("point_x", "point_y")
_OF_SIZE = {"node": "node_x", "face": "triangle", "point": "point_x"}


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
    study: str | Path,
    scene_file: str,
    drawn: Sequence[str],
    series: Mapping[str, str | Path],
    grids: str | Path,
) -> None:
    """Sort the dataset of the study by series of grids, and take out the grids that are drawn.

    Parameters
    ----------
    study : Path
        netCDF file of the study of `settings.Section51`.
    scene_file : str
        That the study starts from.
    drawn : sequence of str
        Grids that are kept with their points and the configurational force of their nodes, for
        pictures, by their names in the study.
    series : mapping of str to Path
        netCDF files by series: dimensions scheme, grid, radius.
    grids : Path
        netCDF file: dimensions grid, node, face, point; unused places hold nan and -1.
    """
    found = without_failures(xr.load_dataset(study))
    handbook = handbook_energy_release_rate(load_scene(scene_file))
    for name, path in series.items():
        dataset = _of_series(found, name).assign_attrs(handbook=handbook)
        dataset.attrs["title"] = "Single edge crack, cfmpm and FEM on the same grids"
        write_dataset(dataset, Path(path))
    kept = found[[*OF_GRIDS, *POINTS]].sel(grid=list(drawn))
    for size in ("node", "face", "point"):
        kept = kept.dropna(size, how="all", subset=[_OF_SIZE[size]])
    whole = kept.assign(
        {name: kept[name].fillna(-1).astype(np.int32) for name in ("triangle", "tip_node")}
    )
    write_dataset(whole.drop_vars("tip", errors="ignore"), Path(grids))


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
    counts = ("cf_difference", "n_points", "n_elements", "n_unknowns", "run_time")
    dataset = dataset.assign({key: one[key] for key in counts}).assign_attrs(study.attrs)
    for key, (units, long_name) in VARIABLES.items():
        dataset[key].attrs = {"units": units, "long_name": long_name}
    return _numbered(dataset)


def _numbered(dataset: xr.Dataset) -> xr.Dataset:
    """Grids by the number of triangles in the paper, in place of their names in the study."""
    wanted = [int(label.rpartition("_")[2]) for label in dataset.grid.values]
    told = "triangles of the paper's grid, to which this one is nearest"
    return dataset.assign_coords(grid=("grid", wanted, {"long_name": told}))
