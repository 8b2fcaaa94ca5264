"""Films of growing cracks."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import cfmpm
from cfmpm.fields import linear_faces, von_mises
from cfmpm.materials import lame_constants
from cfmpm.plotting import animate_growth
from cfmpm.record import Record
from cfmpm.scene import load_scene
from cfmpm.simulation import State


def write_film(scene_file: str, replaced: Mapping[str, Any], every: int, path: str | Path) -> None:
    """Film the growth of one variant.

    Parameters
    ----------
    scene_file : str
        Of a body in plane strain.
    replaced : mapping
        Values of the scene that the variant replaces, by dotted keys.
    every : int
        Of how many increments one is shown.
    path : Path
        Of the GIF file.
    """
    frames: list[xr.Dataset] = []

    def keep(state: State, record: Record) -> None:
        if (len(record.steps) - 1) % every == 0:
            frames.append(_frame(state, len(record.steps), record.steps[-1].load_factor))

    cfmpm.run(load_scene(scene_file, replaced), observe=keep)
    animate_growth(frames, Path(path))


def _frame(state: State, step: int, load_factor: float) -> xr.Dataset:
    """What a picture of the deformed grid needs; stress is the mean of an element."""
    grid, source = state.grid, state.body.integration
    faces, element = linear_faces(grid)
    lam, mu = lame_constants(state.scene, grid.region_names)[source.material].T
    across = lam / (2.0 * (lam + mu)) * source.stress[:, :2].sum(axis=1)
    stress = np.column_stack([source.stress, across])
    n = len(grid.elements)
    share = source.volume / np.bincount(source.element, source.volume, n)[source.element]
    mean = np.zeros((n, 4))
    np.add.at(mean, source.element, share[:, None] * stress)
    said = {"units": "MPa", "long_name": "equivalent stress of von Mises"}
    return xr.Dataset(
        {
            "face_nodes": (("face", "corner"), faces),
            "element": ("face", element),
            "u_x": (("time", "node"), state.displacement[None, :, 0]),
            "u_y": (("time", "node"), state.displacement[None, :, 1]),
            "von_mises": (("time", "face"), von_mises(mean)[element][None], said),
        },
        {
            "time": [float(step)],
            "load_factor": ("time", [load_factor]),
            "node_x": ("node", grid.nodes[:, 0]),
            "node_y": ("node", grid.nodes[:, 1]),
        },
    )
