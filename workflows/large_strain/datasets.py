"""Dataset of Fig. 8: the configurational force against elongation, by formulation and law."""

from __future__ import annotations

import csv
import logging
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cfmpm
import numpy as np
import xarray as xr
from cfmpm.body.grid import Floats
from cfmpm.output.files import write_dataset
from cfmpm.scene import load_scene
from cfmpm.scene.model import Scene
from cfmpm.scene.specimens.single_edge import SingleEdge

FEM = Path(__file__).parents[1] / "reference" / "large_strain_fem.csv"
# Of the history, what the figure and its claims are made from.
KEPT = (
    *("J", "cf_norm", "cf_angle", "unstable_points", "negative_pivots", "residual_norm"),
    *("newton_iterations", "substeps", "n_points", "empty_elements"),
)
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


def write_large_strain(
    scene_file: str, variants: Mapping[str, Mapping[str, Any]], path: str | Path
) -> None:
    """Pull the plate, in each variant of the scene.

    Parameters
    ----------
    scene_file : str
        Of a single edge crack with the edges bottom and top loaded.
    variants : mapping of str to mapping
        Values of the scene that a variant replaces, by dotted keys.
    path : Path
        Of the netCDF file: along a dimension variant, nan past the end of a path.
    """
    log = logging.getLogger(__name__)
    rows, endings, lost = [], [], []
    for name, replaced in variants.items():
        scene = load_scene(scene_file, replaced)
        result = cfmpm.run(scene)
        row = _row(scene, result.history)
        log.info("%s: to %.4f, %s", name, row.elongation[-1], result.history.attrs["ending"])
        rows.append(row)
        endings.append(result.history.attrs["ending"])
        factors, reached = ([0.0, *row[key].values] for key in ("load_factor", "elongation"))
        lost.append(float(np.interp(result.balance.unstable_from, factors, reached)))
    dataset = xr.concat(
        rows, xr.Variable("variant", list(variants)), join="outer", combine_attrs="drop_conflicts"
    )
    dataset["ending"] = ("variant", endings)
    dataset["ellipticity_lost"] = (
        "variant",
        lost,
        {"units": "1", "long_name": "elongation at which the first point is no longer elliptic"},
    )
    write_dataset(dataset, Path(path))


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


def lefm(elongation: Floats, plane_modulus: float) -> Floats:
    """G of linear elasticity [N/mm] with the nominal stress E' times the elongation."""
    return G_AT_10 * (plane_modulus * elongation / 10.0) ** 2


def modulus(dataset: xr.Dataset) -> float:
    """E' of plane strain [MPa], of the scene."""
    return float(dataset.attrs["plane_modulus"])


def _row(scene: Scene, history: xr.Dataset) -> xr.Dataset:
    """Reduce a history to its curve."""
    plate = scene.family
    assert isinstance(plate, SingleEdge)
    row = history[list(KEPT)].isel(tip=0, drop=True).reset_coords("load_factor")
    bottom, top = (
        history[["displacement_y", "reaction_y"]].sel(boundary=name).reset_coords(drop=True)
        for name in ("bottom", "top")
    )
    row["elongation"] = (top.displacement_y - bottom.displacement_y) / plate.height
    row["elongation"].attrs = {"units": "1", "long_name": "distance of the ends over height, -1"}
    row["nominal_stress"] = top.reaction_y / plate.width
    row["nominal_stress"].attrs = {"units": "MPa", "long_name": "force on the top over width"}
    row.attrs["plane_modulus"] = scene.material.E / (1.0 - scene.material.nu**2)
    return row
