"""A doubt about the states of a run, which becomes one warning that names its steps."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from cfmpm.output.analysis import in_steps

# Where a text states the size of what it is about.
SIZE = "<size>"


@dataclass(frozen=True)
class Doubt:
    """A doubt about one state.

    Attributes
    ----------
    text : str
        What is doubtful, and what to change; `SIZE` stands for the size.
    about : str
        The tip or crack that is meant; empty for the whole body.
    size : float
        The largest one of all steps is stated.
    """

    text: str
    about: str = ""
    size: float = 0.0

    def said(self, steps: Iterable[int] = ()) -> str:
        """Return the warning for steps, counted from one; without any, for a scene not solved."""
        marked = np.array(sorted(steps), int) - 1
        where = np.zeros(marked.max(initial=-1) + 1, bool)
        where[marked] = True
        parts = [f"{self.about}:"] if self.about else []
        parts += [in_steps(where)] if len(where) else []
        size = f"{self.size:.0f}" if self.size == int(self.size) else f"{self.size:.2g}"
        return " ".join([*parts, self.text.replace(SIZE, size)])


class Doubts:
    """The doubts of a run, each with its steps and its largest size."""

    def __init__(self, found: Iterable[tuple[str, str, float, list[int]]] = ()) -> None:
        self._of = {(text, about): (size, list(steps)) for text, about, size, steps in found}

    def add(self, step: int, doubts: Iterable[Doubt]) -> None:
        """Add the doubts of a step, counted from one."""
        for doubt in doubts:
            size, steps = self._of.get((doubt.text, doubt.about), (doubt.size, []))
            self._of[doubt.text, doubt.about] = (max(size, doubt.size), [*steps, step])

    def said(self) -> list[str]:
        """Return the warnings."""
        return [Doubt(text, about, size).said(steps) for text, about, size, steps in self.listed()]

    def listed(self) -> list[tuple[str, str, float, list[int]]]:
        """Return what the doubts are made of again."""
        return [(text, about, size, steps) for (text, about), (size, steps) in self._of.items()]
