"""Mesh files made by hand: a square of cells of two triangles, with lines and cracks."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

from meshing_scenes import STEEL

from cfmpm.scene.model import Scene

N = 8  # squares along a side of 8 mm
Pair = tuple[int, int]
XY = tuple[int, int]


def node(x: int, y: int) -> int:
    """The number of the node at a place."""
    return y * (N + 1) + x


def along(*places: XY) -> list[Pair]:
    """Node pairs along straight lines between points, one for each unit of length."""
    pairs = []
    for (x, y), (u, v) in pairwise(places):
        n = max(abs(u - x), abs(v - y))
        steps = [(x + (u - x) * i // n, y + (v - y) * i // n) for i in range(n + 1)]
        pairs += [(node(*a), node(*b)) for a, b in pairwise(steps)]
    return pairs


@dataclass
class Square:
    """Nodes, triangles and lines that a test can spoil before it writes them."""

    nodes: list[tuple[float, float]] = field(
        default_factory=lambda: [(float(x), float(y)) for y in range(N + 1) for x in range(N + 1)]
    )
    triangles: list[tuple[int, int, int]] = field(
        default_factory=lambda: [
            t
            for y in range(N)
            for x in range(N)
            for t in (
                (node(x, y), node(x + 1, y), node(x + 1, y + 1)),
                (node(x, y), node(x + 1, y + 1), node(x, y + 1)),
            )
        ]
    )
    lines: dict[str, list[Pair]] = field(
        default_factory=lambda: {
            "bottom": along((0, 0), (N, 0)),
            "top": along((N, N), (0, N)),
        }
    )
    surfaces: dict[str, list[int]] = field(default_factory=dict)

    def open_above(self, places: list[XY]) -> dict[int, int]:
        """Double the nodes of a horizontal row; triangles above it get the new nodes."""
        own = {}
        for x, y in places:
            own[node(x, y)] = len(self.nodes)
            self.nodes.append((float(x), float(y)))
        height = places[0][1]
        for i, triangle in enumerate(self.triangles):
            if min(self.nodes[k][1] for k in triangle) >= height:
                self.triangles[i] = tuple(own.get(k, k) for k in triangle)
        return own

    def write(self, path: Path) -> Path:
        """Write it in format 2.2."""
        names = [(1, name) for name in self.lines] + [(2, name) for name in self.surfaces]
        rows = [
            f"1 2 {g} {g} {a + 1} {b + 1}"
            for g, pairs in enumerate(self.lines.values(), 1)
            for a, b in pairs
        ]
        whole = {len(names) + 1: range(len(self.triangles))}
        groups = {len(self.lines) + i: rows for i, rows in enumerate(self.surfaces.values(), 1)}
        rows += [
            f"2 2 {g} 1 " + " ".join(str(k + 1) for k in self.triangles[i])
            for g, chosen in (groups | whole).items()
            for i in chosen
        ]
        path.write_text(
            "\n".join(
                [
                    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames",
                    str(len(names)),
                    *(f'{dim} {g} "{name}"' for g, (dim, name) in enumerate(names, 1)),
                    "$EndPhysicalNames\n$Nodes",
                    str(len(self.nodes)),
                    *(f"{i} {x!r} {y!r} 0" for i, (x, y) in enumerate(self.nodes, 1)),
                    "$EndNodes\n$Elements",
                    str(len(rows)),
                    *(f"{i} {row}" for i, row in enumerate(rows, 1)),
                    "$EndElements\n",
                ]
            )
        )
        return path


PULL = (
    {"edge": "top", "traction": (0, 10)},
    {"edge": "bottom", "displacement": {"y": 0}},
    {"point": (0, 0), "displacement": {"x": 0}},
)


def scene_of(path: Path, *, cracks=(), regions=(), loads=PULL, **keys) -> Scene:
    """A scene of a mesh file."""
    return Scene(
        name="test",
        mesh_file={
            "file": str(path),
            "cracks": list(cracks),
            "regions": [{"name": name, "material": STEEL} for name in regions],
        },
        material=STEEL,
        loads=list(loads),
        **keys,
    )
