"""The one decorator with which every kernel is compiled.

Numba notices an edited kernel only in the file that holds it, and keeps stale machine code of a
kernel that calls one in another file. The cache folder is therefore keyed by a hash of all kernel
sources. ``NUMBA_CACHE_DIR`` moves it, ``NUMBA_DISABLE_JIT=1`` runs kernels as plain Python, and
``NUMBA_BOUNDSCHECK=1`` checks every index.
"""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import config as _config

KEPT = 3
"""Cache folders, of the newest sources, that stay when another one is made."""

Function = TypeVar("Function", bound=Callable[..., Any])


@cache
def cache_folder() -> Path:
    """Return the folder of compiled kernels that belongs to the present sources."""
    sources = sorted((Path(__file__).parent / "kernels").glob("*.py"))
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()[:16]
    base = os.environ.get("NUMBA_CACHE_DIR")
    if base is None:
        home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
        base = str(Path(home) / "cfmpm")
    return Path(base) / f"kernels-{digest}"


# Numba sets its options on the module when it is loaded.
config: Any = _config


def kernel(function: Function) -> Function:
    """Compile `function` to serial machine code, cached on disk.

    Division by zero gives inf or nan as in numpy, and no fast-math: results are the same bits on
    every run, whatever the number of threads.
    """
    folder = cache_folder()
    before = config.CACHE_DIR
    config.CACHE_DIR = str(folder)
    try:
        if not folder.is_dir():
            folder.mkdir(parents=True, exist_ok=True)
            _remove_old(folder.parent)
        compiled = numba.njit(cache=True, error_model="numpy")(function)
    except (OSError, RuntimeError):
        # An unwritable cache costs compile time, not the run.
        compiled = numba.njit(error_model="numpy")(function)
    finally:
        config.CACHE_DIR = before
    return cast(Function, compiled)


def _remove_old(base: Path) -> None:
    """Remove the cache folders of older sources; one that is still in use is made again."""
    with suppress(OSError):  # another process may be doing the same
        folders = sorted(base.glob("kernels-*"), key=lambda path: path.stat().st_mtime)
        for folder in folders[:-KEPT]:
            shutil.rmtree(folder, ignore_errors=True)
