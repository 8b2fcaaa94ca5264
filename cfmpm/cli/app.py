"""Common parts of the commands: errors, options, log."""

from __future__ import annotations

import logging
import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup

from cfmpm._version import __version__
from cfmpm.errors import MeshError, Problem, SceneError, SolveError
from cfmpm.interruption import TerminationError

if TYPE_CHECKING:
    from cfmpm.output.record import Record
    from cfmpm.scene import Scene
    from cfmpm.state import State

    Announce = Callable[[str], None]
    Observe = Callable[[State, Record], None]

log = logging.getLogger(__name__)
WRONG_INPUT, FAILED = 2, 1
# As of a command that a signal ends: 128 and its number, 130 or 143.
INTERRUPTED, TERMINATED = 128 + signal.SIGINT, 128 + signal.SIGTERM
# What values show that cannot be.
_OF_DAMAGE = (
    *(ArithmeticError, AssertionError, AttributeError, LookupError),
    *(RuntimeError, TypeError, ValueError),
)
# This number takes about ten seconds to mesh.
MANY_TRIANGLES = 1e5


_FAILURES = (MeshError, SolveError, OSError, MemoryError, KeyboardInterrupt)


def _told(error: BaseException) -> tuple[str, int]:
    """Message and exit status of an error."""
    match error:
        case SceneError():
            return str(error), WRONG_INPUT
        case OSError():
            place = f" {error.filename}" if error.filename else ""
            return f"cfmpm: cannot write{place}: {error.strerror or error}", FAILED
        case MemoryError():
            return "cfmpm: not enough memory; use a larger mesh.size, or solver: amg", FAILED
        case TerminationError():
            return "cfmpm: interrupted", TERMINATED
        case KeyboardInterrupt():
            return "cfmpm: interrupted", INTERRUPTED
    return f"cfmpm: {error}", FAILED


def _notes_of(error: BaseException) -> list[str]:
    """What is told after an error: what is left of the run."""
    return list(getattr(error, "__notes__", []))


def _noted(error: SceneError, cause: BaseException) -> SceneError:
    """An error that stands for another one, with the notes of that."""
    for note in _notes_of(cause):
        error.add_note(note)
    return error


class _Commands(TyperGroup):
    """Commands whose errors end in a message and an exit status, never in a traceback."""

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except BrokenPipeError:  # of `cfmpm schema | head`
            raise
        except (SceneError, *_FAILURES) as error:
            message, status = _told(error)
            fail("\n".join([message, *_notes_of(error)]), status)


app = typer.Typer(
    cls=_Commands,
    help="Crack growth by configurational force in the material point method.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
# What cannot be read is told as all bad input is, by cfmpm: readable=False leaves it to that.
SceneFile = Annotated[Path, typer.Argument(metavar="SCENE.yaml", readable=False, help="the scene")]

Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="replace a value, such as mesh.size=5"),
]

Output = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR",
        readable=False,
        help="folder to write to; default: results/<name of the scene>",
    ),
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
        raise _noted(SceneError([Problem(reason, file=str(file))]), error) from None


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
        raise _noted(placed(error, scene, scene_file, overrides), error) from None


def writable(output: Path | None, default: Path) -> Path:
    """Return the folder to write to, which need not exist, before anything is done.

    Parameters
    ----------
    output : Path or None
        As given by ``--output``.
    default : Path

    Raises
    ------
    SceneError
        If it is something else than a folder, or cannot be made or written.
    """
    folder = default if output is None else output
    reason = why_unwritable(folder)
    if reason and output is None:
        raise SceneError([Problem(f"{reason}; give another folder by --output", file=str(folder))])
    if reason:
        raise SceneError([Problem(reason, file=f"--output {folder}")])
    return folder


def why_unwritable(folder: Path) -> str:
    """Why a folder cannot be made or written; empty if it can."""
    try:
        os.stat(folder)
    except (FileNotFoundError, NotADirectoryError):
        pass  # it is to be made
    except OSError as error:
        return f"cannot be made: {error.strerror}"
    there = next(path for path in (folder, *folder.parents) if os.path.lexists(path))
    if not there.is_dir():
        return "is not a folder" if there == folder else f"cannot be made: {there} is not a folder"
    if not os.access(there, os.W_OK | os.X_OK):
        return f"cannot be written: no permission for {there}"
    return ""


def readable(result: Path) -> Path:
    """Return the folder or the file of a result, in which may be looked.

    Raises
    ------
    SceneError
        If not.
    """
    try:
        os.stat(result / "history.nc")
    except (FileNotFoundError, NotADirectoryError):
        pass  # what is missing is told by who needs it
    except OSError as error:
        raise SceneError([Problem(f"cannot be read: {error.strerror}", file=str(result))]) from None
    return result


def announce_size(scene: Scene) -> None:
    """Announce the number of triangles if meshing takes a while."""
    from cfmpm.meshing import expected_triangles

    expected = expected_triangles(scene)
    if expected is not None and expected > MANY_TRIANGLES:
        tell(
            f"meshing about {expected:.2g} triangles, which takes a while; a larger mesh.size "
            "gives fewer"
        )
