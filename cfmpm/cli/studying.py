"""The command study: parameter studies."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cfmpm.cli.app import (
    FAILED,
    Quiet,
    app,
    fail,
    log,
    log_shown,
    writable,
)
from cfmpm.interruption import terminated_as_interrupted

if TYPE_CHECKING:
    from cfmpm.output.record import Record
    from cfmpm.state import State
    from cfmpm.study.member import Outcome

    Announce = Callable[[str], None]
    Observe = Callable[[State, Record], None]

# Seconds between two lines on the progress of a study, without a terminal.
LOGGED_EVERY = 10.0


@app.command(short_help="Solve a scene for many values of its keys.")
def study(
    study_file: Annotated[
        Path, typer.Argument(metavar="STUDY.yaml", readable=False, help="the study")
    ],
    workers: Annotated[
        int | None,
        typer.Option(min=1, help="processes, each on one thread; default: one for each core"),
    ] = None,
    check_: Annotated[bool, typer.Option("--check", help="list the members; solve none")] = False,
    output: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            readable=False,
            help="folder to write to; default: results/<name of study>",
        ),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Solve a scene for many values of its keys; write one dataset, study.nc.

    The scenes of all members are checked before any is solved. Members that fail, or become
    unstable, are marked in the dataset. Solved members are kept in the folder members and are not
    solved again: after an interruption the same command continues the study.

    Example: cfmpm study configs/studies/crack_length.yaml
    """
    from cfmpm.output.files import remove_asides, write_dataset
    from cfmpm.output.run_folder import held, require_own
    from cfmpm.study import summary
    from cfmpm.study.collecting import collect
    from cfmpm.study.reading import load_study
    from cfmpm.study.running import run_members, usable_cores
    from cfmpm.study.store import DATASET, MEMBERS, Store

    with log_shown(not quiet):
        plan = load_study(study_file)
    if check_:
        typer.echo(summary.of_plan(plan))
        return
    folder = writable(output, Path("results") / plan.study.name)
    keys = {one.key for one in plan.members}
    store = Store(require_own(folder, MEMBERS))
    with held(folder):
        remove_asides(folder, DATASET)
        store.tidy()
        outcomes = store.read(keys)
        known = len(outcomes)
        try:
            with (
                log_shown(not quiet),
                _counted(len(keys), known, visible=not quiet) as count,
                terminated_as_interrupted(),
            ):
                run_members(plan.members, outcomes, store, workers or usable_cores(), count)
        except KeyboardInterrupt as error:
            kept = f"{len(outcomes)} of {len(keys)} members are kept"
            error.add_note(f"{kept}; the same command continues the study")
            raise
        write_dataset(collect(plan, outcomes), folder / DATASET)
    if not quiet:
        typer.echo(summary.of_study(plan, outcomes, known, folder / DATASET))
    if not any(one.status == "done" for one in outcomes.values()):
        fail(f"cfmpm: no member of {plan.study.name} was completed", FAILED)


@contextmanager
def _counted(total: int, known: int, *, visible: bool) -> Iterator[Callable[[Outcome], None]]:
    """A function that counts finished members, in a progress bar on a terminal, else in the log."""
    if not (visible and sys.stderr.isatty()):
        found, due = known, time.monotonic() + LOGGED_EVERY

        def tell(outcome: Outcome) -> None:
            nonlocal found, due
            found += 1
            if time.monotonic() >= due:
                due = time.monotonic() + LOGGED_EVERY
                log.info("%d of %d members", found, total)

        yield tell
        return
    from tqdm import tqdm

    not_done = 0
    with tqdm(total=total, initial=known, leave=False, unit="member") as bar:

        def count(outcome: Outcome) -> None:
            nonlocal not_done
            not_done += outcome.status != "done"
            if not_done:
                bar.set_postfix_str(f"{not_done} failed or unstable", refresh=False)
            bar.update()

        yield count
