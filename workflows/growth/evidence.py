"""What the claims of sections 5.2 to 5.5 are decided from, and how it is told."""

from __future__ import annotations

from dataclasses import dataclass

import xarray as xr

from cfmpm.body.grid import Floats
from cfmpm.ending import RUN_STATUS
from cfmpm.output.variables import TIP_STATUS


@dataclass(frozen=True)
class Evidence:
    """What claims are decided from: the datasets of `datasets.write_growth`."""

    edge: xr.Dataset
    shear: xr.Dataset
    holes: xr.Dataset
    beam: xr.Dataset


def arrival(run: xr.Dataset, tip: str) -> str:
    """Return the last status of a tip, a word of `TIP_STATUS`."""
    return TIP_STATUS[int(run.tip_status.sel(tip=tip)[-1])]


def ended(run: xr.Dataset) -> str:
    """Return how a run ended, a word of `RUN_STATUS`."""
    return RUN_STATUS[int(run.run_status)]


def grade(*held: bool) -> str:
    """Say how far a claim holds that has several parts."""
    return "yes" if all(held) else "in part" if any(held) else "no"


def signed(values: Floats) -> str:
    """Write distances with their signs."""
    return " ".join(f"{value:+.3f}" for value in values)
