"""Common parts of the commands: errors, options, log."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup

from cfmpm._version import __version__
from cfmpm.errors import MeshError, Problem, SceneError, SolveError

if TYPE_CHECKING:
    from cfmpm.output.record import Record
    from cfmpm.scene import Scene
    from cfmpm.state import State

    Announce = Callable[[str], None]
    Observe = Callable[[State, Record], None]

log = logging.getLogger(__name__)
WRONG_INPUT, FAILED, INTERRUPTED = 2, 1, 130
# What values show that cannot be.
_OF_DAMAGE = (
    *(ArithmeticError, AssertionError, AttributeError, LookupError),
    *(RuntimeError, TypeError, ValueError),
)
# This number takes about ten seconds to mesh.
MANY_TRIANGLES = 1e5


class _Commands(TyperGroup):
    """Commands whose errors end in a message and an exit status, never in a traceback."""

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except SceneError as error:
            fail(str(error), WRONG_INPUT)
        except (MeshError, SolveError) as error:
            fail(f"cfmpm: {error}", FAILED)
        except BrokenPipeError:  # of `cfmpm schema | head`
            raise
        except OSError as error:
            place = f" {error.filename}" if error.filename else ""
            fail(f"cfmpm: cannot write{place}: {error.strerror or error}", FAILED)
        except MemoryError:
            fail("cfmpm: not enough memory; use a larger mesh.size, or solver: amg", FAILED)
        except KeyboardInterrupt:
            fail("cfmpm: interrupted", INTERRUPTED)


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
    bool, typer.Option("--overwrite", help="replace an interrupted run that could be resumed")
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="print errors only")]
Verbose = Annotated[bool, typer.Option("--verbose", "-v", help="log each phase")]


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


def tell(message: str) -> None:
    """Say something on stderr; where that is closed or full, no run is lost by it."""
    with suppress(OSError, ValueError):
        typer.echo(message, err=True)


@contextmanager
def told_as_damage(file: Path) -> Iterator[None]:
    """Refuse a file for what the ``with`` block makes of it.

    What cfmpm has written breaks none of the rules by which it is read. A file may obey them and
    still hold what cannot be: a picture of nothing, a solve from a state that is none.
    """
    try:
        yield
    except (SceneError, MeshError, SolveError, OSError, typer.Exit):
        raise
    except _OF_DAMAGE as error:
        log.debug("%s", file, exc_info=True)
        said = f"{type(error).__name__}: {' '.join(str(error).split())[:200]}"
        reason = f"holds what cfmpm does not write ({said}): run the scene again"
        raise SceneError([Problem(reason, file=str(file))]) from None


def fail(message: str, status: int) -> NoReturn:
    tell(message)
    raise typer.Exit(status)


def read_overrides(texts: list[str] | None) -> dict[str, Any]:
    """Values by key, each given once; all errors in the texts are reported together."""
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
def log_shown(wanted: bool) -> Iterator[None]:
    """Show the log of the package on stderr within a ``with`` block."""
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
def problems_placed(scene: Scene, scene_file: Path, overrides: dict[str, Any]) -> Iterator[None]:
    """Add the line in the scene file to problems that are found on the grid."""
    from cfmpm.scene import placed

    try:
        yield
    except SceneError as error:
        raise placed(error, scene, scene_file, overrides) from None


def announce_size(scene: Scene) -> None:
    """Announce the number of triangles if meshing takes a while."""
    from cfmpm.meshing import expected_triangles

    expected = expected_triangles(scene)
    if expected is not None and expected > MANY_TRIANGLES:
        tell(
            f"meshing about {expected:.2g} triangles, which takes a while; a larger mesh.size "
            "gives fewer"
        )
