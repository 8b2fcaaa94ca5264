"""Reading of datasets that cfmpm has written."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from cfmpm.errors import Problem, SceneError


def read_result(path: Path, variable: str) -> xr.Dataset:
    """Read a dataset of cfmpm into memory.

    Parameters
    ----------
    path : Path
    variable : str
        By which it is known that the dataset is what it should be.

    Raises
    ------
    SceneError
        Where it is not.
    """
    if not path.is_file():
        study = path.with_name("study.nc")
        reason = _of_study(study) if study.is_file() else "no such result; cfmpm run makes one"
        raise SceneError([Problem(reason, file=str(path))])
    try:
        dataset = xr.load_dataset(path, engine="netcdf4")
    except (OSError, RuntimeError, ValueError) as error:
        reason = f"cannot be read as netCDF: {getattr(error, 'strerror', None) or error}"
        raise SceneError([Problem(reason, file=str(path))]) from None
    if variable not in dataset or not {"config", "config_hash"} <= dataset.attrs.keys():
        reason = "is not what cfmpm run writes; give the folder of a run, or its history.nc"
        if "study" in dataset.attrs:
            reason = _of_study(path)
        raise SceneError([Problem(reason, file=str(path))])
    return dataset


def _of_study(dataset: Path) -> str:
    """What to do with a study where one run is asked for."""
    return (
        f"this is a study, not one run: look at ds = xarray.open_dataset({str(dataset)!r}), and at "
        "one of its members by ds.isel(...).cfmpm.plot_path()"
    )
