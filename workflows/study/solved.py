"""Studies solved within a job, for the datasets of the paper and the measurements."""

from __future__ import annotations

import logging
from collections.abc import Sequence

import xarray as xr

from cfmpm.errors import SolveError
from cfmpm.study.layout import STATUS
from cfmpm.study.member import Outcome
from cfmpm.study.reading import Plan, label
from cfmpm.study.solving import solve_studies

log = logging.getLogger(__name__)


def solved(plans: Sequence[Plan], workers: int = 1) -> list[xr.Dataset]:
    """Solve studies; the log tells of each member as it comes.

    Parameters
    ----------
    plans : sequence of Plan
    workers : int
        Processes.

    Returns
    -------
    list of xarray.Dataset
        As `solve_studies` does; members may have failed.
    """
    names = {
        one.key: f"{plan.study.name}, {label(plan.axes, one.index)}"
        for plan in plans
        for one in plan.members
    }

    def tell(outcome: Outcome) -> None:
        ended = outcome.reason or outcome.texts["ending"]
        log.info("%s: %.2f s, %s", names[outcome.key], outcome.cpu_seconds, ended)

    return solve_studies(plans, workers, tell)


def without_failures(dataset: xr.Dataset) -> xr.Dataset:
    """Pass on the dataset of a study.

    Raises
    ------
    SolveError
        Where a member has failed.
    """
    failed = (dataset.status == STATUS.index("failed")).values
    if failed.any():
        raise SolveError(
            f"{failed.sum()} members failed, the first: {dataset.reason.values[failed][0]}"
        )
    return dataset
