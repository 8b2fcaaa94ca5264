"""The numbers of one section of a mesh file of gmsh."""

from __future__ import annotations

import warnings
from itertools import pairwise
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.grid import Floats, Ints


class DamagedError(ValueError):
    """The file is no mesh, or not whole; says what is wrong."""


class Numbers:
    """The numbers of a section one after the other, from text or binary.

    Kinds: ``i`` an integer of four bytes, ``s`` of eight, ``d`` a number of eight.
    """

    def __init__(self, section: str, data: bytes, order: str | None) -> None:
        self._section, self._data, self._order, self._at = section, data, order, 0
        if order is None:
            self._text = self._parsed(data.strip())

    def _parsed(self, text: bytes) -> Floats:
        if not text:
            return np.empty(0)
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # numpy stops at what is no number, and only warns
            try:
                return np.asarray(np.fromstring(text, sep=" "))
            except (ValueError, DeprecationWarning):
                self.damaged("has something that is no number")

    def damaged(self, reason: str) -> NoReturn:
        raise DamagedError(f"is damaged: ${self._section} {reason}")

    @property
    def left(self) -> int:
        """How many numbers, or bytes of them, have not been taken."""
        rest = len(self._data) if self._order else len(self._text)
        return rest - self._at

    def rows(self, count: int, *columns: tuple[str, int]) -> list[NDArray[Any]]:
        """Take rows of columns, each of a kind and width: arrays (count, width)."""
        sizes = {"i": 4, "s": 8, "d": 8}
        each = sum(w * sizes[kind] if self._order else w for kind, w in columns)
        if max(count, 1) * each > self.left:
            if count == 0:
                return [
                    np.empty((0, w)) if kind == "d" else np.empty((0, w), np.int64)
                    for kind, w in columns
                ]
            self.damaged("is shorter than its numbers say")
        if self._order:
            kinds = {"i": "i4", "s": "u8", "d": "f8"}
            layout = np.dtype(
                [(str(k), self._order + kinds[kind], (w,)) for k, (kind, w) in enumerate(columns)]
            )
            table = np.frombuffer(self._data, layout, count, self._at)
            found = [table[str(k)] for k in range(len(columns))]
        else:
            flat = self._text[self._at : self._at + count * each].reshape(count, each)
            starts = np.cumsum([0, *(w for _, w in columns)])
            found = [flat[:, a:b] for a, b in pairwise(starts)]
        self._at += count * each
        return [
            part.astype(np.float64) if kind == "d" else self.whole(part)
            for part, (kind, _) in zip(found, columns, strict=True)
        ]

    def whole(self, part: NDArray[Any]) -> Ints:
        """Turn numbers into whole ones."""
        values = part.astype(np.float64)
        if not (np.abs(values) < 2.0**53).all() or (values != np.floor(values)).any():
            self.damaged("has a number or a count that is no whole number")
        return part.astype(np.int64)

    def one(self, *kinds: str) -> list[int]:
        """Take single whole numbers."""
        return [int(part[0, 0]) for part in self.rows(1, *((kind, 1) for kind in kinds))]

    def count(self, kind: str = "s") -> int:
        """Take a count."""
        (n,) = self.one(kind)
        if n < 0:
            self.damaged("has a negative count")
        return n

    def line(self) -> int:
        """Take the count that binary files of format 2 write as a line of text."""
        if self._order is None:
            return self.count()
        end = self._data.find(b"\n", self._at)
        text = self._data[self._at : end].strip() if end >= 0 else b""
        if not text.isdigit() or len(text) > 15:
            self.damaged("does not begin with a count")
        self._at = end + 1
        return int(text)

    def rest(self) -> Floats:
        """All numbers of a text that have not been taken."""
        found, self._at = self._text[self._at :], len(self._text)
        return found

    def end(self) -> None:
        """Refuse what is left over."""
        left = self._data[self._at :].strip() if self._order else self._text[self._at :]
        if len(left):
            self.damaged("is longer than its numbers say")
