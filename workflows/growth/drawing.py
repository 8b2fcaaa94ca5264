"""What the figures of growing cracks share: body, paths, arrows, references, legends."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.transforms import ScaledTranslation

from cfmpm.body.grid import Floats, Grid
from cfmpm.plotting.mesh import Mesh
from cfmpm.plotting.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    LIGHT_GREY,
    ORANGE,
    PURPLE,
    length_axes,
)
from cfmpm.scene import Scene
from cfmpm.scene.geometry import BodyShape

# Width of a figure: that of a page, 170 mm [inch].
WIDTH = 6.7
SMALL = 7  # letters of legends and dimensions [pt]
# Colours of what is computed, the same in all figures.
AS_PRINTED, BEST, RESET = BLUE, GREEN, ORANGE
OTHERS = (PURPLE, ORANGE)
CRACK = "initial crack"
# Of a legend from the axes, below the label of the abscissa [inch].
BELOW = -0.45


def draw_body(axes: Axes, scene: Scene) -> None:
    """Draw the boundary of a body and its initial cracks."""
    shape = BodyShape.of(scene)
    for ring in (shape.polygon.exterior, *shape.polygon.interiors):
        axes.plot(*np.array(ring.coords).T, color=BLACK, lw=0.8)
    for crack in shape.geometry.cracks:
        axes.plot(*np.array(crack.points).T, color=BLACK, lw=2.2, solid_capstyle="butt")
    length_axes(axes)


def draw_path(axes: Axes, path: Floats, label: str, colour: str, *, segments: bool) -> None:
    """Draw a path, with a dot at the end of each segment, or as a broad line beneath others."""
    if segments:
        axes.plot(*path.T, color=colour, lw=1.0, marker=".", ms=3.5, label=label, zorder=3)
    else:
        axes.plot(*path.T, color=colour, lw=2.2, alpha=0.8, label=label)


def draw_reference(axes: Axes, named: Mapping[str, Floats]) -> None:
    """Draw paths that are known otherwise, as open marks over all other paths."""
    for (label, points), marker in zip(named.items(), cycle("sD")):
        axes.plot(*points.T, marker, ms=4.0, mew=0.7, mfc="none", mec=GREY, label=label, zorder=4)


def draw_grown(axes: Axes, grid: Grid, scene: Scene, paths: Sequence[Floats]) -> None:
    """Draw cracks on their grid: a red arrow for each segment, as Figs 10 and 12 of the paper."""
    draw_mesh(axes, grid)
    draw_body(axes, scene)
    draw_arrows(axes, paths)


def draw_arrows(axes: Axes, paths: Sequence[Floats]) -> None:
    """Draw a red arrow for each segment of paths."""
    for path in paths:
        axes.quiver(
            *path[:-1].T,
            *np.diff(path, axis=0).T,
            angles="xy",
            scale_units="xy",
            scale=1.0,
            width=0.009,
            headwidth=3.0,
            headlength=3.5,
            headaxislength=3.0,
            color="red",
            zorder=3,
        )


def draw_mesh(axes: Axes, grid: Grid) -> None:
    """Draw the edges of all triangles."""
    mesh = Mesh.of_grid(grid)
    edges = list(mesh.nodes[np.concatenate(mesh.edges())])
    axes.add_collection(LineCollection(edges, colors=LIGHT_GREY, linewidths=0.3))
    axes.autoscale_view()
    length_axes(axes)


def draw_band(axes: Axes, paths: Sequence[Floats], label: str, colour: str) -> None:
    """Draw the paths of many grids as thin lines, with one entry of the legend."""
    for path in paths:
        axes.plot(*path.T, color=colour, lw=0.7, alpha=0.55)
    axes.plot([], [], color=colour, lw=1.2, label=label)


def write_lines(axes: Axes, lines: Sequence[str]) -> None:
    """Fill axes with lines of text."""
    axes.set_xticks([])
    axes.set_yticks([])
    axes.spines[:].set_visible(False)
    axes.text(0.0, 0.95, "\n".join(lines), va="top", fontsize=SMALL)


def legend_below(axes: Axes, columns: int = 1, *, crack: bool = False) -> None:
    """Name what is drawn below the axes, off the data."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    handles, labels = axes.get_legend_handles_labels()
    if crack:
        handles.append(Line2D([], [], color=BLACK, lw=2.2))
        labels.append(CRACK)
    axes.legend(
        handles,
        labels,
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        bbox_transform=axes.transAxes + ScaledTranslation(0.0, BELOW, figure.dpi_scale_trans),
        ncols=columns,
        fontsize=SMALL,
        borderaxespad=0.0,
    )


def arrow(axes: Axes, start: Sequence[float], end: Sequence[float], colour: str = BLUE) -> None:
    """Draw an arrow between two places."""
    style = {"arrowstyle": "-|>", "color": colour, "lw": 0.9, "mutation_scale": 7, "shrinkA": 0.0}
    axes.annotate("", tuple(end), xytext=tuple(start), arrowprops={**style, "shrinkB": 0.0})


def dimension(
    axes: Axes,
    first: tuple[float, float],
    last: tuple[float, float],
    text: str,
    at: tuple[float, float] = (0.0, 4.0),
) -> None:
    """Draw a length between two places, with its text at an offset from its middle [pt]."""
    style = {"arrowstyle": "<->", "color": GREY, "lw": 0.7, "shrinkA": 0.0, "shrinkB": 0.0}
    axes.annotate("", last, xytext=first, arrowprops={**style, "mutation_scale": 6})
    middle = (0.5 * (first[0] + last[0]), 0.5 * (first[1] + last[1]))
    axes.annotate(
        text, middle, at, textcoords="offset points", ha="center", va="center", fontsize=SMALL
    )
