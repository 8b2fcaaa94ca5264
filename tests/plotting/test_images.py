"""Figures as a whole, compared with stored images.

Body and values are made by hand and text is removed: neither another grid generator nor
another font changes a figure. After an intended change, the failing test names the file
that is to replace the one in ``images``.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib
import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.testing.compare import compare_images
from matplotlib.testing.decorators import remove_ticks_and_titles
from structured import rectangle

from cfmpm.body.grid import Grid, build_grid
from cfmpm.output.variables import TIP_STATUS
from cfmpm.plotting import Mesh, draw_deformed, draw_paths, draw_tip_forces
from cfmpm.plotting.style import RC

IMAGES = Path(__file__).parent / "images"
# Root mean square over all pixels, of 255. Matplotlib 3.9 and 3.11 draw the same; a marker more or
# less, or of another colour, makes 1.3 to 2.6, a line 2.8 or more.
TOLERANCE = 1.0


@pytest.fixture
def grid() -> Grid:
    return build_grid(rectangle(8, 6, 8.0, 6.0, crack=(3, 0, 4)), "T3")


def opened(grid: Grid) -> np.ndarray:
    """Displacement that opens the crack, increasing with the distance from the tip [mm]."""
    x, y = grid.nodes.T
    upper = np.zeros(len(x), bool)
    upper[grid.elements[grid.nodes[grid.elements].mean(axis=1)[:, 1] > 3.0]] = True
    side = np.where(upper & (y >= 3.0), 1.0, -1.0)
    return np.column_stack([0.02 * x, 0.1 * side * np.sqrt(np.clip(4.0 - x, 0.0, None))])


def deformed(axes: Axes, grid: Grid) -> None:
    mesh = Mesh.of_grid(grid)
    u = opened(grid)
    x, y = mesh.nodes[mesh.faces].mean(axis=1).T
    said = {"units": "MPa", "long_name": "stress"}
    fields = xr.Dataset(
        {
            "node_x": ("node", mesh.nodes[:, 0]),
            "node_y": ("node", mesh.nodes[:, 1]),
            "face_nodes": (("face", "corner"), mesh.faces),
            "element": ("face", mesh.element),
            "u_x": (("time", "node"), u[None, :, 0]),
            "u_y": (("time", "node"), u[None, :, 1]),
            "von_mises": (("time", "face"), 100.0 / np.hypot(x - 4.0, y - 3.0)[None], said),
        },
    )
    draw_deformed(axes, fields, factor=5.0)


def tip_forces(axes: Axes, grid: Grid) -> None:
    x, y = grid.nodes.T
    force = np.column_stack([np.cos(x), np.sin(y)]) * np.exp(-np.hypot(x - 4.0, y - 3.0))[:, None]
    draw_tip_forces(axes, grid, force, grid.tips[0], 2.0)


def paths(axes: Axes, grid: Grid) -> None:
    status = [TIP_STATUS.index("growing")] * 3 + [TIP_STATUS.index("arrived_boundary")]
    history = xr.Dataset(
        {
            "tip_x": (("step", "tip"), [[4.0], [5.0], [6.0], [8.0]]),
            "tip_y": (("step", "tip"), [[3.0], [3.5], [4.5], [5.0]]),
            "tip_status": (("step", "tip"), np.array(status)[:, None]),
        },
        {"tip": ["crack_1"]},
    )
    draw_paths(axes, history, grid, [[5.0, 3.4], [6.0, 4.6]])


@pytest.mark.parametrize("draw", [deformed, tip_forces, paths])
def test_picture_looks_as_it_did(draw, grid: Grid, tmp_path: Path) -> None:
    with matplotlib.rc_context(RC):
        figure = Figure(figsize=(4.0, 3.0), dpi=80)
        FigureCanvasAgg(figure)
        draw(figure.add_subplot(), grid)
        remove_ticks_and_titles(figure)
        for axes in figure.axes:
            axes.set(xlabel="", ylabel="")
            if axes.get_legend():
                axes.get_legend().remove()
        name = f"{draw.__name__}.png"
        figure.savefig(tmp_path / name)
    assert compare_images(str(IMAGES / name), str(tmp_path / name), TOLERANCE) is None
