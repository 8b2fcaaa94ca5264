"""Loading, starting and stopping gmsh."""

from __future__ import annotations

import ctypes
import os
import pickle
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import NoReturn, TypeVar, cast

from cfmpm.errors import MeshError
from cfmpm.interruption import REQUESTS

Made = TypeVar("Made")

# Libraries that gmsh's wheel links to and that a minimal Debian with Python lacks, without their
# dependencies.
SYSTEM_PACKAGES = "libgl1 libglu1-mesa libgomp1 libxcursor1 libxft2 libxinerama1"

OPTIONS = {
    "General.Terminal": 0,
    "General.NumThreads": 1,
    # Frontal-Delaunay: mean quality 0.97 against 0.945 of Delaunay (5) and 0.955 of MeshAdapt (1),
    # median size 0.95 of that requested (5: 0.90) in the same time; BAMG (7) fails at cracks.
    "Mesh.Algorithm": 6,
    "Mesh.RandomSeed": 1,
    # Only the size fields determine the element size.
    "Mesh.MeshSizeExtendFromBoundary": 0,
    "Mesh.MeshSizeFromPoints": 0,
    "Mesh.MeshSizeFromCurvature": 0,
    "Mesh.MeshSizeMin": 0,
}


@contextmanager
def gmsh_session() -> Iterator[ModuleType]:
    """Yield gmsh, started without output on one thread, and stop it at the end.

    Raises
    ------
    MeshError
        If gmsh cannot be loaded, or is already in use, since its state is global.
    """
    try:
        import gmsh
    except OSError as error:
        raise MeshError(
            f"gmsh cannot be loaded: {error}; on Debian or Ubuntu: apt-get install "
            + SYSTEM_PACKAGES
        ) from error
    if gmsh.isInitialized():
        raise MeshError("gmsh is in use in this process: call gmsh.finalize() first")
    with _handlers_kept():
        gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        for option, value in OPTIONS.items():
            gmsh.option.setNumber(option, value)
        yield gmsh
    finally:
        gmsh.finalize()


def in_child(work: Callable[[], Made]) -> Made:
    """Do work in a child process, which ends at once when this one is asked to end.

    A call of gmsh cannot be interrupted: Python handles signals between its own instructions only.

    Parameters
    ----------
    work : callable
        Without arguments. What it returns or raises is pickled.

    Raises
    ------
    MeshError
        If the child ends without a result, as in a crash of gmsh.
    """
    # Signals come to the main thread only; elsewhere a copy of a process may not be usable.
    if threading.current_thread() is not threading.main_thread() or sys.platform != "linux":
        return work()
    reader, writer = os.pipe()
    with warnings.catch_warnings():
        # The child runs no other thread of this process and takes none of their locks.
        warnings.simplefilter("ignore", DeprecationWarning)
        # An exception that a handler raises in the midst of a fork is lost.
        before = signal.pthread_sigmask(signal.SIG_BLOCK, REQUESTS)
        try:
            child = os.fork()
        except OSError:  # no more processes: signals then wait for gmsh
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
            os.close(reader)
            os.close(writer)
            return work()
    if child == 0:
        os.close(reader)
        _answer(work, writer, before)
    try:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        os.close(writer)
        with os.fdopen(reader, "rb") as pipe:
            answer = pipe.read()
    except BaseException:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        raise
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if code != 0:
        why = signal.Signals(-code).name if code < 0 else f"status {code}"
        raise MeshError(
            f"gmsh has ended with {why}: out of memory, or lines that cross or nearly touch; "
            "take a larger mesh.size"
        )
    good, made = pickle.loads(answer)
    if not good:
        raise made
    return cast(Made, made)


def _answer(work: Callable[[], Made], writer: int, mask: set[signal.Signals | int]) -> NoReturn:
    """Do work, write its result, and end the process without what its parent does in the end."""
    status = 1
    try:
        for request in REQUESTS:
            # Ctrl-C comes to both: the parent ends its child.
            signal.signal(request, signal.SIG_IGN if request == signal.SIGINT else signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        _end_with_parent()
        answer: tuple[bool, object]
        try:
            answer = (True, work())
        except Exception as error:
            answer = (False, error.with_traceback(None))
        with os.fdopen(writer, "wb") as pipe:
            pickle.dump(answer, pipe, protocol=pickle.HIGHEST_PROTOCOL)
        status = 0
    finally:
        os._exit(status)


def _end_with_parent() -> None:
    """Ask Linux to end this process when its parent is killed."""
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


@contextmanager
def _handlers_kept() -> Iterator[None]:
    """Restore Python's signal handlers at the end of a ``with`` block.

    gmsh.initialize resets SIGTERM, SIGHUP, SIGPIPE and others to the system's default without
    Python's knowledge: `signal.getsignal` still returns the handler that is no longer called.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # handlers belong to the main thread
        return
    handlers = {number: signal.getsignal(number) for number in signal.valid_signals()}
    try:
        yield
    finally:
        for number, handler in handlers.items():
            if handler not in (signal.SIG_DFL, None):
                signal.signal(number, handler)
