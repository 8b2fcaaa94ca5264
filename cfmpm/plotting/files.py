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
from cfmpm.plotting.growth import draw_load_displacement
from cfmpm.plotting.mesh import Mesh
from cfmpm.plotting.paths import corners_of, draw_paths, draw_tip_cf
from cfmpm.plotting.scene import draw_scene
from cfmpm.plotting.style import LEGEND, picture, size_around
from cfmpm.plotting.tip import draw_tip_forces
from cfmpm.scene import Scene

COLOUR_BAR = 0.9  # width [inch]


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


def save_growth(folder: Path, history: xr.Dataset, scene: Scene, grid: Grid) -> list[Path]:
    """Write paths.png, cf.png and, where the load changes, force_<part>_<axis>.png.

    Of loaded parts those that move, along the axes of their force. The scene is the expanded one;
    the grid is drawn where a mesh file takes the place of a geometry.
    """
    body = grid if scene.geometry is None else scene
    paths, size = [], size_around(corners_of(body), LEGEND)
    for name, draw in {"paths": draw_paths, "cf": draw_tip_cf}.items():
        paths.append(Path(folder) / f"{name}.png")
        with picture(paths[-1], size) as axes:
            draw(axes, history, body)
    factor = history["load_factor"].values
    if np.nanmax(factor) > np.nanmin(factor):
        largest = {
            what: max(float(np.abs(history[f"{what}_{axis}"]).max()) for axis in "xy")
            for what in ("reaction", "displacement")
        }
        for part, axis in itertools.product(map(str, history["boundary"].values), "xy"):
            of_part = history.sel(boundary=part)
            if all(
                float(np.abs(of_part[f"{what}_{axis}"]).max()) > 1e-6 * most
                for what, most in largest.items()
            ):
                path = Path(folder) / f"force_{part}_{axis}.png"
                with picture(path, (5.0, 4.0)) as axes:
                    draw_load_displacement(axes, history, part, axis)
                paths.append(path)
    return paths
