"""Reading of datasets that cfmpm has written."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from cfmpm.errors import Problem, SceneError
from cfmpm.output.dataset_rules import broken_rules
from cfmpm.output.netcdf import DamagedError, read_netcdf


def read_result(path: Path, variable: str) -> xr.Dataset:
    """Read a dataset of cfmpm into memory.

    Parameters
    ----------
    path : Path
    variable : str
        A variable that identifies the kind of dataset, one of `dataset_rules.RULES`.

    Raises
    ------
    SceneError
        If the file cannot be read, or is another kind of dataset.
    """
    if not path.exists():
        study = path.with_name("study.nc")
        reason = _of_study(study) if study.is_file() else "no such result; cfmpm run makes one"
        raise SceneError([Problem(reason, file=str(path))])
    try:
        dataset = read_netcdf(path)
    except (OSError, DamagedError) as error:
        reason = f"cannot be read as netCDF: {getattr(error, 'strerror', None) or error}"
        raise SceneError([Problem(reason, file=str(path))]) from None
    if variable not in dataset or not {"config", "config_hash"} <= dataset.attrs.keys():
        reason = "is not a result of cfmpm run; give the folder of a run, or its history.nc"
        if "study" in dataset.attrs:
            reason = _of_study(path)
        raise SceneError([Problem(reason, file=str(path))])
    for reason in broken_rules(dataset, variable):
        raise SceneError([Problem(f"is damaged: {reason}", file=str(path))])
    return dataset


def _of_study(dataset: Path) -> str:
    """Message for a study where the result of a run is expected."""
    return (
        f"this is a study, not a run: open it by ds = xarray.open_dataset({str(dataset)!r}), and "
        "plot a member by ds.isel(...).cfmpm.plot_path()"
    )
