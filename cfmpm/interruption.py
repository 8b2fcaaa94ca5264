"""Interrupts: Ctrl-C and SIGTERM, the signal of clusters and of `timeout`."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn

REQUESTS = (signal.SIGINT, signal.SIGTERM)


class TerminationError(KeyboardInterrupt):
    """SIGTERM, which ends a run as Ctrl-C does, with another exit status."""


@contextmanager
def terminated_as_interrupted() -> Iterator[None]:
    """Let SIGTERM raise a KeyboardInterrupt, as Ctrl-C does, within the ``with`` block."""

    def interrupt(number: int, frame: object) -> NoReturn:
        raise TerminationError

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


@contextmanager
def held_back() -> Iterator[None]:
    """Delay interrupts until the end of the ``with`` block.

    An exception during a write to netCDF leaves the lock of that library taken, and the next write
    would wait for it forever. In other threads than the main thread, in which interrupts raise no
    exception, nothing is done.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    asked: list[int] = []
    before = {one: signal.getsignal(one) for one in REQUESTS}
    try:
        for one in REQUESTS:
            signal.signal(one, lambda number, frame: asked.append(number))
        yield
    finally:
        for one, handler in before.items():
            # None: a handler that was not set by Python and cannot be restored by it.
            signal.signal(one, signal.SIG_DFL if handler is None else handler)
        if asked:
            signal.raise_signal(asked[0])
