"""YAML files as plain data with the line and column of each key, for error messages."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.composer import Composer
from ruamel.yaml.error import MarkedYAMLError, StringMark, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from cfmpm.errors import Problem, SceneError
from cfmpm.input_file import MOST_TEXT, read_file

# In a config file with this key, Snakemake runs values as Python code (YTE templates).
RUNS_CODE = "__use_yte__"

Key = tuple[str | int, ...]

# Limit on the number of keys and values of a file; each takes about 40 microseconds and one
# kilobyte to read. It is needed because a few nested YAML aliases can expand to billions.
MOST_VALUES = 100_000


@dataclass(frozen=True)
class Place:
    """Position of a key: line and column of a file (both from 1), or an override."""

    file: str
    line: int | None = None
    column: int | None = None


@dataclass(frozen=True)
class Document:
    """Plain data with the place of each key.

    Attributes
    ----------
    data : object
        Nested dictionaries, lists and scalars.
    root : Place
        Place of the whole document.
    places : dict of Key to Place
        Places of the keys that were read from a file or set by an override.
    """

    data: Any
    root: Place
    places: dict[Key, Place] = field(default_factory=dict)

    def place(self, *key: str | int) -> Place:
        """Return the place of a key; the place of the document for a key without one."""
        return self.places.get(key, self.root)

    def error(self, found: Iterable[tuple[Key, str]]) -> SceneError:
        """Make one error of all problems found.

        Parameters
        ----------
        found : iterable of (Key, str)
            Key and reason of each problem.

        Returns
        -------
        SceneError
            With the problems in the order of the file.
        """
        problems = []
        for key, reason in found:
            # A missing key takes the place of the innermost key that contains it.
            around = (key[:n] for n in range(len(key), 0, -1))
            place = next((self.places[k] for k in around if k in self.places), self.root)
            problems.append(Problem(reason, dotted(key), place.file, place.line, place.column))
        return SceneError(sorted(problems, key=lambda p: (p.line or 0, p.column or 0)))

    def overridden(
        self, overrides: Mapping[str, Any], written: Mapping[str, Place] | None = None
    ) -> Document:
        """Return a copy of the document with some values replaced.

        Parameters
        ----------
        overrides : mapping of str to object
            New values by dotted keys.
        written : mapping of str to Place, optional
            Places of those overrides that were read from a file, by dotted keys.

        Returns
        -------
        Document

        Raises
        ------
        SceneError
            With every override whose key is malformed or leads to no entry of a list.
        """
        data, places, problems = self.data, dict(self.places), []
        written = written or {}
        for text, value in overrides.items():
            place = written.get(text, Place(f"override {text}"))
            try:
                key = parse_key(text)
                made = key[: _depth(data, key) + 1]
                data = replaced(data, key, value)
            except LookupError as error:
                of = text if text in written else ""
                problems.append(
                    Problem(str(error.args[0]), of, place.file, place.line, place.column)
                )
                continue
            # Keys that the override made or replaced have the place of the override.
            places = {k: p for k, p in places.items() if k[: len(made)] != made}
            places[made] = place
        if problems:
            raise SceneError(problems)
        return Document(data, self.root, places)


def dotted(key: Key) -> str:
    """Write a key as text; the inverse of `parse_key`.

    Examples
    --------
    >>> dotted(("loads", 1, "displacement", "x"))
    'loads[1].displacement.x'
    """
    return "".join(f"[{k}]" if isinstance(k, int) else f".{k}" for k in key).removeprefix(".")


@lru_cache(maxsize=1024)
def parse_key(text: str) -> Key:
    """Read a dotted key.

    Raises
    ------
    LookupError
        If the text is not a dotted key; the first argument is the reason.

    Examples
    --------
    >>> parse_key("loads[1].displacement.x")
    ('loads', 1, 'displacement', 'x')
    """
    part = r"[^.\[\]]+(\[\d{1,9}\])*"
    if not re.fullmatch(rf"{part}(\.{part})*", text):
        raise LookupError("not a key such as mesh.size or loads[0].traction")
    found = re.findall(r"\[(\d+)\]|([^.\[\]]+)", text)
    return tuple(int(index) if index else name for index, name in found)


def parse_override(text: str) -> tuple[str, Any]:
    """Read ``key=value`` from the command line.

    Parameters
    ----------
    text : str
        Dotted key and value; the value is YAML.

    Returns
    -------
    key : str
    value : object

    Raises
    ------
    SceneError
        If the text is not of this form or the value is not valid YAML.

    Examples
    --------
    >>> parse_override("fracture.radii=[10, 20]")
    ('fracture.radii', [10, 20])
    """
    key, equals, value = text.partition("=")
    if not equals or not key.strip():
        raise SceneError([Problem("not of the form key=value", file=f"override {text}")])
    return key.strip(), parse_yaml(value, f"override {key.strip()}").data


def read_document(path: Path) -> Document:
    """Read a YAML file.

    Raises
    ------
    SceneError
        If the file cannot be read, is empty, is not valid YAML in UTF-8, or asks Snakemake to run
        its values as code.
    """
    file = str(path)
    try:
        text = read_file(path, MOST_TEXT).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise SceneError([Problem("not text in UTF-8", file=file, line=line)]) from None
    except (OSError, ValueError) as error:
        raise SceneError([Problem(_why_unreadable(error), file=file)]) from None
    document = parse_yaml(text, file)
    if document.data is None:
        raise SceneError([Problem("the file is empty", file=file)])
    if isinstance(document.data, dict) and RUNS_CODE in document.data:
        reason = "lets Snakemake run values of the file as code: remove the key"
        raise document.error([((RUNS_CODE,), reason)])
    return document


# Cached because a workflow and its studies read the same files hundreds of times.
@lru_cache(maxsize=64)
def parse_yaml(text: str, file: str) -> Document:
    """Read YAML 1.2.

    Parameters
    ----------
    text : str
        The YAML text.
    file : str
        Name of its source, for messages.

    Returns
    -------
    Document
        Shared between calls with the same arguments: do not modify its data.

    Raises
    ------
    SceneError
        With syntax errors, repeated keys, too many values, or nesting without end.
    """
    yaml = YAML(typ="safe", pure=True)
    yaml.Composer = _CountingComposer
    try:
        node = yaml.compose(text)
        reader = _Reader(yaml, file)
        data = None
        if node is not None:
            _count_values(node, {}, ())
            data = reader.plain(node, ())
    except _RefusedNodeError as error:
        raise SceneError([Problem(error.reason, dotted(error.key), file, *_line(error))]) from None
    except RecursionError:
        raise SceneError([Problem("nested too deeply", file=file)]) from None
    except YAMLError as error:
        raise SceneError([_syntax_problem(error, text, file)]) from None
    if reader.problems:
        raise SceneError(reader.problems)
    return Document(data, Place(file, *((1, 1) if node is None else _line(node))), reader.places)


class _RefusedNodeError(Exception):
    """A node at which reading stops."""

    def __init__(self, reason: str, start_mark: StringMark, key: Key = ()) -> None:
        self.reason, self.start_mark, self.key = reason, start_mark, key
        super().__init__(reason)


class _CountingComposer(Composer):
    """Composes the nodes of the text; stops if there are more than `MOST_VALUES`."""

    count = 0

    def compose_node(self, parent: Node | None, index: Any) -> Node:
        self.count += 1
        if self.count > MOST_VALUES:
            raise _RefusedNodeError(_too_many(), self.parser.peek_event().start_mark)
        return super().compose_node(parent, index)


def _count_values(node: Node, counts: dict[Node, int], key: Key) -> int:
    """Count the values of a node, with each alias in full, without expanding the aliases.

    Parameters
    ----------
    node : Node
    counts : dict of Node to int
        Counts of nodes already visited; 0 marks a node whose count has begun, so that a node that
        contains itself is found.
    key : Key
        Key of the node, for messages.

    Returns
    -------
    int
    """
    if isinstance(node, ScalarNode):
        return 1
    if node in counts:
        if counts[node] == 0:
            raise _RefusedNodeError("contains itself", node.start_mark, key)
        return counts[node]
    counts[node] = 0
    if isinstance(node, MappingNode):
        inner = [(getattr(name, "value", ""), value) for name, value in node.value]
    else:
        inner = list(enumerate(node.value))
    count = 1 + sum(_count_values(value, counts, (*key, word)) for word, value in inner)
    if count > MOST_VALUES:
        raise _RefusedNodeError(_too_many(), node.start_mark, key)
    counts[node] = count
    return count


def _too_many() -> str:
    return f"more than {MOST_VALUES} values"


class _Reader:
    """Turns YAML nodes into plain data; collects places and problems."""

    def __init__(self, yaml: YAML, file: str) -> None:
        self.yaml = yaml
        self.file = file
        self.places: dict[Key, Place] = {}
        self.problems: list[Problem] = []

    def plain(self, node: Node, key: Key) -> Any:
        if isinstance(node, SequenceNode):
            for i, item in enumerate(node.value):
                self.places[*key, i] = Place(self.file, *_line(item))
            return [self.plain(item, (*key, i)) for i, item in enumerate(node.value)]
        if isinstance(node, MappingNode):
            return self._mapping(node, key)
        try:
            return self.yaml.constructor.construct_object(node)
        except ValueError:  # thousands of digits, or a date such as 2024-13-45
            self._refuse(node, key, "cannot be read; put text in quotes")
            return None

    def _mapping(self, node: MappingNode, key: Key) -> dict[str, Any]:
        data: dict[str, Any] = {}
        for key_node, value in node.value:
            if not isinstance(key_node, ScalarNode):
                self._refuse(key_node, key, "a key must be a word")
                continue
            inner = (*key, key_node.value)
            if key_node.value in data:
                self._refuse(key_node, inner, "given twice")
                continue
            self.places[inner] = Place(self.file, *_line(key_node))
            data[key_node.value] = self.plain(value, inner)
        return data

    def _refuse(self, node: Node, key: Key, reason: str) -> None:
        self.problems.append(Problem(reason, dotted(key), self.file, *_line(node)))


def _line(node: Node | _RefusedNodeError) -> tuple[int, int]:
    return node.start_mark.line + 1, node.start_mark.column + 1


def _depth(data: Any, key: Key) -> int:
    """Count the existing mappings and lists along `key`."""
    for depth, part in enumerate(key):
        if isinstance(data, Mapping):
            data = data.get(part)
        elif isinstance(data, list) and isinstance(part, int) and part < len(data):
            data = data[part]
        if not isinstance(data, Mapping | list):
            return depth
    return len(key)


def replaced(data: Any, key: Key, value: Any) -> Any:
    """Return a copy of `data` with one value replaced; missing mappings along the key are made."""
    if not key:
        return value
    head, rest = key[0], key[1:]
    if isinstance(head, int):
        if not isinstance(data, list) or head >= len(data):
            length = len(data) if isinstance(data, list) else "no"
            raise LookupError(
                f"there is no entry [{head}]: {length} entries are given, counted from [0]"
            )
        return [*data[:head], replaced(data[head], rest, value), *data[head + 1 :]]
    if isinstance(data, list):
        raise LookupError(f"{head} is a key, but this is a list: give an index, such as [0]")
    inner = dict(data) if isinstance(data, Mapping) else {}
    return inner | {head: replaced(inner.get(head), rest, value)}


def _why_unreadable(error: Exception) -> str:
    if isinstance(error, FileNotFoundError):
        return "no such file"
    if isinstance(error, IsADirectoryError):
        return "is a folder, not a scene file"
    return f"cannot be read: {getattr(error, 'strerror', None) or error}"


def _syntax_problem(error: YAMLError, text: str, file: str) -> Problem:
    if not isinstance(error, MarkedYAMLError):  # a control character
        line = text[: getattr(error, "position", 0)].count("\n") + 1
        return Problem("not valid YAML: a character that is not text", file=file, line=line)
    said = " ".join(p for p in (error.context, error.problem) if p)
    if "\\t" in said:
        said = "a tab; indent with spaces"
    mark: StringMark | None = error.problem_mark or error.context_mark
    where = (mark.line + 1, mark.column + 1) if mark else (None, None)
    return Problem(f"not valid YAML: {said}", "", file, *where)
