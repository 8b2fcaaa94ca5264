"""Where the material loses ellipticity, as a measure of a study."""

from __future__ import annotations

import xarray as xr

from cfmpm.state import Result


def load_of_loss(result: Result) -> xr.Dataset:
    """Load factor at which the first point is no longer elliptic; nan where all are to the end."""
    told = {"units": "1", "long_name": "load factor at which ellipticity is lost"}
    return xr.Dataset({"unstable_from": ((), result.balance.unstable_from, told)})
