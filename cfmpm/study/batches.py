"""A study in batches, each a job of its own with a file of its own, for a workflow to run."""

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
    """Members of each batch, by their numbers.

    Parameters
    ----------
    plan : Plan
    """
    firsts = range(0, expansion.count(plan.axes), plan.study.batch)
    return [batch(plan, number) for number in range(len(firsts))]


def batch(plan: Plan, number: int) -> range:
    """Members of one batch, by their numbers.

    Parameters
    ----------
    plan : Plan
    number : int
        Of the batch, from 0.

    Raises
    ------
    IndexError
        Where there is no such batch.
    """
    size, count = plan.study.batch, expansion.count(plan.axes)
    first = range(0, count, size)[number]
    return range(first, min(first + size, count))


def write_batch(
    study_file: str | Path, members: range, workers: int, path: str | Path, *, last: bool
) -> None:
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
    last : bool
        Whether members that failed for a reason that lies in the machine are written too, marked so
        and to be solved by a later call, rather than tried once more.

    Raises
    ------
    SolveError
        Where there are such members and it is not the last attempt; the others are kept.
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
    """Gather all batches of a study into its dataset.

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
        Where `cfmpm study` is running in the same folder.
    SolveError
        Where a batch has been solved by another version of cfmpm or of what it uses.
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
