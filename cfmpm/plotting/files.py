"""Figures of a scene and of its result as files."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from cfmpm.body.body import Body
from cfmpm.body.grid import Grid
from cfmpm.output.analysis import new_length, resolved_steps
from cfmpm.output.files import in_file_name
from cfmpm.output.run_folder import SCENE, description
from cfmpm.plotting.deformed import draw_deformed
from cfmpm.plotting.growth import (
    draw_angles,
    draw_cycles,
    draw_energy,
    draw_factors,
    draw_load,
    draw_load_displacement,
    draw_steps,
)
from cfmpm.plotting.mesh import Mesh
from cfmpm.plotting.paths import corners_of, draw_paths, draw_tip_cf
from cfmpm.plotting.scene import draw_scene
from cfmpm.plotting.style import COLOUR_BAR, LEGEND, panels, picture, size_around
from cfmpm.plotting.tip import (
    draw_norm,
    draw_radii,
    draw_tip_forces,
    draw_tip_points,
    norm_is_apart,
)
from cfmpm.scene import Scene, config_hash, expand

# Sizes of figures around a tip and of curves [inch].
TIP, CURVE = (5.0, 5.5), (5.0, 4.0)


def save_scene(folder: Path, scene: Scene, body: Body) -> Path:
    """Write scene.png of a scene and its body before growth; the file says which scene it is of."""
    path, grid = Path(folder) / SCENE, body.grid
    radii = [max(domain.radii) for domain in body.tip_domains]
    with picture(path, size_around(grid.nodes, LEGEND), description(config_hash(scene))) as axes:
        draw_scene(axes, expand(scene), grid, body.loading, radii)
    return path


def save_tip_points(folder: Path, body: Body) -> list[Path]:
    """Write mesh_<tip>.png for each tip of a body: its grid and material points there."""
    paths = []
    for tip, domains in zip(body.grid.tips, body.tip_domains, strict=True):
        paths.append(Path(folder) / f"mesh_{in_file_name(tip.name)}.png")
        with picture(paths[-1], TIP) as axes:
            draw_tip_points(axes, body.grid, body.points, tip, domains.radii)
    return paths


def save_radii(folder: Path, history: xr.Dataset) -> list[Path]:
    """Write radii_<tip>.png for each tip at the last step that resolves it, for several radii."""
    if history.sizes["radius"] < 2:
        return []
    paths = []
    for name in history["tip"].values:
        of_tip = history.sel(tip=name)
        evaluated = np.isfinite(of_tip["J"].values)
        resolved = evaluated & resolved_steps(of_tip)
        shown = np.flatnonzero(resolved if resolved.any() else evaluated)[-1]
        paths.append(Path(folder) / f"radii_{in_file_name(name)}.png")
        at = of_tip.isel(step=shown)
        apart = norm_is_apart(at)
        with panels(paths[-1], (CURVE[0], CURVE[1] * (1 + apart)), 1 + apart, 1) as axes:
            draw_radii(axes[0, 0], at, norm=not apart)
            if apart:
                draw_norm(axes[1, 0], at)
    return paths


def save_deformed(folder: Path, fields: xr.Dataset) -> Path:
    """Write deformed.png; the fields are those of :func:`cfmpm.output.fields.build_fields`."""
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
        path = Path(folder) / f"cf_{in_file_name(name)}.png"
        with picture(path, TIP) as axes:
            draw_tip_forces(axes, mesh, force, node, float(tip["domain_radius"].max()))
        paths.append(path)
    return paths


def save_growth(folder: Path, history: xr.Dataset, scene: Scene, grid: Grid) -> list[Path]:
    """Write paths.png, cf.png, angles.png, energy.png and further figures of crack growth.

    These are factors.png at small strain, load.png if the load changes, and cycles.png for
    fatigue. The scene is expanded; the grid is drawn if the scene has a mesh file in place of a
    geometry.
    """
    body = grid if scene.geometry is None else scene
    paths, size = [], size_around(corners_of(body), LEGEND)
    for name, draw in {"paths": draw_paths, "cf": draw_tip_cf}.items():
        paths.append(Path(folder) / f"{name}.png")
        with picture(paths[-1], size) as axes:
            draw(axes, history, body)
    curves: dict[str, Callable[[Axes, xr.Dataset], Axes]]
    curves = {"angles": draw_angles, "energy": draw_energy}
    if np.isfinite(history["K_I"]).any():
        curves["factors"] = draw_factors
    if _load_changes(history):
        curves["load"] = draw_load
    if "cycles" in history:
        curves["cycles"] = draw_cycles
    return paths + _save_curves(folder, history, curves)


def save_steps(folder: Path, history: xr.Dataset) -> list[Path]:
    """Write force_<part>_<axis>.png for each loaded part with displacement along its force.

    For steps at several loads; for stationary cracks also steps_<tip>.png.
    """
    if not _load_changes(history):
        return []
    curves: dict[str, Callable[[Axes, xr.Dataset], Axes]] = {
        f"force_{in_file_name(part)}_{axis}": partial(
            draw_load_displacement, boundary=part, component=axis
        )
        for part, axis in _moving_parts(history)
    }
    if not new_length(history).any():
        curves |= {
            f"steps_{in_file_name(tip)}": partial(draw_steps, tip=tip)
            for tip in history["tip"].values
        }
    return _save_curves(folder, history, curves)


def _load_changes(history: xr.Dataset) -> bool:
    factor = history["load_factor"]
    return bool(factor.max() > factor.min())


def _save_curves(
    folder: Path, history: xr.Dataset, curves: Mapping[str, Callable[[Axes, xr.Dataset], Axes]]
) -> list[Path]:
    paths = []
    for name, draw_curve in curves.items():
        paths.append(Path(folder) / f"{name}.png")
        with picture(paths[-1], CURVE) as axes:
            draw_curve(axes, history)
    return paths


def _moving_parts(history: xr.Dataset) -> list[tuple[str, str]]:
    """Loaded parts, and the axes along which they have a displacement and a force."""

    def most(of: xr.Dataset, what: str, axes: str = "xy") -> float:
        return max(float(np.abs(of[f"{what}_{axis}"]).max()) for axis in axes)

    return [
        (part, axis)
        for part, axis in itertools.product(map(str, history["boundary"].values), "xy")
        if all(
            most(history.sel(boundary=part), what, axis) > 1e-6 * most(history, what)
            for what in ("reaction", "displacement")
        )
    ]
