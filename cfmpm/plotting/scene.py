"""Figures of a scene: body, cracks, loads, supports, grid."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from cfmpm.body.grid import Floats, Grid, Ints
from cfmpm.body.loads import Boundary, Loading
from cfmpm.plotting.mesh import draw_cracks, draw_grid
from cfmpm.plotting.style import (
    BLUE,
    GREEN,
    LIGHT_GREY,
    ORANGE,
    PURPLE,
    REGIONS,
    as_label,
    length_axes,
)
from cfmpm.registry.loads import LOADS
from cfmpm.scene.loads import Load
from cfmpm.scene.model import Scene

# Symbols along a loaded part, and the length of an arrow relative to the size of the body.
SYMBOLS = 9
ARROW = 0.07
# Most entries of the legend: more would be higher than the picture.
ENTRIES = 14


def draw_scene(
    axes: Axes, scene: Scene, grid: Grid, loading: Loading, radii: Sequence[float] = ()
) -> Axes:
    """Draw a scene on its grid.

    Parameters
    ----------
    axes : Axes
    scene : Scene
        Expanded, with names of all loads.
    grid : Grid
    loading : Loading
    radii : sequence of float
        Radius of the domain around each tip [mm].

    Returns
    -------
    Axes
        With arrows for loads, wedges for supports, and one entry of the legend for each.
    """
    tints = np.array(REGIONS)[grid.regions % len(REGIONS)]
    triangles = grid.nodes[grid.triangles]
    # The hairline hides seams between adjacent areas of the same colour.
    axes.add_collection(PolyCollection(list(triangles), facecolors=tints, edgecolors=tints, lw=0.2))
    draw_grid(axes, grid, colour=LIGHT_GREY, width=0.3)
    draw_cracks(axes, grid)
    for tip, radius in zip(grid.tips, radii, strict=False):
        x, y = grid.nodes[tip.node]
        axes.add_patch(Circle((x, y), radius, fill=False, color=GREEN, lw=1.0, ls="--"))
    for tip in grid.tips:
        x, y = grid.nodes[tip.node]
        axes.annotate(as_label(tip.name), (x, y), (4, 4), textcoords="offset points", fontsize=8)
    for load in scene.loads:
        _draw_load(axes, load, grid, loading.boundaries.get(str(load.name)))
    axes.margins(0.12)
    axes.autoscale_view()
    length_axes(axes)
    axes.set_title(_title(scene, grid, loading))
    _legend(axes)
    return axes


def _legend(axes: Axes) -> None:
    """Name the loads beside the axes; of very many those that differ, and how many there are."""
    handles, labels = axes.get_legend_handles_labels()
    if len(handles) > ENTRIES:
        alike: dict[str, list[int]] = {}
        for i, label in enumerate(labels):
            alike.setdefault(label.split(": ", 1)[-1], []).append(i)
        kept = list(alike.values())[: ENTRIES - 1]
        names = [label.split(": ", 1)[0] for label in labels]
        texts = [
            labels[i] if len(same) == 1 else f"{names[i]} and {len(same) - 1} like it: {what}"
            for what, same in zip(alike, kept, strict=False)
            for i in same[:1]
        ]
        handles = [handles[same[0]] for same in kept]
        left = len(labels) - sum(map(len, kept))
        if left:
            handles.append(Line2D([], [], linestyle="none"))
            texts.append(f"and {left} more loads")
        labels = texts
    if handles:
        axes.legend(handles, labels, loc="upper left", bbox_to_anchor=(1.0, 1.0), labelspacing=0.8)


def _title(scene: Scene, grid: Grid, loading: Loading) -> str:
    held = f"\n{loading.held} rigid motions held at nodes" if loading.held else ""
    return f"{scene.name}: {len(grid.elements)} triangles {scene.mesh.element}{held}"


def _draw_load(axes: Axes, load: Load, grid: Grid, boundary: Boundary | None) -> None:
    """Draw one load or support at its place."""
    size = ARROW * np.ptp(grid.nodes, axis=0).max()
    kind, what = LOADS[load.kind], load.kind.replace("_", " ")
    if not kind.places:
        corners = grid.nodes[grid.triangles]
        centre = np.average(corners.mean(axis=1), axis=0, weights=grid.areas)
        label = f"{as_label(load.name)}: {what} {_vector(load.value)} {kind.unit}"
        _arrows(axes, centre[None], np.array(load.value), size, PURPLE, label, np.zeros(2))
        return
    if boundary is None:
        return
    chosen = _spread_out(grid.nodes[boundary.nodes], SYMBOLS)
    x = grid.nodes[boundary.nodes[chosen]]
    if len(x) > 1:  # so that the arrows in a hole do not cross it
        size = float(np.clip(0.35 * np.ptp(x, axis=0).max(), 0.5 * size, size))
    outward = _outward_normals(grid, boundary.nodes)[chosen]
    if isinstance(load.value, tuple):
        label = f"{as_label(load.name)}: {what} {_vector(load.value)} {kind.unit}"
        _arrows(axes, x, np.array(load.value), size, BLUE, label, outward)
        return
    if not kind.holds:
        label = f"{as_label(load.name)}: {what} {load.value} {kind.unit}"
        axes.plot(*x.T, ".", color=BLUE, zorder=4, label=label, clip_on=False)
        return
    given = {"x": load.value.x, "y": load.value.y}
    label = ", ".join(f"u_{a} = {value:g} mm" for a, value in given.items() if value is not None)
    label = f"{as_label(load.name)}: {label}"
    motion = np.array([value or 0.0 for value in given.values()])
    if motion.any():
        _arrows(axes, x, motion, size, ORANGE, label, np.zeros(2))
        return
    # A wedge is for one held direction, a square for both.
    held = [axis for axis, value in given.items() if value is not None]
    sideways = ">" if outward[:, 0].mean() <= 0.0 else "<"
    upright = "^" if outward[:, 1].mean() <= 0.0 else "v"
    marker = "s" if len(held) == 2 else {"x": sideways, "y": upright}[held[0]]
    axes.plot(*x.T, marker, color=GREEN, markersize=5, zorder=4, label=label, clip_on=False)


def _arrows(
    axes: Axes,
    x: Floats,
    vector: Floats,
    length: float,
    colour: str,
    label: str,
    outward: Floats,
) -> None:
    """Draw arrows at points, where tension starts and pressure ends.

    Arrows along the boundary are drawn beside it and half as long, so that they do not form a line.
    """
    direction = vector / (np.hypot(*vector) or 1.0)
    pull = np.broadcast_to(outward @ direction, len(x))[:, None]
    along = (np.abs(pull) < 0.1) & np.broadcast_to(outward, x.shape).any(axis=1, keepdims=True)
    step = length * direction * np.where(along, 0.5, 1.0)
    tails = np.where(pull < 0.0, x - step, x)
    tails = np.where(along, x - 0.5 * step + 0.25 * length * outward, tails)
    axes.quiver(
        *tails.T,
        *step.T,
        angles="xy",
        scale_units="xy",
        scale=1.0,
        width=0.004,
        color=colour,
        label=label,
        zorder=4,
    )
    axes.update_datalim(np.concatenate([tails, tails + step]))


def _vector(value: tuple[float, float]) -> str:
    return f"({value[0]:.4g}, {value[1]:.4g})"


def _outward_normals(grid: Grid, nodes: Ints) -> Floats:
    """Outward unit vectors at nodes of a loaded part, (k, 2)."""
    edges = np.concatenate(list(grid.edges.values()))
    within = np.isin(edges, nodes).all(axis=1)
    if within.any():  # else a single node, for which the adjacent edges are taken
        edges = edges[within]
    along = grid.nodes[edges[:, 1]] - grid.nodes[edges[:, 0]]
    # The body is on the left of its edges.
    normals = np.zeros_like(grid.nodes)
    for column in edges.T:
        np.add.at(normals, column, np.column_stack([along[:, 1], -along[:, 0]]))
    length = np.hypot(*normals[nodes].T)[:, None]
    return np.divide(normals[nodes], length, out=normals[nodes], where=length > 0.0)


def _spread_out(x: Floats, most: int) -> Ints:
    """Choose points far from each other; on a straight line they are evenly spaced."""
    chosen = [int(np.argmin(x.sum(axis=1)))]
    distance = np.hypot(*(x - x[chosen[0]]).T)
    while len(chosen) < most and distance.max() > 0.0:
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, np.hypot(*(x - x[chosen[-1]]).T))
    return np.array(chosen)
