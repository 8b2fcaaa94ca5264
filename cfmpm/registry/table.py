"""A table of words: what the package itself has, and what other packages add to it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from importlib.metadata import entry_points
from pkgutil import resolve_name
from typing import Any, Generic, TypeVar

Entry = TypeVar("Entry")


class Registry(Mapping[str, Entry], Generic[Entry]):
    """The words of one kind, such as the constitutive laws, in the order of their schema.

    Entries are plain data. Code that is slow to import (Numba, SciPy) is named in them by its
    place, ``"package.module:name"``, and loaded by `load` when it is used.

    Parameters
    ----------
    kind : str
        What a word stands for, for messages; ``cfmpm.<kind>s`` is the group of entry points.
    entries : mapping of str to Entry
        The words of the package itself.

    Notes
    -----
    Another package adds a word by an entry point of the group, whose name is the word and which
    points to an entry; a script adds one by `add`, before the first scene is read, since the models
    of a scene are made from the words.
    """

    def __init__(self, kind: str, entries: Mapping[str, Entry]) -> None:
        self.kind = kind
        self._entries = dict(entries)
        self._read = False

    def add(self, word: str, entry: Entry) -> None:
        """Add a word.

        Raises
        ------
        ValueError
            Where the word is taken.
        RuntimeError
            Where the words have been read: it would be known to one part of the program only.
        """
        if self._read:
            raise RuntimeError(f"{self.kind} {word}: add it before the first scene is read")
        self._put(word, entry)

    def _put(self, word: str, entry: Entry) -> None:
        if word in self._entries:
            raise ValueError(f"{self.kind} {word}: there is one by that name already")
        self._entries[word] = entry

    def _known(self) -> dict[str, Entry]:
        if not self._read:
            for point in sorted(
                _points().select(group=f"cfmpm.{self.kind}s"), key=lambda p: p.name
            ):
                self._put(point.name, point.load())
            self._read = True
        return self._entries

    def __getitem__(self, word: str) -> Entry:
        return self._known()[word]

    def __iter__(self) -> Iterator[str]:
        return iter(self._known())

    def __len__(self) -> int:
        return len(self._known())


@cache
def _points() -> Any:
    """All entry points that are installed, whose type depends on the version of Python."""
    return entry_points()


@cache
def load(place: str) -> Any:
    """Return what stands at a place, ``"package.module:name"``, and import it if needed.

    Examples
    --------
    >>> load("math:hypot")(3.0, 4.0)
    5.0
    """
    return resolve_name(place)
