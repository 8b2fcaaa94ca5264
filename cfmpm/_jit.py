"""The one decorator with which every kernel is compiled.

Numba notices an edited kernel only in the file that holds it, and keeps stale machine code of a
kernel that calls one in another file. The cache folder is therefore keyed by a hash of all kernel
sources, and of those of other packages whose kernels are called. ``NUMBA_CACHE_DIR`` moves it,
``NUMBA_DISABLE_JIT=1`` runs kernels as plain Python, and ``NUMBA_BOUNDSCHECK=1`` checks every
index.
"""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, Literal, TypeVar, cast

import numba
from numba.core import config as _config

KEPT = 3
"""Cache folders, of the newest sources, that stay when another one is made."""

Function = TypeVar("Function", bound=Callable[..., Any])


_PACKAGE = Path(__file__).parent
_depended_on: list[str] = []


def cache_folder(*sources: str) -> Path:
    """Return the folder of compiled kernels that belongs to the present sources.

    Parameters
    ----------
    *sources : str
        Texts that the kernels depend on besides those of this package.
    """
    texts = [_own_sources(), *_depended_on, *sources]
    digest = hashlib.sha256("\0".join(texts).encode()).hexdigest()[:16]
    base = os.environ.get("NUMBA_CACHE_DIR")
    if base is None:
        home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
        base = str(Path(home) / "cfmpm")
    return Path(base) / f"kernels-{digest}"


def depend_on(*sources: str) -> None:
    """Let the cache folder of kernels compiled from now on also depend on other texts."""
    _depended_on.extend(sources)


def beside(path: Path) -> list[Path]:
    """Return the files that a module of another package may take kernels from.

    Parameters
    ----------
    path : Path
        Of the module.

    Returns
    -------
    list of Path
        Those of its package; itself alone where it is in none.
    """
    if (path.parent / "__init__.py").is_file():
        return sorted(path.parent.glob("*.py"))
    return [path] if path.is_file() else []


@cache
def _own_sources() -> str:
    """Sources of the kernels of this package."""
    kernels = sorted((_PACKAGE / "kernels").rglob("*.py"))
    return "\0".join(path.read_text("utf-8") for path in [*kernels, _PACKAGE / "registry/laws.py"])


@cache
def _sources_of(file: str) -> tuple[str, ...]:
    """Other texts on which a kernel depends, by its file."""
    path = Path(file)
    if path.is_relative_to(_PACKAGE):
        return ()
    return tuple(each.read_text("utf-8") for each in beside(path))


# Numba sets its options on the module when it is loaded.
config: Any = _config


def kernel(function: Function, inline: Literal["never", "always"] = "never") -> Function:
    """Compile `function` to serial machine code, cached on disk.

    Parameters
    ----------
    function : callable
    inline : {"never", "always"}
        "always" puts its text in place of each call: to hand arrays on, level by level, can cost as
        much as what is done with them.

    Notes
    -----
    Division by zero gives inf or nan as in numpy, and no fast-math: results are the same bits on
    every run, whatever the number of threads.
    """
    folder = cache_folder(*_sources_of(function.__code__.co_filename))
    before = config.CACHE_DIR
    config.CACHE_DIR = str(folder)
    try:
        if not folder.is_dir():
            folder.mkdir(parents=True, exist_ok=True)
            _remove_old(folder.parent)
        compiled = numba.njit(cache=True, error_model="numpy", inline=inline)(function)
    except (OSError, RuntimeError):
        # An unwritable cache costs compile time, not the run.
        compiled = numba.njit(error_model="numpy", inline=inline)(function)
    finally:
        config.CACHE_DIR = before
    return cast(Function, compiled)


def _remove_old(base: Path) -> None:
    """Remove the cache folders of older sources; one that is still in use is made again."""
    with suppress(OSError):  # another process may be doing the same
        folders = sorted(base.glob("kernels-*"), key=lambda path: path.stat().st_mtime)
        for folder in folders[:-KEPT]:
            shutil.rmtree(folder, ignore_errors=True)
