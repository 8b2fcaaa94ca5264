"""Errors: invalid input and failed solves."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong with a scene file."""

    reason: str
    key: str = ""
    file: str = ""
    line: int | None = None
    column: int | None = None

    def __str__(self) -> str:
        place = ":".join(str(p) for p in (self.file, self.line, self.column) if p not in ("", None))
        # The place of an override is its key.
        key = "" if place == f"override {self.key}" else self.key
        return ": ".join(p for p in (place, key, self.reason) if p)


class SceneError(ValueError):
    """Invalid input; lists every problem found. Exit status 2."""

    def __init__(self, problems: list[Problem]) -> None:
        self.problems = problems
        super().__init__("\n".join(str(p) for p in problems))


class SolveError(RuntimeError):
    """A failed solve; the text has the step, the cause and what to change. Exit status 1."""


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """Continuation of "unknown ...": the closest known word, if any, and all known words."""
    known = list(known)
    if not known:
        return "; there are none"
    folded = {name.casefold(): name for name in reversed(known)}
    close = difflib.get_close_matches(str(word).casefold(), folded, n=1)
    guess = f"; did you mean {folded[close[0]]}?" if close else ""
    return f"{guess or ';'} known: {', '.join(known)}"


class MeshError(RuntimeError):
    """No grid could be made; the text says what to change. Exit status 1."""
