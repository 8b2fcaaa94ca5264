"""A study in batches for a workflow, with one job and one file for each."""

from __future__ import annotations

import logging
from collections.abc import Iterable
from pathlib import Path

from cfmpm.errors import SolveError
from cfmpm.output.files import remove_asides, write_dataset
from cfmpm.output.run_folder import held
from cfmpm.study import expansion
from cfmpm.study.collecting import collect
from cfmpm.study.member import Outcome
from cfmpm.study.reading import Plan, load_study
from cfmpm.study.running import run_members
from cfmpm.study.store import Store, read_losses, read_part, read_sound, write_part

log = logging.getLogger(__name__)


def batches(plan: Plan) -> list[range]:
    """Return the numbers of the members of each batch.

    Parameters
    ----------
    plan : Plan
    """
    firsts = range(0, expansion.count(plan.axes), plan.study.batch)
    return [batch(plan, number) for number in range(len(firsts))]


def batch(plan: Plan, number: int) -> range:
    """Return the numbers of the members of one batch.

    Parameters
    ----------
    plan : Plan
    number : int
        Number of the batch, from 0.

    Raises
    ------
    IndexError
        If there is no such batch.
    """
    size, count = plan.study.batch, expansion.count(plan.axes)
    first = range(0, count, size)[number]
    return range(first, min(first + size, count))


def write_batch(
    study_file: str | Path, members: range, workers: int, path: str | Path, *, last: bool
) -> None:
    """Solve the unknown members of one batch, and write all its members.

    Parameters
    ----------
    study_file : Path
    members : range
        Numbers of the members.
    workers : int
        Number of processes.
    path : Path
        An .npz file. Members in other files of the same folder are known. Members that were in the
        file before are kept, for a study that returns to earlier values.
    last : bool
        Whether this is the last attempt: members that failed because of the machine are then
        written too, marked for a later call.

    Raises
    ------
    SolveError
        If there are such members and this is not the last attempt; the others are kept.
    """
    path = Path(path)
    plan = load_study(study_file, members)
    store = Store(path.parent, path.stem)
    store.tidy()
    keys = {one.key for one in plan.members}
    outcomes = store.read(keys)
    run_members(plan.members, outcomes, store, workers)
    lost = [one for one in outcomes.values() if not one.lasting]
    if lost:
        told = f"{len(lost)} of {len(keys)} members failed, the first: {lost[0].reason}"
        if not last:
            raise SolveError(told)
        log.warning(told)
    parts = store.parts()
    before = {one.key: one for part in (path, *parts) for one in read_sound(part)}
    losses = read_losses(path) + bool(lost)
    write_part((before | outcomes).values(), path, losses)
    for part in parts:
        part.unlink(missing_ok=True)


def write_study(study_file: str | Path, parts: Iterable[str | Path], path: str | Path) -> None:
    """Collect all batches of a study in its dataset.

    Parameters
    ----------
    study_file : Path
    parts : iterable of Path
        From `write_batch`.
    path : Path
        A netCDF file.

    Raises
    ------
    SceneError
        If `cfmpm study` is running in the same folder.
    SolveError
        If a batch was solved by another version of cfmpm or of its dependencies.
    """
    path = Path(path)
    plan = load_study(study_file)
    keys = {one.key for one in plan.members}
    outcomes: dict[str, Outcome] = {}
    for part in parts:
        outcomes |= {one.key: one for one in read_part(Path(part), keys)}
    missing = len(keys) - len(outcomes)
    if missing:
        raise SolveError(
            f"{missing} of {len(keys)} members are in no batch: were these solved where other "
            "versions are installed?"
        )
    with held(path.parent):
        remove_asides(path.parent, path.name)
        write_dataset(collect(plan, outcomes), path)
