"""Datasets of sections 5.2 to 5.5: growing cracks, each scene in several variants."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from cfmpm.body.grid import Floats
from cfmpm.output import analysis
from cfmpm.output.files import write_dataset
from cfmpm.study.reading import load_study
from workflows.study.solved import solved, without_failures

# Of the study, what figures and claims are made from.
KEPT = (
    *("tip_x", "tip_y", "crack_length", "tip_status", "domain_radius", "tip_size"),
    *("cf_angle", "cf_norm", "cf_tip_x", "cf_tip_y", "J", "G", "K_I", "K_II"),
    *("strain_energy", "external_work", "fracture_energy"),
    *("reaction_y", "displacement_y", "n_points", "empty_elements", "load_factor", "run_status"),
)


def write_growth(study_file: str, workers: int, path: str | Path) -> None:
    """Let the cracks of a scene grow, in each of its variants.

    Parameters
    ----------
    study_file : str
        With a parameter ``variant``.
    workers : int
        Processes.
    path : Path
        Of the netCDF file: what is `KEPT` of the study, at the largest domain radius.
    """
    (dataset,) = solved([load_study(study_file)], workers)
    kept = without_failures(dataset)[list(KEPT)].isel(radius=-1)
    write_dataset(kept.drop_vars("radius", errors="ignore"), Path(path))


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


def radius_of(dataset: xr.Dataset, variant: str) -> float:
    """Return the domain radius at the first step of the first tip [mm]."""
    return float(dataset.domain_radius.sel(variant=variant).isel(tip=0, step=0))


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
