"""Films of growing cracks."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import xarray as xr

import cfmpm
from cfmpm.output.fields import state_fields
from cfmpm.output.record import Record
from cfmpm.plotting import animate_growth
from cfmpm.scene import load_scene
from cfmpm.state import State


def write_film(
    scene_file: str,
    replaced: Mapping[str, Any],
    every: int,
    film: str | Path,
    shown: str | Path,
) -> None:
    """Film the growth of one variant.

    Parameters
    ----------
    scene_file : str
    replaced : mapping
        Values of the scene that the variant replaces, by dotted keys.
    every : int
        Of how many increments one is shown.
    film : Path
        GIF file.
    shown : Path
        The same as an animated PNG, which Snakemake's report shows: a GIF it only offers to be
        saved.
    """
    frames: list[xr.Dataset] = []

    def keep(state: State, record: Record) -> None:
        step = len(record.steps)
        if (step - 1) % every == 0:
            frames.append(state_fields(state, step, record.steps[-1].load_factor, {}))

    cfmpm.run(load_scene(scene_file, replaced), observe=keep)
    animate_growth(frames, Path(film), Path(shown))
