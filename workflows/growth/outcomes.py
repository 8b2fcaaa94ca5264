"""What becomes of the cracks of a scene on many grids: paths, ends and their shares."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from cfmpm.body.grid import Floats
from cfmpm.ending import LOST, RUN_STATUS
from cfmpm.output import analysis
from cfmpm.output.variables import TIP_STATUS
from workflows.growth.beam_holes import BOTTOM, HOLE, INCH, MIDDLE, TOP
from workflows.growth.datasets import segment_angles

# A crack that stops so near to the edge of a hole is arrested by it [mm].
NEAR = 0.1 * HOLE
LOST_WAY = "without a solution"


@dataclass(frozen=True)
class Outcome:
    """A crack on one grid.

    Attributes
    ----------
    path : (k, 2) float
        Where its tip has been [mm].
    status : str
        A word of `TIP_STATUS`.
    points : int
        Material points of the grid.
    lost : bool
        Whether the run came to no regular end while the crack was on its way.
    """

    path: Floats
    status: str
    points: int
    lost: bool


def outcomes(scatter: xr.Dataset, tip: str, **chosen: str) -> list[Outcome]:
    """Return what became of a crack on each grid.

    Parameters
    ----------
    scatter : xarray.Dataset
        Of a study with a parameter `grid`.
    tip : str
    **chosen
        Values of the other parameters.
    """
    found = []
    for grid in scatter.grid.values:
        run = scatter.sel(grid=grid, **chosen)
        status = run.tip_status.sel(tip=tip).values
        word = TIP_STATUS[int(status[status >= 0][-1])]
        lost = RUN_STATUS[int(run.run_status)] in LOST and not word.startswith("arrived")
        path = analysis.tip_path(run, tip)
        found.append(Outcome(path, word, int(run.n_points.values[0]), lost))
    return found


def shares(found: list[Outcome], ending: Callable[[Outcome], str]) -> Mapping[str, int]:
    """Count the ends of cracks, the most frequent first."""
    return dict(Counter(map(ending, found)).most_common())


def told(counted: Mapping[str, int]) -> str:
    """Tell shares in words, such as "ends in a hole 7 of 10"."""
    total = sum(counted.values())
    return ", ".join(f"{ending}: {count} of {total}" for ending, count in counted.items())


def edge_ending(one: Outcome) -> str:
    """Where the edge crack in tension ends."""
    if one.status != "arrived_boundary":
        return "does not cross the plate"
    off = abs(one.path[-1, 1] - 500.0)
    return "within 2 mm of the middle" if off <= 2.0 else "more than 2 mm off the middle"


def range_of_angles(one: Outcome) -> tuple[float, float]:
    """Smallest and largest angle of the segments of a crack along x [deg]."""
    angles = segment_angles(one.path)
    return float(angles.min()), float(angles.max())


def shear_ending(one: Outcome) -> str:
    """How the crack under shear runs."""
    angles = segment_angles(one.path)
    crossed = "crosses" if one.status == "arrived_boundary" else "does not cross"
    flatter = "flattens" if abs(angles[-1]) < 0.75 * abs(angles[0]) else "does not flatten"
    return f"{crossed}, {flatter}"


def holes_ending(one: Outcome) -> str:
    """Where one of two cracks ends."""
    if one.lost:
        return LOST_WAY
    return {
        "arrived_hole": "in a hole",
        "arrived_crack": "at the other crack",
        "arrived_boundary": "at the edge of the plate",
        "stopped": "on the way",
    }.get(one.status, "still runs")


def beam_ending(one: Outcome) -> str:
    """Where the crack in the beam ends."""
    end = one.path[-1]
    for name, hole in (("bottom", BOTTOM), ("middle", MIDDLE), ("top", TOP)):
        gap = float(np.hypot(*(end - hole))) - HOLE
        if gap <= 0.05 * HOLE and one.status.startswith("arrived"):
            return f"in the {name} hole"
        if gap <= NEAR and one.status == "stopped" and not one.lost:
            return f"short of the {name} hole"
    if one.status == "arrived_boundary" or end[1] > 7.5 * INCH:
        return "past the holes"
    if one.lost:
        return LOST_WAY
    return "elsewhere"
