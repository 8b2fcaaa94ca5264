"""Datasets of sections 5.2 to 5.5: growing cracks, each scene in several variants."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cfmpm
import numpy as np
import xarray as xr
from cfmpm.body.grid import Floats
from cfmpm.output import analysis
from cfmpm.output.files import write_dataset
from cfmpm.output.variables import TIP_STATUS
from cfmpm.scene import load_scene

# Of the history, what figures and claims are made from.
KEPT = (
    *("tip_x", "tip_y", "crack_length", "tip_status", "domain_radius"),
    *("cf_angle", "cf_norm", "cf_tip_x", "cf_tip_y", "J", "G", "K_I", "K_II"),
    *("strain_energy", "external_work", "fracture_energy"),
    *("reaction_y", "displacement_y", "n_points", "empty_elements"),
)


def write_growth(
    scene_file: str, variants: Mapping[str, Mapping[str, Any]], path: str | Path
) -> None:
    """Let the cracks of a scene grow, in each of its variants.

    Parameters
    ----------
    scene_file : str
    variants : mapping of str to mapping
        Values of the scene that a variant replaces, by dotted keys.
    path : Path
        Of the netCDF file: the histories, as `stack` puts them together.
    """
    log = logging.getLogger(__name__)
    histories = {}
    for name, replaced in variants.items():
        histories[name] = cfmpm.run(load_scene(scene_file, replaced)).history
        sizes, ending = histories[name].sizes, histories[name].attrs["ending"]
        log.info("%s: %d steps, %s", name, sizes["step"], ending)
    write_dataset(stack(histories), Path(path))


def stack(histories: Mapping[str, xr.Dataset]) -> xr.Dataset:
    """Put histories along a dimension variant; steps that one of them has not are nan.

    Parameters
    ----------
    histories : mapping of str to xarray.Dataset
        By the name of the variant.
    """
    dataset = xr.concat(
        [
            history[list(KEPT)].isel(radius=-1, drop=True).reset_coords("load_factor")
            for history in histories.values()
        ],
        xr.Variable("variant", list(histories)),
        join="outer",
        combine_attrs="drop_conflicts",
        fill_value={"tip_status": np.int8(TIP_STATUS.index("stopped"))},
    )
    for name in ("ending", "config"):
        dataset[name] = "variant", [history.attrs[name] for history in histories.values()]
    return dataset


def tip_path(dataset: xr.Dataset, variant: str, tip: str | None = None) -> Floats:
    """Return where a tip has been, each place once, (k, 2) [mm].

    Parameters
    ----------
    dataset : xarray.Dataset
        From `write_growth`.
    variant : str
    tip : str, optional
        Default: the first.
    """
    return analysis.tip_path(dataset.sel(variant=variant), tip or str(dataset.tip.values[0]))


def steps(dataset: xr.Dataset, variant: str) -> xr.Dataset:
    """Return the history of a variant without the steps that it has not."""
    one = dataset.sel(variant=variant)
    return one.isel(step=np.flatnonzero(one.tip_x.notnull().any("tip")))


def segment_angles(path: Floats) -> Floats:
    """Angles of the segments of a path from the x axis [deg]."""
    dx, dy = np.diff(path, axis=0).T
    return np.degrees(np.arctan2(dy, dx))


def energy_released(run: xr.Dataset) -> Floats:
    """Return the sum of J times new length over all tips, up to each step, (step,) [N].

    Parameters
    ----------
    run : xarray.Dataset
        From `steps`, with all its tips. The trapezoidal rule takes J between two steps for linear;
        the sum ends, by nan, where a tip arrives, at which there is no J.
    """
    new = np.hypot(run.tip_x.diff("step"), run.tip_y.diff("step")).values
    mean = 0.5 * (run.J.values[1:] + run.J.values[:-1])
    released = np.where(new > 0.0, mean * new, 0.0).sum(axis=1)
    return np.append(0.0, np.cumsum(released))
