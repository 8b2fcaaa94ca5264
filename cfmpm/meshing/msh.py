"""Mesh files of gmsh: formats 1, 2 and 4 (4.0, 4.1), as text or binary, read strictly.

The formats are those of the gmsh reference manual, chapter "Gmsh file formats". Files come from
anywhere: every count is compared with what is there before anything is allocated, and whatever a
file leaves open is an error. Physical groups may have a minus sign, which reverses a curve or a
surface: here it says nothing.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.grid import Floats, Ints
from cfmpm.meshing.msh_numbers import DamagedError, Numbers

# Numbers of nodes of gmsh's element types by dimension; the corners come first.
POINTS = {15: 1}
LINES = {1: 2, 8: 3, 26: 4, 27: 5, 28: 6, **{62 + i: 7 + i for i in range(5)}}
TRIANGLES = {2: 3, 9: 6, 20: 9, 21: 10, 22: 12, 23: 15, 24: 15, 25: 21}
OTHERS = {
    "quadrilaterals": {3: 4, 10: 9, 16: 8, 36: 16, 37: 25, 38: 36},
    "tetrahedra": {4: 4, 11: 10, 29: 20, 30: 35, 31: 56},
    "hexahedra": {5: 8, 12: 27, 17: 20},
    "prisms": {6: 6, 13: 18, 18: 15},
    "pyramids": {7: 5, 14: 14, 19: 13},
}
N_NODES = POINTS | LINES | TRIANGLES | {k: n for other in OTHERS.values() for k, n in other.items()}
WORDS = ("point", "curve", "surface", "volume")
# Beyond this the squares of coordinates lose their meaning [mm]; scenes have the same limit.
FARTHEST = 1e9
# Rows of elements that are looked at together at first.
CHUNK = 64


@dataclass
class Contents:
    """What a mesh file holds, with the nodes numbered from 0.

    Attributes
    ----------
    nodes : (n, 3) float
        Coordinates [mm].
    triangles, lines : (m, 3), (k, 2) int
        Corner nodes, each once.
    surfaces, curves : dict of str to int array
        Rows of `triangles` and `lines` in each physical group, by its name; a group without one
        is called surface_3, curve_3 ... by its number.
    """

    nodes: Floats
    triangles: Ints
    lines: Ints
    surfaces: dict[str, Ints]
    curves: dict[str, Ints]


def read_msh(data: bytes) -> Contents:
    """Read a mesh file.

    Parameters
    ----------
    data : bytes
        All of it.

    Raises
    ------
    DamagedError
        With one line about what is wrong.
    """
    file = _File()
    for name, section in _sections(data):
        file.read(name, section)
    return file.contents()


def _sections(data: bytes) -> Iterator[tuple[str, bytes]]:
    """The sections from $Name to $EndName, in their order."""
    if not data.lstrip().startswith(b"$"):
        raise DamagedError("is not a gmsh mesh")
    at = 0
    while at < len(data):
        if data[at : at + 1].isspace():
            at += 1
            continue
        head = re.compile(rb"\$([A-Za-z]{1,40})[ \t]*\r?\n").match(data, at)
        if head is None:
            raise DamagedError(f"is damaged: no section begins at byte {at}, where one should")
        name = head[1].decode()
        ends = (f"$End{name}".encode(), f"$END{name}".encode())  # format 1 has capitals
        end, mark = max((data.find(found, head.end()), found) for found in ends)
        if end < 0:
            raise DamagedError(f"ends within ${name}: it is not whole")
        yield name, data[head.end() : end]
        at = end + len(mark)


@dataclass
class _File:
    """The parts of a file as its sections are read."""

    version: str = ""
    order: str | None = None
    names: dict[tuple[int, int], str] = field(default_factory=dict)
    groups: dict[tuple[int, int], list[int]] = field(default_factory=dict)
    tags: list[Ints] = field(default_factory=list)
    places: list[Floats] = field(default_factory=list)
    # Dimension 1 and 2: corner tags, and the physical groups of all of them.
    elements: dict[int, list[tuple[Ints, list[int]]]] = field(
        default_factory=lambda: {1: [], 2: []}
    )
    seen: set[str] = field(default_factory=set)

    def read(self, name: str, data: bytes) -> None:
        """Read one section; those that say nothing of the mesh itself are left out."""
        if name == "ParametricNodes":
            raise DamagedError("has $ParametricNodes; save it without (Mesh.SaveParametric = 0)")
        readers = {
            "MeshFormat": self._format,
            "PhysicalNames": self._physical_names,
            "Entities": self._entities,
            "PartitionedEntities": self._entities,
            "Nodes": self._nodes,
            "NOD": self._nodes,
            "Elements": self._elements,
            "ELM": self._elements,
        }
        if name not in readers:
            return
        if name in self.seen:
            raise DamagedError(f"is damaged: has ${name} twice")
        self.seen.add(name)
        if name in ("NOD", "ELM"):
            self.version = self.version or "1"
        if name != "MeshFormat" and not self.version:
            raise DamagedError(f"is not a gmsh mesh: ${name} comes before $MeshFormat")
        readers[name](name, data)

    def _format(self, name: str, data: bytes) -> None:
        head, _, tail = data.partition(b"\n")
        words = head.split()
        if len(words) != 3:
            raise DamagedError(f"is damaged: ${name} needs version, kind and size of numbers")
        version, kind, size = (word.decode("ascii", "replace") for word in words)
        known = {"2": "2", "2.0": "2", "2.1": "2", "2.2": "2", "4": "4.0", "4.0": "4.0"}
        self.version = (known | {"4.1": "4.1"}).get(version, "")
        if not self.version:
            raise DamagedError(
                f"has format {version[:12]!r}; save it as 4.1 or 2.2 (Mesh.MshFileVersion)"
            )
        if kind not in ("0", "1") or size != "8":
            raise DamagedError("is damaged: $MeshFormat needs 0 or 1, and 8, after the version")
        if kind == "1":
            one = tail[:4]
            orders = {b"\x01\x00\x00\x00": "<", b"\x00\x00\x00\x01": ">"}
            if one not in orders:
                raise DamagedError("is damaged: $MeshFormat has no number 1, as of a binary file")
            self.order = orders[one]

    def _physical_names(self, name: str, data: bytes) -> None:
        lines = _decoded(data).strip().splitlines()
        pattern = re.compile(r'\s*([0-3])\s+(-?\d{1,9})\s+"(.*)"\s*')
        found = [pattern.fullmatch(line) for line in lines[1:]]
        if not lines or lines[0].strip() != str(len(found)) or None in found:
            raise DamagedError(f'is damaged: ${name} needs a count and lines such as 1 2 "top"')
        for match in filter(None, found):
            text = unicodedata.normalize("NFC", match[3])
            self.names[int(match[1]), abs(int(match[2]))] = text

    def _entities(self, name: str, data: bytes) -> None:
        numbers = Numbers(name, data, self.order)
        parted = name == "PartitionedEntities"
        if parted:
            numbers.count()
            numbers.rows(numbers.count(), ("i", 2))
        counts = [numbers.count() for _ in range(4)]
        for dim, count in enumerate(counts):
            for _ in range(count):
                (tag,) = numbers.one("i")
                if parted:
                    numbers.one("i", "i")
                    numbers.rows(numbers.count(), ("i", 1))
                numbers.rows(1, ("d", 3 if dim == 0 and self.version == "4.1" else 6))
                (groups,) = numbers.rows(numbers.count(), ("i", 1))
                self.groups[dim, tag] = np.abs(groups.ravel()).tolist()
                if dim:
                    numbers.rows(numbers.count(), ("i", 1))
        numbers.end()

    def _nodes(self, name: str, data: bytes) -> None:
        numbers = Numbers(name, data, self.order)
        if self.version in ("1", "2"):
            self._add_nodes(*numbers.rows(numbers.line(), ("i", 1), ("d", 3)))
        else:
            blocks, total = numbers.one("s", "s")
            if self.version == "4.1":
                numbers.one("s", "s")
            for _ in range(blocks):
                self._node_block(numbers)
            if sum(map(len, self.tags)) != total:
                numbers.damaged("does not have as many nodes as it says")
        numbers.end()

    def _node_block(self, numbers: Numbers) -> None:
        """The nodes of one entity in format 4."""
        one, other, parametric = numbers.one("i", "i", "i")
        dim = one if self.version == "4.1" else other
        if not 0 <= dim <= 3 or parametric not in (0, 1):
            numbers.damaged("has an entity that is none")
        width = 3 + dim * parametric
        count = numbers.count()
        if self.version == "4.1":
            (tags,) = numbers.rows(count, ("s", 1))
            (places,) = numbers.rows(count, ("d", width))
        else:
            tags, places = numbers.rows(count, ("i", 1), ("d", width))
        self._add_nodes(tags, places)

    def _add_nodes(self, tags: NDArray[Any], places: NDArray[Any]) -> None:
        self.tags.append(tags.ravel())
        self.places.append(places[:, :3])

    def _elements(self, name: str, data: bytes) -> None:
        numbers = Numbers(name, data, self.order)
        if self.version == "1" or (self.version == "2" and self.order is None):
            total, read = numbers.count(), self._listed(numbers)
        elif self.version == "2":
            total = numbers.line()
            read = 0
            while read < total:
                read += self._followed(numbers)
        else:
            blocks, total = numbers.one("s", "s")
            if self.version == "4.1":
                numbers.one("s", "s")
            read = sum(self._element_block(numbers) for _ in range(blocks))
        if read != total:
            numbers.damaged("does not have as many elements as it says")
        numbers.end()

    def _element_block(self, numbers: Numbers) -> int:
        """The elements of one entity in format 4."""
        one, other, kind = numbers.one("i", "i", "i")
        dim, entity = (one, other) if self.version == "4.1" else (other, one)
        count = numbers.count()
        word = "s" if self.version == "4.1" else "i"
        _, nodes = numbers.rows(count, (word, 1), (word, _nodes_of(kind, numbers)))
        self._add_elements(kind, nodes, self.groups.get((dim, entity), []))
        return count

    def _followed(self, numbers: Numbers) -> int:
        """The elements behind one header of a binary file of format 2."""
        kind, count, n_tags = numbers.one("i", "i", "i")
        if count < 1 or n_tags < 0:
            numbers.damaged("has a count that is none")
        columns = ("i", 1), ("i", n_tags), ("i", _nodes_of(kind, numbers))
        _, tags, nodes = numbers.rows(count, *columns)
        self._add_tagged(kind, tags, nodes)
        return count

    def _listed(self, numbers: Numbers) -> int:
        """The elements of a text of format 1 or 2, in runs of rows of the same width."""
        flat, at, count = numbers.rest(), 0, 0
        fixed = 5 if self.version == "1" else 3
        while at < len(flat):
            if at + fixed > len(flat):
                numbers.damaged("is shorter than its numbers say")
            kind = _small(flat[at + 1], numbers)
            n_nodes = _nodes_of(kind, numbers)
            n_tags = 0 if self.version == "1" else _small(flat[at + 2], numbers)
            width, chunk = fixed + n_tags + n_nodes, CHUNK
            same = 0
            while True:
                rows = (len(flat) - at) // width
                table = flat[at : at + min(rows, chunk) * width].reshape(-1, width)
                differs = np.flatnonzero((table[:, 1:3] != table[:1, 1:3]).any(axis=1))
                if self.version == "1":
                    differs = np.flatnonzero(table[:, 1] != kind)
                same = int(differs[0]) if len(differs) else len(table)
                if same < len(table) or len(table) == rows:
                    break
                chunk *= 8
            if same == 0:
                numbers.damaged("is shorter than its numbers say")
            run = numbers.whole(table[:same])
            tags = run[:, 2:4] if self.version == "1" else run[:, 3 : 3 + n_tags]
            self._add_tagged(kind, tags, run[:, fixed + n_tags :])
            at, count = at + same * width, count + same
        return count

    def _add_tagged(self, kind: int, tags: Ints, nodes: Ints) -> None:
        """Elements whose first tag is their physical group, in parts of equal groups."""
        groups = np.abs(tags[:, 0]) if tags.shape[1] else np.zeros(len(nodes), np.int64)
        for group in np.unique(groups):
            self._add_elements(kind, nodes[groups == group], [int(group)])

    def _add_elements(self, kind: int, nodes: Ints, groups: list[int]) -> None:
        for word, kinds in OTHERS.items():
            if kind in kinds and len(nodes):
                raise DamagedError(f"has {word}; triangles only are understood")
        if kind in LINES:
            self.elements[1].append((nodes[:, :2], groups))
        elif kind in TRIANGLES:
            self.elements[2].append((nodes[:, :3], groups))

    def contents(self) -> Contents:
        """Put the parts together."""
        if not self.version:
            raise DamagedError("is not a gmsh mesh: it has no $MeshFormat")
        if not sum(len(nodes) for nodes, _ in self.elements[2]):
            raise DamagedError("has no triangles; was it saved without a physical surface?")
        if not self.tags:
            raise DamagedError("is damaged: it has no nodes")
        tags, places = np.concatenate(self.tags), np.concatenate(self.places)
        order = np.argsort(tags, kind="stable")
        tags, places = tags[order], places[order]
        repeated = int((np.diff(tags) == 0).sum())
        if repeated:
            raise DamagedError(f"is damaged: {repeated} nodes have the number of another one")
        triangles, surfaces = self._grouped(2, tags)
        lines, curves = self._grouped(1, tags)
        used = np.unique(np.concatenate([triangles.ravel(), lines.ravel()]))
        if not (np.abs(places[used]) <= FARTHEST).all():
            raise DamagedError(f"has coordinates that are no numbers up to {FARTHEST:g} mm")
        return Contents(places, triangles, lines, surfaces, curves)

    def _grouped(self, dim: int, tags: Ints) -> tuple[Ints, dict[str, Ints]]:
        """The elements of a dimension, each once, and the rows of each physical group."""
        parts = self.elements[dim]
        if not parts:
            return np.empty((0, dim + 1), np.int64), {}
        wanted = np.concatenate([nodes for nodes, _ in parts])
        number = np.minimum(np.searchsorted(tags, wanted), len(tags) - 1)
        lost = tags[number] != wanted
        if lost.any():
            raise DamagedError(
                f"is damaged: an element has node {wanted[lost][0]}, which is not in the file"
            )
        # Format 2 writes an element once for each of its groups.
        _, first, row = np.unique(_keys(number), return_index=True, return_inverse=True)
        kept = np.argsort(np.argsort(first))  # in the order of the file
        row = kept[row]
        rows: dict[str, list[Ints]] = {}
        start = 0
        for nodes, groups in parts:
            for group in groups:
                if group:
                    name = self.names.get((dim, group)) or f"{WORDS[dim]}_{group}"
                    rows.setdefault(name, []).append(row[start : start + len(nodes)])
            start += len(nodes)
        named = {name: np.unique(np.concatenate(parts)) for name, parts in sorted(rows.items())}
        return number[np.sort(first)], {name: found for name, found in named.items() if len(found)}


def _keys(elements: Ints) -> Ints:
    """One number for each element, the same for the same nodes in any order."""
    n = int(elements.max(initial=0)) + 1
    key, *others = np.sort(elements, axis=1).T
    for i, nodes in enumerate(others):
        if i:  # so that the product is a number of eight bytes on any mesh
            key = np.unique(key, return_inverse=True)[1]
        key = key * n + nodes
    return key


def _nodes_of(kind: int, numbers: Numbers) -> int:
    """The number of nodes of an element type."""
    if kind not in N_NODES:
        numbers.damaged(f"has elements of type {kind}, which is not known")
    return N_NODES[kind]


def _small(value: float, numbers: Numbers) -> int:
    if not 0 <= value < 1e6 or value != int(value):
        numbers.damaged("has a type or a count that is none")
    return int(value)


def _decoded(data: bytes) -> str:
    """Text as UTF-8, or else as Windows writes it."""
    try:
        return data.decode()
    except UnicodeDecodeError:
        return data.decode("latin-1")
