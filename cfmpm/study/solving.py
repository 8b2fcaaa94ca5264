"""Python interface to solve studies in one call, without files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import xarray as xr

from cfmpm.study.collecting import collect
from cfmpm.study.member import Outcome
from cfmpm.study.reading import Plan
from cfmpm.study.running import run_members, usable_cores
from cfmpm.study.store import Store


def solve_studies(
    plans: Sequence[Plan],
    workers: int | None = None,
    observe: Callable[[Outcome], None] = lambda outcome: None,
) -> list[xr.Dataset]:
    """Solve all members of some studies in the same processes, and return a dataset of each.

    Parameters
    ----------
    plans : sequence of Plan
        From `load_study` or `study_from_dict`.
    workers : int, optional
        Number of processes, each on one thread; default: one for each core. With one, no other
        member affects the times of a member.
    observe : callable, optional
        Called with each outcome.

    Returns
    -------
    list of xarray.Dataset
        As in ``study.nc`` of each.
    """
    outcomes: dict[str, Outcome] = {}
    with TemporaryDirectory() as folder:
        members = [member for plan in plans for member in plan.members]
        run_members(members, outcomes, Store(Path(folder)), workers or usable_cores(), observe)
    return [collect(plan, outcomes) for plan in plans]


def solve_study(plan: Plan, workers: int | None = None) -> xr.Dataset:
    """Solve one study; as `solve_studies`."""
    return solve_studies([plan], workers)[0]
