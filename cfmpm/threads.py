"""One thread for dense linear algebra: what a threaded BLAS sums depends on how many it has."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

from threadpoolctl import ThreadpoolController


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Keep the BLAS and LAPACK of NumPy and SciPy to one thread within a ``with`` block.

    Notes
    -----
    The limit holds for the whole process, and goes back to what it was at the end. It holds for
    libraries that are loaded: those of NumPy and SciPy are. Others bring their own, which is
    serial: CHOLMOD in kvxopt's wheels, gmsh by its options, rslab by its arguments. Apple's
    Accelerate takes no limit.
    """
    with _libraries().limit(limits=1):
        yield


@cache
def _libraries() -> ThreadpoolController:
    """Find the libraries once, which takes some milliseconds; a limit takes 0.03 ms."""
    import scipy.linalg  # noqa: F401  (SciPy's wheels have a BLAS of their own)

    return ThreadpoolController().select(user_api="blas")
