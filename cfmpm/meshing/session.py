"""Loading, starting and stopping gmsh."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType

from cfmpm.errors import MeshError

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
