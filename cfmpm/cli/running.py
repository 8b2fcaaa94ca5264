"""The commands that solve: run and resume."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cfmpm.cli.app import (
    Output,
    Overrides,
    Overwrite,
    Quiet,
    SceneFile,
    Verbose,
    announce_size,
    app,
    log,
    log_shown,
    problems_placed,
    read_overrides,
    readable,
    told_as_damage,
    why_unwritable,
    writable,
)
from cfmpm.errors import Problem, SceneError, SolveError
from cfmpm.interruption import terminated_as_interrupted

if TYPE_CHECKING:
    from cfmpm.output.checkpoint import Start
    from cfmpm.output.record import Record
    from cfmpm.scene import Scene
    from cfmpm.state import State

    Announce = Callable[[str], None]
    Observe = Callable[[State, Record], None]


@app.command(short_help="Solve a scene.")
def run(
    scene_file: SceneFile,
    set_: Overrides = None,
    output: Output = None,
    overwrite: Overwrite = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Solve a scene; write history.nc, and fields if the scene asks for output.

    A run with several steps writes the history so far and a checkpoint after the first step, then
    at intervals such that this takes little of the run time, and when it is interrupted; `cfmpm
    resume` continues from there.

    After its first step a new run replaces a finished run in the same folder, including the figures
    and exports that are there by default. It does not replace a run that could be resumed.

    Example: cfmpm run configs/paper/single_edge_crack.yaml --set mesh.size=10
    """
    from cfmpm.output.run_folder import held, starting
    from cfmpm.scene import load_scene

    overrides = read_overrides(set_)
    scene = load_scene(scene_file, overrides)
    folder = writable(output, Path("results") / scene.name)
    with (
        held(folder),
        starting(folder, overwrite=overwrite),
        problems_placed(scene, scene_file, overrides),
    ):
        if not quiet:
            announce_size(scene)
        _solve(scene, folder, None, quiet=quiet, verbose=verbose)


@app.command(short_help="Resume a run that was interrupted.")
def resume(
    result: Annotated[
        Path, typer.Argument(metavar="DIR", readable=False, help="folder of the run")
    ],
    scene_file: Annotated[
        Path | None,
        typer.Argument(
            metavar="[SCENE.yaml]", readable=False, help="the scene, to check that it is the same"
        ),
    ] = None,
    set_: Overrides = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Resume a run that was interrupted; results equal those of an uninterrupted run bit by bit.

    Example: cfmpm resume results/plate_with_holes
    """
    from cfmpm.accessor import open_history
    from cfmpm.output.checkpoint import read_checkpoint
    from cfmpm.output.run_folder import CHECKPOINT, HISTORY, UNFINISHED, held, was_killed_at_start

    overrides = read_overrides(set_)
    if not readable(result).is_dir():
        raise SceneError([Problem("no such result; cfmpm run makes one", file=str(result))])
    checkpoint, unwritable = result / CHECKPOINT, why_unwritable(result)
    if unwritable and checkpoint.exists():
        reason = f"{unwritable}; copy it elsewhere, and resume the copy"
        raise SceneError([Problem(reason, file=str(result))])
    with nullcontext() if unwritable else held(result):
        start = read_checkpoint(checkpoint) if checkpoint.exists() else None
        if start is not None:
            _require_same_scene(result, start.record.scene, scene_file, overrides)
            with told_as_damage(checkpoint):
                _solve(start.record.scene, result, start, quiet=quiet, verbose=verbose)
            return
        if was_killed_at_start(result):
            reason = "the last run was killed before its first step: run the scene again"
            raise SceneError([Problem(reason, file=str(result))])
        history = open_history(result / HISTORY)
        if scene_file is not None or overrides:
            _require_same_scene(result, history.cfmpm.scene, scene_file, overrides)
        if history.attrs["run_status"] == UNFINISHED:
            reason = "is missing, so that the run cannot be resumed; run the scene again"
            raise SceneError([Problem(reason, file=str(checkpoint))])
        typer.echo(f"{result}: nothing to do, the run is finished; {history.attrs['ending']}")


def _require_same_scene(
    folder: Path, scene: Scene, scene_file: Path | None, overrides: dict[str, Any]
) -> None:
    """SceneError if a scene is not that of the run to be resumed."""
    from cfmpm.scene import changed_keys, effective_config, load_scene, scene_from_dict

    if scene_file is not None:
        other = load_scene(scene_file, overrides)
    elif overrides:
        other = scene_from_dict(effective_config(scene), f"scene of {folder}", overrides)
    else:
        return
    changed = changed_keys(scene, other)
    if changed:
        reason = f"differs from the scene of {folder} in {', '.join(changed)}: run it instead"
        raise SceneError([Problem(reason, file=str(scene_file or "--set"))])


def _solve(scene: Scene, folder: Path, start: Start | None, *, quiet: bool, verbose: bool) -> None:
    """Solve a scene from its first step or a checkpoint; write the result and print its summary."""
    from cfmpm import simulation
    from cfmpm.output import summary
    from cfmpm.output.run_folder import HISTORY
    from cfmpm.output.run_writer import RunWriter
    from cfmpm.output.warnings.of_scene import ways_on

    writer = RunWriter(folder, start)
    with (
        log_shown(verbose and not quiet),
        _progress(scene, visible=not (quiet or verbose)) as (announce, advance),
        terminated_as_interrupted(),
    ):

        def observe(state: State, record: Record) -> None:
            writer.observe(state, record)
            advance(state, record)

        try:
            result = simulation.run(scene, announce, observe, start)
            written = writer.finish(result)
        except (Exception, KeyboardInterrupt) as error:
            writer.write(str(error) or "interrupted")
            if writer.steps:
                error.add_note(
                    f"{folder / HISTORY} has {writer.steps} steps; cfmpm resume {folder} "
                    "continues from there"
                )
            elif start is None and (folder / HISTORY).exists():
                error.add_note(f"no step was solved; {folder} is unchanged")
            raise
    if not quiet:
        typer.echo(summary.of_run(result, written))
    status, ending = (str(result.history.attrs[name]) for name in ("run_status", "ending"))
    if status == "unsolvable":
        raise SolveError(f"{ending}. The steps before are in {folder / HISTORY}")
    if status == "unstable":
        raise SolveError(
            f"{ending}. The last stable state is in {folder / HISTORY}. "
            + " ".join(ways_on(scene, result.balance))
        )


@contextmanager
def _progress(scene: Scene, *, visible: bool) -> Iterator[tuple[Announce, Observe]]:
    """Functions that show each phase when it begins and each state when it is solved.

    A terminal shows a progress bar, for growth a count of increments; otherwise they are logged.
    """
    if not (visible and sys.stderr.isatty()):
        yield log_phase, _log_step
        return
    from tqdm import tqdm

    from cfmpm.state import PHASES

    growing = scene.growth is not None
    form = "{desc:12} {bar:30} {elapsed}" if not growing else "{desc:12} {elapsed}  {postfix}"
    total = None if growing else len(PHASES)
    with tqdm(total=total, leave=False, bar_format=form) as bar:

        def announce(phase: str) -> None:
            bar.set_description_str(phase, refresh=False)
            if not growing:
                bar.n = PHASES.index(phase)
            bar.refresh()

        def advance(state: State, record: Record) -> None:
            bar.set_postfix_str(_step_text(record))

        yield announce, advance


def log_phase(phase: str) -> None:
    log.info("phase: %s", phase)


def _log_step(state: State, record: Record) -> None:
    log.info(_step_text(record))


def _step_text(record: Record) -> str:
    """A short description of the last step."""
    step = record.steps[-1]
    lengths = " and ".join(
        f"{length:.5g}" for length in dict.fromkeys(step.values["crack_length"].tolist())
    )
    return (
        f"increment {len(record.steps) - 1}, crack length {lengths} mm, "
        f"load factor {step.load_factor:.4g}"
    )
