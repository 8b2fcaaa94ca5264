"""Table of the words of one kind; other packages can add words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from importlib.metadata import entry_points
from pkgutil import resolve_name
from typing import Any, Generic, TypeVar

Entry = TypeVar("Entry")


class Registry(Mapping[str, Entry], Generic[Entry]):
    """Words of one kind, such as constitutive laws, with their entries, in the order of the schema.

    Entries are plain data. They refer to code that is slow to import (Numba, SciPy) by its place,
    ``"package.module:name"``; `load` imports it on first use.

    Parameters
    ----------
    kind : str
        Name of the kind for messages; ``cfmpm.<kind>s`` is the group of entry points.
    entries : mapping of str to Entry
        Words that the package defines.

    Notes
    -----
    Another package adds a word by an entry point of the group: its name is the word, its object an
    entry. A script calls `add` before the first scene is read, because the models of a scene are
    made from the words.
    """

    def __init__(self, kind: str, entries: Mapping[str, Entry]) -> None:
        self.kind = kind
        self._entries = dict(entries)
        self._read = False

    def add(self, word: str, entry: Entry) -> None:
        """Add a word.

        Parameters
        ----------
        word : str
        entry : Entry

        Raises
        ------
        ValueError
            If the word is already in use.
        RuntimeError
            If the words have already been read: only a part of the program would know the new one.
        """
        if self._read:
            raise RuntimeError(f"{self.kind} {word}: add it before the first scene is read")
        self._put(word, entry)

    def _put(self, word: str, entry: Entry) -> None:
        if word in self._entries:
            raise ValueError(f"{self.kind} {word}: this name is already in use")
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
    """Return all installed entry points; their type depends on the version of Python."""
    return entry_points()


@cache
def load(place: str) -> Any:
    """Import the object at a place.

    Parameters
    ----------
    place : str
        ``"package.module:name"``, or the name of a module.

    Returns
    -------
    object

    Raises
    ------
    ImportError, AttributeError
        If there is no such module or name.

    Examples
    --------
    >>> load("math:hypot")(3.0, 4.0)
    5.0
    """
    return resolve_name(place)
