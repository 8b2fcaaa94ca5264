"""What the claims of sections 5.2 to 5.5 are decided from, and how it is told."""

from __future__ import annotations

from dataclasses import dataclass

import xarray as xr

from cfmpm.body.grid import Floats
from cfmpm.ending import LOST, RUN_STATUS
from cfmpm.output.variables import TIP_STATUS

# What a status of a tip says of its crack.
_TOLD = {
    "growing": "still runs",
    "stopped": "stops",
    "arrived_boundary": "reaches the edge",
    "arrived_hole": "ends in a hole",
    "arrived_crack": "meets the other crack",
    "severed": "lies in a part that is cut off",
}


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


def told(run: xr.Dataset, tip: str) -> str:
    """Say what became of the crack of a tip."""
    return _TOLD[arrival(run, tip)]


def lost(run: xr.Dataset) -> str:
    """Say that a run came to no regular end; nothing if it did."""
    return "; no solution follows" if RUN_STATUS[int(run.run_status)] in LOST else ""


def grade(*held: bool) -> str:
    """Say how far a claim holds that has several parts."""
    return "yes" if all(held) else "in part" if any(held) else "no"


def signed(values: Floats) -> str:
    """Write distances with their signs."""
    return " ".join(f"{value:+.3f}" for value in values)
