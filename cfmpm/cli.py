"""The command line: run, check, plot, schema.

All that is heavy (numba, gmsh, xarray, matplotlib) is imported within the commands, so that
``cfmpm --help`` answers at once and a run without pictures never loads matplotlib.
"""

from __future__ import annotations

import json
import logging
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup

from cfmpm import __version__
from cfmpm.errors import MeshError, Problem, SceneError, SolveError

if TYPE_CHECKING:
    import xarray as xr

    from cfmpm.scene import Scene

log = logging.getLogger(__name__)

WRONG_INPUT, FAILED, INTERRUPTED = 2, 1, 130


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
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="print errors only")] = False,
    verbose: Annotated[bool, typer.Option("--verbose", "-v", help="log each phase")] = False,
) -> None:
    """Solve a scene; write history.nc, and fields.nc if the scene has output.fields: true.

    While cracks grow, the history so far is written every few seconds, and when the run breaks off.

    Example: cfmpm run configs/paper/single_edge_crack.yaml --set mesh.size=10
    """
    from cfmpm import simulation, summary
    from cfmpm.keeper import Keeper
    from cfmpm.results import write_dataset
    from cfmpm.scene import load_scene

    overrides = _overrides(set_)
    scene = load_scene(scene_file, overrides)
    folder = output or Path("results") / scene.name
    folder.mkdir(parents=True, exist_ok=True)
    phases = simulation.PHASES if scene.growth is None else simulation.GROWTH_PHASES
    keeper = Keeper(folder / "history.nc")
    with (
        _log_shown(verbose and not quiet),
        _progress(phases, visible=not (quiet or verbose)) as announce,
        _placed(scene, scene_file, overrides),
    ):
        try:
            result = simulation.run(scene, announce, keeper.observe)
        except (Exception, KeyboardInterrupt):
            keeper.write("broken off: see the message of the run")
            raise
    written = [folder / "history.nc"]
    write_dataset(result.history, written[0])
    if scene.output.fields:
        from cfmpm.fields import build_fields

        written.append(folder / "fields.nc")
        write_dataset(build_fields(result), written[1])
    if not quiet:
        typer.echo(summary.of_run(result, written))


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
    with _placed(scene, scene_file, overrides):
        start = body.build(scene)
    solver = solvers.select(int((~start.loading.prescribed).sum()), scene.solver).name
    left_out = remarks.left_out(start.scene, bool(start.grid.tips))
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
    """Draw a result: scene.png, deformed.png and cf_<tip>.png for each tip; paths.png of growth.

    Without fields.nc the scene is solved again, from the configuration stored in history.nc; where
    cracks grew, deformed.png and cf_<tip>.png are then left out.

    Example: cfmpm plot results/single_edge_crack
    """
    from cfmpm import body, simulation
    from cfmpm.fields import build_fields
    from cfmpm.plotting import files
    from cfmpm.scene import scene_from_dict

    source = result / "history.nc" if result.is_dir() else result
    history = _read_result(source, "domain_radius")
    scene = scene_from_dict(_stored_config(history, source), f"{source}: config")
    folder = output or source.parent
    fields_file = source.parent / "fields.nc"
    fields = _read_result(fields_file, "face_nodes") if fields_file.exists() else None
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
    if scene.growth is not None:
        written += files.save_growth(folder, history, scene)
    if fields is None:
        typer.echo("no fields of this run: output.fields: true keeps those of its end", err=True)
    else:
        written.append(files.save_deformed(folder, fields))
        written += files.save_tip_forces(folder, fields, history)
    for path in written:
        typer.echo(path)


@app.command()
def schema() -> None:
    """Print the JSON schema of scene files, for editors.

    Example: cfmpm schema > schema.json
    """
    from cfmpm.scene.schema import schema_text

    typer.echo(schema_text(), nl=False)


def main() -> None:
    """Run the command line."""
    app(prog_name="cfmpm")


def _fail(message: str, status: int) -> NoReturn:
    typer.echo(message, err=True)
    raise typer.Exit(status)


def _overrides(texts: list[str] | None) -> dict[str, Any]:
    """Values by key; all texts that are not KEY=VALUE are reported at once."""
    from cfmpm.scene import parse_override

    values: dict[str, Any] = {}
    problems: list[Problem] = []
    for text in texts or []:
        try:
            key, values[key] = parse_override(text)
        except SceneError as error:
            problems += error.problems
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
def _progress(phases: tuple[str, ...], *, visible: bool) -> Iterator[Callable[[str], None]]:
    """A function that shows each phase as it begins: on a terminal as a bar, else in the log."""
    if not (visible and sys.stderr.isatty()):
        yield _log_phase
        return
    from tqdm import tqdm

    with tqdm(total=len(phases), leave=False, bar_format="{desc:12} {bar:30} {elapsed}") as bar:

        def announce(phase: str) -> None:
            bar.set_description_str(phase, refresh=False)
            bar.n = phases.index(phase)
            bar.refresh()

        yield announce


@contextmanager
def _placed(scene: Scene, scene_file: Path, overrides: dict[str, Any]) -> Iterator[None]:
    """Give problems that turn up on the grid their line in the scene file."""
    from cfmpm.scene import placed

    try:
        yield
    except SceneError as error:
        raise placed(error, scene, scene_file, overrides) from None


def _log_phase(phase: str) -> None:
    log.info("phase: %s", phase)


def _read_result(path: Path, variable: str) -> xr.Dataset:
    """Read a dataset of cfmpm that has a variable; SceneError where it is none."""
    import xarray as xr

    if not path.is_file():
        raise SceneError([Problem("no such result; cfmpm run makes one", file=str(path))])
    try:
        dataset = xr.load_dataset(path, engine="netcdf4")
    except (OSError, RuntimeError, ValueError) as error:
        reason = f"cannot be read as netCDF: {getattr(error, 'strerror', None) or error}"
        raise SceneError([Problem(reason, file=str(path))]) from None
    if variable not in dataset or not {"config", "config_hash"} <= dataset.attrs.keys():
        reason = "is not what cfmpm run writes; plot takes its folder, or its history.nc"
        raise SceneError([Problem(reason, file=str(path))])
    return dataset


def _stored_config(history: xr.Dataset, path: Path) -> dict[str, Any]:
    """The scene as plain data, from the attributes of a history."""
    try:
        config: dict[str, Any] = json.loads(history.attrs["config"])
    except ValueError:
        raise SceneError([Problem("its attribute config is damaged", file=str(path))]) from None
    return config
