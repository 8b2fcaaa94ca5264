"""A study in batches, each a job of its own with a file of its own, for a workflow to run."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from cfmpm.errors import SolveError
from cfmpm.results import write_dataset
from cfmpm.study import expansion
from cfmpm.study.collecting import collect
from cfmpm.study.member import Outcome
from cfmpm.study.reading import Plan, load_study
from cfmpm.study.running import run_members
from cfmpm.study.store import Store, read_part, write_part


def batches(plan: Plan) -> list[range]:
    """Members of each batch, by their numbers.

    Parameters
    ----------
    plan : Plan
    """
    size, count = plan.study.batch, expansion.count(plan.axes)
    return [range(first, min(first + size, count)) for first in range(0, count, size)]


def write_batch(study_file: str | Path, members: range, workers: int, path: str | Path) -> None:
    """Solve the members of one batch that are not known, and write all of them.

    Parameters
    ----------
    study_file : Path
    members : range
        By their numbers.
    workers : int
        Processes.
    path : Path
        An .npz file. Other members in the same folder are known; those that were in the file before
        stay in it, so that a study that goes back to earlier values finds them.

    Raises
    ------
    SolveError
        Where members failed for a reason that lies in the machine; the others are kept.
    """
    path = Path(path)
    plan = load_study(study_file, members)
    store = Store(path.parent)
    keys = {one.key for one in plan.members}
    outcomes = store.read(keys)
    run_members(plan.members, outcomes, store, workers)
    lost = [one for one in outcomes.values() if not one.lasting]
    if lost:
        raise SolveError(f"{len(lost)} of {len(keys)} members failed, the first: {lost[0].reason}")
    before = read_part(path) if path.exists() else []
    write_part([*outcomes.values(), *(one for one in before if one.key not in keys)], path)
    store.discard()


def write_study(study_file: str | Path, parts: Iterable[str | Path], path: str | Path) -> None:
    """Gather all batches of a study into its dataset.

    Parameters
    ----------
    study_file : Path
    parts : iterable of Path
        From `write_batch`.
    path : Path
        A netCDF file.
    """
    plan = load_study(study_file)
    keys = {one.key for one in plan.members}
    outcomes: dict[str, Outcome] = {}
    for part in parts:
        outcomes |= {one.key: one for one in read_part(Path(part), keys)}
    write_dataset(collect(plan, outcomes), Path(path))
