"""Dataset of Fig. 8: the configurational force against elongation, by formulation and law."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from cfmpm.body.grid import Floats
from cfmpm.output.files import write_dataset
from cfmpm.scene import load_scene
from cfmpm.scene.specimens.single_edge import SingleEdge
from workflows.study.solved import without_failures

FEM = Path(__file__).parents[1] / "reference" / "large_strain_fem.csv"
# Of the study, what the figure and its claims are made from.
KEPT = (
    *("J", "cf_norm", "cf_angle", "unstable_points", "residual_norm"),
    *("newton_iterations", "substeps", "n_points", "empty_elements", "load_factor", "run_status"),
)
ELONGATION = {"units": "1", "long_name": "distance of the ends over height, -1"}
STRESS = {"units": "MPa", "long_name": "force on the top over width"}
# Of the last state under one of the ten loads.
ENDED = ("cf_norm", "empty_elements", "run_status")
# How the ten loads of the paper act: as tractions, and by moving the ends.
CONTROLS = ("dead", "moved")
# G of the plate of section 5.1 at 10 MPa: `converged` of its configuration [N/mm].
G_AT_10 = 0.2547822


@dataclass(frozen=True)
class Curve:
    """A path of stable states.

    Attributes
    ----------
    elongation : (n,) float
        Distance of the ends over the height, less one.
    force : (n,) float
        J or the norm of the configurational force [N/mm].
    stress : (n,) float
        Nominal: force on the top over the width [MPa].
    elliptic : (n,) bool
        Whether the material is elliptic at all points. Where it is not, results depend on the grid.
    """

    elongation: Floats
    force: Floats
    stress: Floats
    elliptic: np.ndarray[Any, np.dtype[np.bool_]]


def write_large_strain(study: str | Path, scene_file: str, path: str | Path) -> None:
    """Sort the dataset of the study: the plate pulled, in each variant of the scene.

    Parameters
    ----------
    study : Path
        netCDF file of a study of a single edge crack with the edges bottom and top loaded, with a
        parameter ``variant`` and `ellipticity.load_of_loss` as its measure.
    scene_file : str
        That the study starts from.
    path : Path
        Of the netCDF file: along a dimension variant, nan past the end of a path.
    """
    scene = load_scene(scene_file)
    plate = scene.family
    assert isinstance(plate, SingleEdge)
    found = without_failures(xr.load_dataset(study))
    dataset = found[list(KEPT)].isel(tip=0, drop=True)
    moved, force = (found[name] for name in ("displacement_y", "reaction_y"))
    dataset["elongation"] = _between_ends(moved) / plate.height
    dataset["elongation"].attrs = ELONGATION
    dataset["nominal_stress"] = force.sel(boundary="top", drop=True) / plate.width
    dataset["nominal_stress"].attrs = STRESS
    lost = [
        _elongation_at(float(found.unstable_from.sel(variant=name)), dataset.sel(variant=name))
        for name in dataset.variant.values
    ]
    told = "elongation at which the first point is no longer elliptic"
    dataset["ellipticity_lost"] = ("variant", lost, {"units": "1", "long_name": told})
    dataset.attrs["plane_modulus"] = scene.material.E / (1.0 - scene.material.nu**2)
    dataset.attrs["young"] = scene.material.E
    write_dataset(dataset, Path(path))


def write_steps(study: str | Path, scene_file: str, path: str | Path) -> None:
    """Sort the dataset of the study of load steps: where each of the ten loads led to.

    Parameters
    ----------
    study : Path
        netCDF file of a study with the parameters ``load``, whose names are dead or moved with a
        traction [MPa] or an elongation [%], and ``steps``.
    scene_file : str
        That the study starts from.
    path : Path
        Of the netCDF file: dimensions control, case and steps.
    """
    plate = load_scene(scene_file).family
    assert isinstance(plate, SingleEdge)
    found = without_failures(xr.load_dataset(study)).isel(tip=0, drop=True)
    parts = []
    for control in CONTROLS:
        names = [name for name in found["load"].values if name.startswith(f"{control}_")]
        asked = [float(name.removeprefix(f"{control}_")) for name in names]
        one = found.sel(load=names)
        last = one.load_factor.notnull().sum("step") - 1
        one = one[["load_factor", "displacement_y", "reaction_y", *ENDED]].isel(step=last)
        part = xr.Dataset(
            {
                "asked": ("load", asked),
                "load_factor": one.load_factor,
                "elongation": _between_ends(one.displacement_y) / plate.height,
                "nominal_stress": one.reaction_y.sel(boundary="top", drop=True) / plate.width,
                **{name: one[name] for name in ENDED},
            }
        )
        parts.append(part.rename(load="case").drop_vars("case"))
    dataset = xr.concat(parts, xr.Variable("control", list(CONTROLS)))
    dataset["asked"].attrs = {"long_name": "traction [MPa], or elongation of the moved ends [%]"}
    dataset["elongation"].attrs, dataset["nominal_stress"].attrs = ELONGATION, STRESS
    write_dataset(dataset.drop_vars(["radius", "step"], errors="ignore"), Path(path))


def reached(steps: xr.Dataset) -> xr.DataArray:
    """Whether the load that was asked for was reached, (control, case, steps)."""
    return steps.load_factor > 1.0 - 1e-9


def _between_ends(displacement: xr.DataArray) -> xr.DataArray:
    """How much longer the plate is [mm]."""
    top, bottom = (displacement.sel(boundary=name, drop=True) for name in ("top", "bottom"))
    return top - bottom


def _elongation_at(load_factor: float, path: xr.Dataset) -> float:
    """Elongation between the steps of a path."""
    known = path.elongation.notnull().values
    factors, reached = ([0.0, *path[name].values[known]] for name in ("load_factor", "elongation"))
    return float(np.interp(load_factor, factors, reached))


def curve(dataset: xr.Dataset, variant: str, quantity: str = "cf_norm") -> Curve:
    """Return the path of a variant, from the unloaded state on.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `write_large_strain`.
    variant : str
    quantity : {"cf_norm", "J"}
    """
    one = dataset.sel(variant=variant)
    one = one.isel(step=np.flatnonzero(one.elongation.notnull()))
    return Curve(
        *(np.append(0.0, one[name].values) for name in ("elongation", quantity, "nominal_stress")),
        np.append(True, one.unstable_points.values == 0),
    )


def fem(law: str, element: str, tip_size: float) -> Curve:
    """Return the path of the independent FEM, whose stable states alone are read."""
    with FEM.open(newline="", encoding="utf-8") as file:
        rows = [
            row
            for row in csv.DictReader(line for line in file if not line.startswith("#"))
            if (row["law"], row["element"], float(row["tip_size"])) == (law, element, tip_size)
            and not int(row["negative_pivots"])
        ]
    columns = (
        np.array([float(row[name]) for row in rows]) for name in ("elongation", "J", "force")
    )
    elongation, j, force = columns
    elliptic = np.array([float(row["acoustic"]) > 0.0 for row in rows])
    return Curve(elongation, j, force / 500.0, elliptic)


def of_fem(elongation: xr.DataArray) -> Floats:
    """J of Hencky's law by the independent FEM, T6 [N/mm]; nan where it has no stable state."""
    path = fem("hencky", "T6", 4.0)
    # J grows with the square of a small elongation.
    root = np.interp(
        elongation,
        np.append(0.0, path.elongation),
        np.append(0.0, np.sqrt(path.force)),
        right=np.nan,
    )
    squared: Floats = root**2
    return squared


def lefm(elongation: Floats, plane_modulus: float) -> Floats:
    """G of linear elasticity [N/mm] with the nominal stress E' times the elongation."""
    return G_AT_10 * (plane_modulus * elongation / 10.0) ** 2


def modulus(dataset: xr.Dataset) -> float:
    """E' of plane strain [MPa], of the scene."""
    return float(dataset.attrs["plane_modulus"])
