"""Small structured triangulations for tests without a mesh generator."""

from __future__ import annotations

import numpy as np

from cfmpm.body.grid import Triangulation


def rectangle(
    nx: int,
    ny: int,
    width: float = 1.0,
    height: float = 1.0,
    *,
    shake: float = 0.0,
    crack: tuple[int, int, int] | None = None,
    seed: int = 0,
) -> Triangulation:
    """Rectangle of nx by ny cells of two triangles, corner at the origin.

    `shake` moves inner nodes off the crack by up to half this fraction of a cell (below 0.5 no
    triangle is inverted); `crack` is (row, first column,
    last column) of a horizontal crack line of grid nodes.
    """
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(nx + 1.0), np.arange(ny + 1.0), indexing="ij")
    inner = np.zeros((nx + 1, ny + 1), bool)
    inner[1:-1, 1:-1] = True
    if crack is not None:
        inner[crack[1] : crack[2] + 1, crack[0]] = False
    for part in (x, y):
        part += shake * rng.uniform(-0.5, 0.5, part.shape) * inner
    nodes = np.column_stack([x.ravel() * width / nx, y.ravel() * height / ny])
    number = np.arange(nodes.shape[0]).reshape(nx + 1, ny + 1)
    a, b = number[:-1, :-1].ravel(), number[1:, :-1].ravel()
    c, d = number[1:, 1:].ravel(), number[:-1, 1:].ravel()
    one = np.column_stack([a, b, c, a, c, d]).reshape(-1, 3)
    other = np.column_stack([a, b, d, b, c, d]).reshape(-1, 3)
    flip = rng.random(len(a)) < 0.5
    triangles = np.where(np.repeat(flip, 2)[:, None], other, one)

    def pairs(line: np.ndarray) -> np.ndarray:
        return np.column_stack([line[:-1], line[1:]])

    cracks = {}
    if crack is not None:
        row, first, last = crack
        cracks["crack_1"] = pairs(number[first : last + 1, row])
    return Triangulation(
        nodes=nodes,
        triangles=triangles,
        regions=np.zeros(len(triangles), np.int64),
        region_names=("body",),
        edges={
            "bottom": pairs(number[:, 0]),
            "right": pairs(number[-1, :]),
            "top": pairs(number[::-1, -1]),
            "left": pairs(number[0, ::-1]),
        },
        cracks=cracks,
        points={},
    )
