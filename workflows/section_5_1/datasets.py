"""Datasets of section 5.1: the stationary edge crack, by cfmpm and by an independent FEM."""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cfmpm
import numpy as np
import xarray as xr
from cfmpm.body.grid import Floats
from cfmpm.output.files import write_dataset
from cfmpm.scene import effective_config
from cfmpm.scene.model import Scene
from cfmpm.scene.specimens.single_edge import SingleEdge
from scipy.sparse.linalg import spsolve

from workflows.configuration.scene_with_grid import scene_with
from workflows.reference import plate_fem

FORCE = "N mm-1"
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


def write_series(
    scene_file: str,
    meshes: Mapping[int, Mapping[str, Any]],
    radii: Sequence[float],
    path: str | Path,
) -> None:
    """Solve one scene on several grids, by cfmpm and by FEM on the same grids.

    Parameters
    ----------
    scene_file : str
    meshes : mapping
        By the number of triangles in the paper.
    radii : sequence of float
        Domain radii [mm].
    path : Path
        Of the netCDF file: dimensions scheme, grid, radius.
    """
    log = logging.getLogger(__name__)
    rows, scenes = [], []
    for wanted, mesh in meshes.items():
        scene = scene_with(scene_file, mesh, list(radii))
        result = cfmpm.run(scene)
        log.info("%s: %d triangles", mesh, len(result.grid.elements))
        rows.append(_compare(result, wanted))
        scenes.append(scene)
    dataset = xr.concat(rows, "grid", combine_attrs="drop_conflicts")
    dataset.grid.attrs["long_name"] = "triangles of the paper's grid, to which this one is nearest"
    for name, (units, long_name) in VARIABLES.items():
        dataset[name].attrs = {"units": units, "long_name": long_name}
    dataset.attrs["configs"] = json.dumps([effective_config(scene) for scene in scenes])
    dataset.attrs["handbook"] = handbook_energy_release_rate(scenes[0])
    dataset.attrs["title"] = "Single edge crack, cfmpm and FEM on the same grids"
    write_dataset(dataset, Path(path))


def write_grids(scene_file: str, meshes: Mapping[int, Mapping[str, Any]], path: str | Path) -> None:
    """Keep grids and the configurational force of their nodes, for pictures.

    Parameters
    ----------
    scene_file : str
    meshes : mapping
        By the number of triangles in the paper; T3.
    path : Path
        Of the netCDF file: dimensions grid, node, face; unused places hold nan and -1.
    """
    rows = []
    for wanted, mesh in meshes.items():
        result = cfmpm.run(scene_with(scene_file, mesh))
        nodes, force = result.grid.nodes, result.configurational_force
        row = xr.Dataset(
            {
                "node_x": ("node", nodes[:, 0], {"units": "mm"}),
                "node_y": ("node", nodes[:, 1], {"units": "mm"}),
                "cf_x": ("node", force[:, 0], {"units": FORCE}),
                "cf_y": ("node", force[:, 1], {"units": FORCE}),
                "triangle": (("face", "corner"), result.grid.triangles.astype(np.int32)),
                "tip_node": result.grid.tips[0].node,
            },
            coords={
                "grid": wanted,
                "node": np.arange(len(nodes)),
                "face": np.arange(len(result.grid.elements)),
            },
            attrs=result.history.attrs,
        )
        rows.append(row)
    dataset = xr.concat(
        rows,
        "grid",
        join="outer",
        combine_attrs="drop_conflicts",
        fill_value={"triangle": np.int32(-1)},
    )
    write_dataset(dataset, Path(path))


def _compare(result: cfmpm.Result, wanted: int) -> xr.Dataset:
    """One grid: what cfmpm has found, and what FEM finds."""
    grid = result.grid
    history = result.history.isel(step=0, tip=0)
    tip = grid.nodes[grid.tips[0].node]
    radii = history.domain_radius.values
    plate = plate_fem.plate_of(result.scene, grid)
    system = plate_fem.assemble(plate, degree=grid.element.order)
    fem = plate_fem.solve(system, spsolve)
    place, force = plate_fem.nodal_force(fem)

    # Supports differ, and with them the rigid rotation, which moves CF at loaded nodes only.
    corners = np.hypot(*(plate.nodes - tip).T) <= radii.max()
    own = result.configurational_force[: grid.n_corners][corners]
    difference = np.abs(force[: grid.n_corners][corners] - own).max() / np.abs(own).max()

    distance = np.hypot(*(place - tip).T)
    sums = np.array([force[distance <= radius].sum(axis=0) for radius in radii])
    at_tip = force[grid.tips[0].node]
    own_tip = np.array([history.cf_tip_x, history.cf_tip_y])
    both = "scheme"
    data = {
        "cf_norm": ((both, "radius"), [history.cf_norm_radius.values, np.hypot(*sums.T)]),
        "cf_angle": ((both, "radius"), [history.cf_angle_radius.values, _angle(sums)]),
        "cf_tip_norm": (both, [np.hypot(*own_tip), np.hypot(*at_tip)]),
        "cf_tip_angle": (both, [_angle(own_tip), _angle(at_tip)]),
        "J": (
            (both, "radius"),
            [
                history.J_radius.values,
                [plate_fem.j_integral(fem, tip, radius) for radius in radii],
            ],
        ),
        "strain_energy": (both, [float(history.strain_energy), fem.energy]),
        "cf_difference": difference,
        "n_points": int(history.n_points),
        "n_elements": len(grid.elements),
        "n_unknowns": int(history.n_unknowns),
    }
    coords = {
        both: ["MPM", "FEM"],
        "radius": ("radius", radii, {"units": "mm", "long_name": "domain radius"}),
        "grid": wanted,
    }
    return xr.Dataset(data, coords, history.attrs)


def _angle(force: Floats) -> Floats:
    """Angle from the crack, which lies along x [deg]."""
    return np.degrees(np.arctan2(force[..., 1], force[..., 0]))
