"""One thread for dense linear algebra: sums of a threaded BLAS depend on the number of threads."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

from threadpoolctl import ThreadpoolController


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Limit BLAS and LAPACK of NumPy and SciPy to one thread within a ``with`` block.

    Notes
    -----
    The limit holds for the whole process and is restored at the end. It applies to loaded
    libraries, as those of NumPy and SciPy are. A package that is loaded later and has its own is
    limited by `limit_blas_of`; gmsh is serial by its options, rslab by its arguments. Apple's
    Accelerate cannot be limited.
    """
    with _libraries().limit(limits=1):
        yield


def limit_blas_of(package: str) -> None:
    """Limit the BLAS of a package that was loaded just now; later blocks limit it too.

    Parameters
    ----------
    package : str
        Part of the path of its libraries.
    """
    _libraries.cache_clear()
    for library in _libraries().lib_controllers:
        if package in library.filepath:
            library.set_num_threads(1)


@cache
def _libraries() -> ThreadpoolController:
    """Find the libraries, once: it takes some milliseconds, setting a limit 0.03 ms."""
    import scipy.linalg  # noqa: F401  (SciPy's wheels have a BLAS of their own)

    return ThreadpoolController().select(user_api="blas")
