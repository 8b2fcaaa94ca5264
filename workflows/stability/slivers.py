"""Grids with slivers: the plate of the paper in squares, cut into needles and caps."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np

from cfmpm.body.grid import Floats, Ints

WIDTH, HEIGHT, CRACK = 500.0, 1000.0, 100.0  # mm
COLUMNS, ROWS = 20, 40
CAPS = 40


def write_plate(
    path: str | Path, kind: Literal["none", "needles", "caps"], thinness: float
) -> None:
    """Write the plate with its crack as a gmsh mesh file of three-node triangles.

    Parameters
    ----------
    path : Path
    kind : {"none", "needles", "caps"}
        needles: two rows and two columns of squares next to the crack become two each, one of
        them thin; caps: triangles get a node next to the middle of a side.
    thinness : float
        Height of the thin ones over their length.

    Notes
    -----
    Curves: bottom, right, top, left, crack.
    """
    x, y = np.linspace(0.0, WIDTH, COLUMNS + 1), np.linspace(0.0, HEIGHT, ROWS + 1)
    if kind == "needles":
        size = HEIGHT / ROWS
        near = [HEIGHT / 2 + (1 + thinness) * size, HEIGHT / 2 - (2 + thinness) * size]
        y = np.sort(np.append(y, near))
        x = np.sort(np.append(x, [CRACK + (1 + thinness) * size, CRACK + (8 + thinness) * size]))
    number = np.arange(len(x) * len(y)).reshape(len(x), len(y))
    nodes = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    a, b = number[:-1, :-1].ravel(), number[1:, :-1].ravel()
    c, d = number[1:, 1:].ravel(), number[:-1, 1:].ravel()
    triangles = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    if kind == "caps":
        nodes, triangles = _with_caps(nodes, triangles, thinness)
    middle = int(np.argmin(np.abs(y - HEIGHT / 2)))
    lines = {
        "bottom": number[:, 0],
        "right": number[-1],
        "top": number[:, -1],
        "left": number[0],
        "crack": number[x <= CRACK, middle],
    }
    _write(Path(path), nodes, triangles, lines)


def _with_caps(nodes: Floats, triangles: Ints, thinness: float) -> tuple[Floats, Ints]:
    """Cut some triangles into three by a node next to the middle of their first side."""
    chosen = np.random.default_rng(0).choice(len(triangles), CAPS, replace=False)
    i, j, k = triangles[chosen].T
    middle = 0.5 * (nodes[i] + nodes[j])
    new = len(nodes) + np.arange(CAPS)
    nodes = np.concatenate([nodes, middle + thinness * (nodes[k] - middle)])
    whole = np.delete(triangles, chosen, axis=0)
    parts = [np.column_stack([p, q, new]) for p, q in ((i, j), (j, k), (k, i))]
    return nodes, np.concatenate([whole, *parts])


def _write(path: Path, nodes: Floats, triangles: Ints, lines: dict[str, Ints]) -> None:
    """Write gmsh's format 2.2, in text."""
    names = [f'1 {i} "{name}"' for i, name in enumerate(lines, 1)]
    rows = [(1, i, pair) for i, line in enumerate(lines.values(), 1) for pair in _pairs(line)]
    rows += [(2, 9, triangle) for triangle in triangles]
    text = [
        *("$MeshFormat", "2.2 0 8", "$EndMeshFormat"),
        *("$PhysicalNames", str(len(names) + 1), *names, '2 9 "plate"', "$EndPhysicalNames"),
        *("$Nodes", str(len(nodes))),
        *(f"{i} {x:.17g} {y:.17g} 0" for i, (x, y) in enumerate(nodes, 1)),
        *("$EndNodes", "$Elements", str(len(rows))),
        *(
            f"{i} {kind} 2 {tag} {tag} {' '.join(str(node + 1) for node in corners)}"
            for i, (kind, tag, corners) in enumerate(rows, 1)
        ),
        "$EndElements\n",
    ]
    path.write_text("\n".join(text), encoding="utf-8")


def _pairs(line: Ints) -> Ints:
    return np.column_stack([line[:-1], line[1:]])
