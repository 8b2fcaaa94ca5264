"""The command line: run, resume, check, plot, export, study, schema.

All that is heavy (numba, gmsh, xarray, matplotlib) is imported within the commands, so that
``cfmpm --help`` answers at once and a run without pictures never loads matplotlib.
"""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup

from cfmpm import __version__
from cfmpm.errors import MeshError, Problem, SceneError, SolveError
from cfmpm.interruption import terminated_as_interrupted

if TYPE_CHECKING:
    from cfmpm.record import Record
    from cfmpm.scene import Scene
    from cfmpm.simulation import Start, State
    from cfmpm.study.member import Outcome

    Announce = Callable[[str], None]
    Observe = Callable[[State, Record], None]

log = logging.getLogger(__name__)

WRONG_INPUT, FAILED, INTERRUPTED = 2, 1, 130
# Seconds between two lines that tell how far a study has come, where there is no terminal.
LOGGED_EVERY = 10.0
# So many take about ten seconds to make.
MANY_TRIANGLES = 1e5


class _Commands(TyperGroup):
    """Commands whose errors end in a message and an exit status, never in a traceback."""

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except SceneError as error:
            _fail(str(error), WRONG_INPUT)
        except (MeshError, SolveError) as error:
            _fail(f"cfmpm: {error}", FAILED)
        except BrokenPipeError:  # of `cfmpm schema | head`
            raise
        except OSError as error:
            place = f" {error.filename}" if error.filename else ""
            _fail(f"cfmpm: cannot write{place}: {error.strerror or error}", FAILED)
        except MemoryError:
            _fail("cfmpm: not enough memory; take a larger mesh.size, or solver: amg", FAILED)
        except KeyboardInterrupt:
            _fail("cfmpm: interrupted", INTERRUPTED)


app = typer.Typer(
    cls=_Commands,
    help="Crack growth by configurational force in the material point method.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

SceneFile = Annotated[Path, typer.Argument(metavar="SCENE.yaml", help="the scene")]
Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="replace a value, such as mesh.size=5"),
]
Output = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="folder to write to; default: results/<name of the scene>"),
]
Overwrite = Annotated[
    bool, typer.Option("--overwrite", help="take the place of a run that could still go on")
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="print errors only")]
Verbose = Annotated[bool, typer.Option("--verbose", "-v", help="log each phase")]


class Format(StrEnum):
    """What results can be written as."""

    vtu = "vtu"


class Kind(StrEnum):
    """What files describe."""

    scene = "scene"
    study = "study"


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"cfmpm {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option(
            "--version", help="print the version and end", callback=_print_version, is_eager=True
        ),
    ] = False,
) -> None:
    pass


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

    While cracks grow, the history so far and a checkpoint are written after the first step, from
    then on as often as that takes little of the time, and when the run breaks off; `cfmpm resume`
    goes on from there.

    As soon as it has its first step, a new run takes the place of one that has ended in the same
    folder, with all that was drawn and exported there by default. It does not take the place of one
    that could still go on.

    Example: cfmpm run configs/paper/single_edge_crack.yaml --set mesh.size=10
    """
    from cfmpm.folder import held, starting
    from cfmpm.scene import load_scene

    overrides = _overrides(set_)
    scene = load_scene(scene_file, overrides)
    folder = output or Path("results") / scene.name
    with held(folder), starting(folder, overwrite=overwrite), _placed(scene, scene_file, overrides):
        if not quiet:
            _announce_size(scene)
        _solve(scene, folder, None, quiet=quiet, verbose=verbose)


@app.command(short_help="Go on with a run that was broken off.")
def resume(
    result: Annotated[Path, typer.Argument(metavar="DIR", help="folder of the run")],
    scene_file: Annotated[
        Path | None,
        typer.Argument(metavar="[SCENE.yaml]", help="the scene, to make sure that it is the same"),
    ] = None,
    set_: Overrides = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Go on with a run that was broken off: the end is that of a run in one go, bit by bit.

    Example: cfmpm resume results/plate_with_holes
    """
    from cfmpm.accessor import open_history
    from cfmpm.checkpoint import read_checkpoint
    from cfmpm.folder import CHECKPOINT, HISTORY, UNFINISHED, held, was_killed_at_start

    overrides = _overrides(set_)
    if not result.is_dir():
        raise SceneError([Problem("no such result; cfmpm run makes one", file=str(result))])
    with held(result):
        checkpoint = result / CHECKPOINT
        start = read_checkpoint(checkpoint) if checkpoint.exists() else None
        if start is not None:
            _require_same_scene(result, start.record.scene, scene_file, overrides)
            _solve(start.record.scene, result, start, quiet=quiet, verbose=verbose)
            return
        if was_killed_at_start(result):
            reason = "the last run was killed before its first step: run the scene again"
            raise SceneError([Problem(reason, file=str(result))])
        history = open_history(result / HISTORY)
        if scene_file is not None or overrides:
            _require_same_scene(result, history.cfmpm.scene, scene_file, overrides)
        ending = str(history.attrs["ending"])
        if ending.startswith(UNFINISHED):
            reason = "is not there: nothing to go on from; run the scene again"
            raise SceneError([Problem(reason, file=str(checkpoint))])
        typer.echo(f"{result}: nothing to do, the run has ended; {ending}")


def _require_same_scene(
    folder: Path, scene: Scene, scene_file: Path | None, overrides: dict[str, Any]
) -> None:
    """Refuse to go on with another scene than that of the run, which a run would have to begin."""
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
    """Solve a scene from its beginning or a later start, and write and say what was found."""
    from cfmpm import remarks, simulation, summary
    from cfmpm.folder import HISTORY
    from cfmpm.keeper import Keeper

    keeper = Keeper(folder, start)
    with (
        _log_shown(verbose and not quiet),
        _progress(scene, visible=not (quiet or verbose)) as (announce, advance),
        terminated_as_interrupted(),
    ):

        def observe(state: State, record: Record) -> None:
            keeper.observe(state, record)
            advance(state, record)

        try:
            result = simulation.run(scene, announce, observe, start)
            written = keeper.finish(result)
        except (Exception, KeyboardInterrupt) as error:
            keeper.write(str(error) or "interrupted")
            if keeper.steps:
                typer.echo(
                    f"{folder / HISTORY} holds {keeper.steps} steps; cfmpm resume {folder} goes on "
                    "from there",
                    err=True,
                )
            elif start is None:
                typer.echo(f"no step was found; {folder} is as it was before this run", err=True)
            raise
    if not quiet:
        typer.echo(summary.of_run(result, written))
    ending = str(result.history.attrs["ending"])
    if ending.startswith(simulation.UNSOLVABLE):
        raise SolveError(f"{ending}. What was found before is in {folder / HISTORY}")
    if ending.startswith(simulation.UNSTABLE):
        raise SolveError(
            f"{ending}. The last stable state is in {folder / HISTORY}. "
            + " ".join(remarks.ways_on(scene, result.balance))
        )


@app.command(short_help="Mesh, load and draw a scene without solving it.")
def check(scene_file: SceneFile, set_: Overrides = None, output: Output = None) -> None:
    """Mesh a scene, apply its loads, say what a run would do, and draw it; solve nothing.

    Example: cfmpm check configs/examples/general.yaml --output /tmp/look
    """
    from cfmpm import body, remarks, solvers, summary
    from cfmpm.plotting.files import save_scene
    from cfmpm.scene import load_scene

    overrides = _overrides(set_)
    scene = load_scene(scene_file, overrides)
    _announce_size(scene)
    with _placed(scene, scene_file, overrides):
        start = body.build(scene)
    solver = solvers.select(int((~start.loading.prescribed).sum()), scene.solver).name
    finite = start.scene.kinematics == "finite"
    left_out = remarks.left_out(start.scene, bool(start.grid.tips), finite=finite)
    radii = [max(domain.radii) for domain in start.tip_domains]
    folder = output or Path("results") / scene.name
    path = save_scene(folder, start.scene, start.grid, start.loading, radii)
    typer.echo(summary.of_check(start, solver, left_out, path))


@app.command(short_help="Draw a result.")
def plot(
    result: Annotated[
        Path, typer.Argument(metavar="RESULT", help="folder of a run, or its history.nc")
    ],
    output: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="folder to write to; default: that of the result"),
    ] = None,
) -> None:
    """Draw a result: scene.png, deformed.png, and for each tip mesh_<tip>.png, cf_<tip>.png.

    With several domain radii also radii_<tip>.png; with steps at several loads
    force_<part>_<axis>.png, and steps_<tip>.png or, of growth, load.png. Of growth besides
    paths.png, cf.png, factors.png, angles.png, energy.png; of fatigue cycles.png; and, with
    output.every, growth.gif.

    Without fields.nc the scene is solved again, from the configuration stored in history.nc; where
    cracks grew, deformed.png and cf_<tip>.png are then left out.

    Example: cfmpm plot results/single_edge_crack
    """
    from cfmpm import body, simulation
    from cfmpm.accessor import History, open_history, read_result
    from cfmpm.fields import build_fields
    from cfmpm.folder import FIELDS, HISTORY, INDEX
    from cfmpm.plotting import animate_growth, files

    source = result / HISTORY if result.is_dir() else result
    history = open_history(source)
    scene = History(history).scene
    folder = output or source.parent
    fields_file = source.parent / FIELDS
    fields = read_result(fields_file, "face_nodes") if fields_file.exists() else None
    if fields is not None and fields.attrs["config_hash"] != history.attrs["config_hash"]:
        typer.echo(f"{fields_file} belongs to another run: not used", err=True)
        fields = None
    if fields is None and scene.growth is None:
        typer.echo(f"no fields of this run: solving {scene.name} again", err=True)
        solved = simulation.run(scene, _log_phase)
        fields, state = build_fields(solved), solved.body
    else:
        state = body.build(scene)

    radii = [max(domain.radii) for domain in state.tip_domains]
    written = [files.save_scene(folder, state.scene, state.grid, state.loading, radii)]
    written += files.save_tip_points(folder, state) + files.save_radii(folder, history)
    written += files.save_steps(folder, history)
    if scene.growth is not None:
        written += files.save_growth(folder, history, state.scene, state.grid)
        if (source.parent / INDEX).exists():
            try:
                written.append(animate_growth(source.parent, folder / "growth.gif"))
            except SceneError as error:  # the other pictures are none the worse
                typer.echo(f"no film: {error}", err=True)
    if fields is None:
        typer.echo("no fields of the end of this run: output.fields: true keeps them", err=True)
    else:
        written.append(files.save_deformed(folder, fields))
        written += files.save_tip_forces(folder, fields, history)
    for path in written:
        typer.echo(path)


@app.command(short_help="Write a result for ParaView.")
def export(
    result: Annotated[Path, typer.Argument(metavar="DIR", help="folder of a run")],
    format_: Annotated[
        Format, typer.Option("--format", help="vtu: VTU files, and PVD files over the steps")
    ] = Format.vtu,
    output: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="folder to write to; default: vtu in that of the result"),
    ] = None,
) -> None:
    """Write grid, material points and cracks of a run with fields for ParaView.

    Example: cfmpm export results/plate_with_holes
    """
    from cfmpm.export import export_vtu

    try:
        written = export_vtu(result, output or result / format_.value)
    except ImportError:
        _fail("cfmpm: export needs pyvista: pip install 'cfmpm[export]'", FAILED)
    for path in written:
        typer.echo(path)


@app.command(short_help="Solve a scene for many values of its keys.")
def study(
    study_file: Annotated[Path, typer.Argument(metavar="STUDY.yaml", help="the study")],
    workers: Annotated[
        int | None,
        typer.Option(min=1, help="processes, each on one thread; default: one for each core"),
    ] = None,
    check_: Annotated[bool, typer.Option("--check", help="list the members; solve none")] = False,
    output: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="folder to write to; default: results/<name of study>"),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Solve a scene for many values of its keys; write one dataset, study.nc.

    Nothing runs before the scene of every member has been checked. Members that fail, or become
    unstable, are marked in the dataset. What has been solved is kept in the folder members and not
    solved again, after a kill, too: the same command goes on.

    Example: cfmpm study configs/studies/crack_length.yaml
    """
    from cfmpm.folder import held
    from cfmpm.results import remove_asides, write_dataset
    from cfmpm.study import summary
    from cfmpm.study.collecting import collect
    from cfmpm.study.reading import load_study
    from cfmpm.study.running import run_members, usable_cores
    from cfmpm.study.store import DATASET, MEMBERS, Store

    plan = load_study(study_file)
    if check_:
        typer.echo(summary.of_plan(plan))
        return
    folder = output or Path("results") / plan.study.name
    keys = {one.key for one in plan.members}
    store = Store(folder / MEMBERS)
    with held(folder):
        remove_asides(folder, DATASET)
        store.tidy()
        outcomes = store.read(keys)
        known = len(outcomes)
        try:
            with (
                _log_shown(not quiet),
                _counted(len(keys), known, visible=not quiet) as count,
                terminated_as_interrupted(),
            ):
                run_members(plan.members, outcomes, store, workers or usable_cores(), count)
        except KeyboardInterrupt:
            kept = f"{len(outcomes)} of {len(keys)} members are kept"
            typer.echo(f"{kept}; the same command goes on", err=True)
            raise
        write_dataset(collect(plan, outcomes), folder / DATASET)
    if not quiet:
        typer.echo(summary.of_study(plan, outcomes, known, folder / DATASET))
    if not any(one.status == "done" for one in outcomes.values()):
        _fail(f"cfmpm: no member of {plan.study.name} came to its end", FAILED)


@app.command()
def schema(
    kind: Annotated[Kind, typer.Argument(help="which files are described")] = Kind.scene,
) -> None:
    """Print the JSON schema of scene or study files, for editors.

    Example: cfmpm schema > schema.json
    """
    from cfmpm.scene.model import Scene
    from cfmpm.scene.schema import schema_text
    from cfmpm.study.model import Study

    typer.echo(schema_text(Scene if kind is Kind.scene else Study), nl=False)


def main() -> None:
    """Run the command line."""
    app(prog_name="cfmpm")


def _fail(message: str, status: int) -> NoReturn:
    typer.echo(message, err=True)
    raise typer.Exit(status)


def _overrides(texts: list[str] | None) -> dict[str, Any]:
    """Values by key, each given once; all that is wrong with the texts is reported at once."""
    from cfmpm.scene import parse_override

    values: dict[str, Any] = {}
    problems: list[Problem] = []
    for text in texts or []:
        try:
            key, value = parse_override(text)
        except SceneError as error:
            problems += error.problems
            continue
        if key in values:
            problems.append(Problem("given twice", file=f"override {key}"))
        values[key] = value
    if problems:
        raise SceneError(problems)
    return values


@contextmanager
def _log_shown(wanted: bool) -> Iterator[None]:
    """Show what the package logs on stderr, as long as the ``with`` block runs."""
    if not wanted:
        yield
        return
    package, handler = logging.getLogger("cfmpm"), logging.StreamHandler()
    level = package.level
    package.addHandler(handler)
    package.setLevel(logging.INFO)
    try:
        yield
    finally:
        package.setLevel(level)
        package.removeHandler(handler)


@contextmanager
def _progress(scene: Scene, *, visible: bool) -> Iterator[tuple[Announce, Observe]]:
    """Functions that show each phase as it begins and each state as it is found.

    On a terminal as a bar, which for growth counts increments and has no end; else in the log.
    """
    if not (visible and sys.stderr.isatty()):
        yield _log_phase, _log_step
        return
    from tqdm import tqdm

    from cfmpm.simulation import PHASES

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


@contextmanager
def _counted(total: int, known: int, *, visible: bool) -> Iterator[Callable[[Outcome], None]]:
    """A function that counts members as they come; on a terminal as a bar, else in the log."""
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


@contextmanager
def _placed(scene: Scene, scene_file: Path, overrides: dict[str, Any]) -> Iterator[None]:
    """Give problems that turn up on the grid their line in the scene file."""
    from cfmpm.scene import placed

    try:
        yield
    except SceneError as error:
        raise placed(error, scene, scene_file, overrides) from None


def _announce_size(scene: Scene) -> None:
    """Say how many triangles are coming, where they take their time."""
    from cfmpm.meshing import expected_triangles

    expected = expected_triangles(scene)
    if expected is not None and expected > MANY_TRIANGLES:
        typer.echo(
            f"about {expected:.2g} triangles are being made, which takes a while; a larger "
            "mesh.size makes fewer",
            err=True,
        )


def _log_phase(phase: str) -> None:
    log.info("phase: %s", phase)


def _log_step(state: State, record: Record) -> None:
    log.info(_step_text(record))


def _step_text(record: Record) -> str:
    """The last step in a few words."""
    step = record.steps[-1]
    lengths = " and ".join(
        f"{length:.5g}" for length in dict.fromkeys(step.values["crack_length"].tolist())
    )
    return (
        f"increment {len(record.steps) - 1}, crack length {lengths} mm, "
        f"load factor {step.load_factor:.4g}"
    )
