"""What the claims of sections 5.2 to 5.5 are decided from, and how it is told."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import xarray as xr

from cfmpm.body.grid import Floats
from cfmpm.ending import LOST, RUN_STATUS
from cfmpm.output.variables import TIP_STATUS
from workflows.reporting.claim_table import Claim

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
    """What claims are decided from.

    Attributes
    ----------
    edge, shear, holes, beam : xarray.Dataset
        From `datasets.write_growth`.
    edge_grids, shear_grids, holes_grids, beam_grids : xarray.Dataset
        Of the studies scatter_edge and so on: the same scenes on many grids.
    """

    edge: xr.Dataset
    shear: xr.Dataset
    holes: xr.Dataset
    beam: xr.Dataset
    edge_grids: xr.Dataset
    shear_grids: xr.Dataset
    holes_grids: xr.Dataset
    beam_grids: xr.Dataset


def arrival(run: xr.Dataset, tip: str) -> str:
    """Return the last status of a tip, a word of `TIP_STATUS`."""
    return TIP_STATUS[int(run.tip_status.sel(tip=tip)[-1])]


def told(run: xr.Dataset, tip: str) -> str:
    """Say what became of the crack of a tip."""
    return _TOLD[arrival(run, tip)]


def lost(run: xr.Dataset) -> str:
    """Say that a run came to no regular end; nothing if it did."""
    return "; no solution follows" if RUN_STATUS[int(run.run_status)] in LOST else ""


def reset(number: str, runs: Mapping[str, xr.Dataset], tip: str, figures: str) -> Claim:
    """Whether the loop of section 4.2 whole runs to its end: the grid reset after each release.

    Parameters
    ----------
    number : str
        Of the section.
    runs : mapping of str to xarray.Dataset
        From `datasets.steps`, by the words that tell them apart.
    tip : str
    figures : str
        As in `Claim`.
    """
    regular = [RUN_STATUS[int(run.run_status)] not in LOST for run in runs.values()]
    found = [
        f"{label}: {int(run.tip_x.sel(tip=tip).diff('step').notnull().sum())} increments, "
        f"{told(run, tip) if ended else 'ends without a stable state'}"
        for (label, run), ended in zip(runs.items(), regular, strict=True)
    ]
    return Claim(
        f"{number} The loop of section 4.2 whole: finite strain, grid reset after each release",
        "",
        "the crack runs on as without resets",
        "; ".join(found),
        grade(*regular),
        "each run comes to a regular end",
        figures=figures,
        sentence=f"With the grid reset after each release {sum(regular)} of {len(regular)} runs "
        "come to a regular end.",
    )


def toughness(run: xr.Dataset) -> float:
    """Return g_c [N/mm]: fracture energy over new length, all tips, of the first increment."""
    spent = run.fracture_energy.diff("step")[0]
    return float(spent / run.crack_length.diff("step")[0].sum())


def share(count: int, total: int) -> str:
    """Grade a claim that holds on some of many grids."""
    return "yes" if count == total else "in part" if count else "no"


def grade(*held: bool) -> str:
    """Say how far a claim holds that has several parts."""
    return "yes" if all(held) else "in part" if any(held) else "no"


def signed(values: Floats) -> str:
    """Write distances with their signs."""
    return " ".join(f"{value:+.3f}" for value in values)
