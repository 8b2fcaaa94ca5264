"""Pictures of a scene and of its result as files."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from cfmpm.grid import Grid
from cfmpm.loading import Loading
from cfmpm.plotting.deformed import draw_deformed
from cfmpm.plotting.growth import draw_load_displacement, draw_paths
from cfmpm.plotting.mesh import Mesh
from cfmpm.plotting.scene import draw_scene
from cfmpm.plotting.style import picture, size_around
from cfmpm.plotting.tip import draw_tip_forces
from cfmpm.scene import Scene, expand
from cfmpm.scene.geometry import Body

LEGEND, COLOUR_BAR = 2.6, 0.9  # widths [inch]


def save_scene(
    folder: Path, scene: Scene, grid: Grid, loading: Loading, radii: Sequence[float]
) -> Path:
    """Write scene.png; the arguments are those of `draw_scene`."""
    path = Path(folder) / "scene.png"
    with picture(path, size_around(grid.nodes, LEGEND)) as axes:
        draw_scene(axes, scene, grid, loading, radii)
    return path


def save_deformed(folder: Path, fields: xr.Dataset) -> Path:
    """Write deformed.png; the fields are those of :func:`cfmpm.fields.build_fields`."""
    path = Path(folder) / "deformed.png"
    with picture(path, size_around(Mesh.of_fields(fields).nodes, COLOUR_BAR)) as axes:
        draw_deformed(axes, fields)
    return path


def save_tip_forces(folder: Path, fields: xr.Dataset, history: xr.Dataset) -> list[Path]:
    """Write cf_<tip>.png for each tip that has not arrived, with its largest domain at the end."""
    mesh, last, paths = Mesh.of_fields(fields), fields.isel(time=-1), []
    force = np.column_stack([last["cf_x"], last["cf_y"]])
    solved = np.flatnonzero(np.isfinite(history["n_unknowns"].values))[-1]
    for name in history["tip"].values:
        tip = history.isel(step=solved).sel(tip=name)
        if np.isnan(tip["domain_radius"]).all():
            continue
        x = np.array([float(tip["tip_x"]), float(tip["tip_y"])])
        node = int(np.argmin(np.hypot(*(mesh.nodes - x).T)))
        path = Path(folder) / f"cf_{name}.png"
        with picture(path, (5.0, 5.5)) as axes:
            draw_tip_forces(axes, mesh, force, node, float(tip["domain_radius"].max()))
        paths.append(path)
    return paths


def save_growth(folder: Path, history: xr.Dataset, scene: Scene) -> list[Path]:
    """Write paths.png and, where the load changes, force_<part>_<axis>.png of each loaded part."""
    outline = Body.of(expand(scene)).outline.exterior.coords if scene.mesh_file is None else None
    places = np.column_stack([history["tip_x"].values.ravel(), history["tip_y"].values.ravel()])
    paths = [Path(folder) / "paths.png"]
    with picture(paths[0], size_around(np.array(outline or places), LEGEND)) as axes:
        draw_paths(axes, history, expand(scene))
    factor = history["load_factor"].values
    if np.nanmax(factor) > np.nanmin(factor):
        largest = max(float(np.abs(history[f"reaction_{axis}"]).max()) for axis in "xy")
        for part, axis in itertools.product(map(str, history["boundary"].values), "xy"):
            force = history.sel(boundary=part)[f"reaction_{axis}"]
            if float(np.abs(force).max()) > 1e-6 * largest:
                path = Path(folder) / f"force_{part}_{axis}.png"
                with picture(path, (5.0, 4.0)) as axes:
                    draw_load_displacement(axes, history, part, axis)
                paths.append(path)
    return paths
