"""Pictures of a scene and of its result as files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from cfmpm.grid import Grid
from cfmpm.loading import Loading
from cfmpm.plotting.deformed import draw_deformed
from cfmpm.plotting.mesh import Mesh
from cfmpm.plotting.scene import draw_scene
from cfmpm.plotting.style import picture, size_around
from cfmpm.plotting.tip import draw_tip_forces
from cfmpm.scene.model import Scene

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
    """Write cf_<tip>.png for each tip, with the largest domain of the last step."""
    mesh, last, paths = Mesh.of_fields(fields), fields.isel(time=-1), []
    force = np.column_stack([last["cf_x"], last["cf_y"]])
    for name in history["tip"].values:
        tip = history.isel(step=-1).sel(tip=name)
        x = np.array([float(tip["tip_x"]), float(tip["tip_y"])])
        node = int(np.argmin(np.hypot(*(mesh.nodes - x).T)))
        path = Path(folder) / f"cf_{name}.png"
        with picture(path, (5.0, 5.5)) as axes:
            draw_tip_forces(axes, mesh, force, node, float(tip["domain_radius"].max()))
        paths.append(path)
    return paths
