"""Wall time of the phases of a run."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Clock:
    """Adds up wall time by phase, and announces each phase as it begins.

    Parameters
    ----------
    announce : callable
        Called with the name of the phase, for example by a progress bar.
    """

    def __init__(self, announce: Callable[[str], None]) -> None:
        self._seconds: dict[str, float] = {}
        self._announce = announce

    @contextmanager
    def __call__(self, phase: str) -> Iterator[None]:
        """Time the body of a ``with`` statement."""
        self._announce(phase)
        start = time.perf_counter()
        try:
            yield
        finally:
            elapsed = time.perf_counter() - start
            self._seconds[phase] = self._seconds.get(phase, 0.0) + elapsed

    def lap(self) -> dict[str, float]:
        """Return the wall time of each phase since the last lap [s]."""
        seconds, self._seconds = self._seconds, dict.fromkeys(self._seconds, 0.0)
        return seconds
