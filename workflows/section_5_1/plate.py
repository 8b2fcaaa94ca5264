"""The plate of section 5.1 with its load and dimensions, as in Fig. 4 (a) of the paper."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from cfmpm.plotting.style import BLACK, BLUE, GREY, REGIONS, VERMILLION, length_axes
from cfmpm.scene.specimens.single_edge import SingleEdge

# Arrows of the traction along an edge, and their length relative to the height.
ARROWS, LONG = 7, 0.08


def draw_plate(axes: Axes, plate: SingleEdge, radius: float) -> None:
    """Draw outline, crack, domain, traction and dimensions of a plate.

    Parameters
    ----------
    axes : Axes
    plate : SingleEdge
        Under traction.
    radius : float
        Of the domain around the tip [mm].
    """
    width, height, crack = plate.width, plate.height, plate.crack_length
    body = Rectangle((0.0, 0.0), width, height, facecolor=REGIONS[0], edgecolor=BLACK, lw=0.9)
    axes.add_patch(body)
    axes.plot([0.0, crack], [height / 2, height / 2], color=VERMILLION, lw=2.0)
    turn = np.linspace(0.0, 2.0 * np.pi, 100)
    axes.plot(
        crack + radius * np.cos(turn), height / 2 + radius * np.sin(turn), "--", color=BLUE, lw=0.9
    )
    axes.annotate(
        f"domain, R = {radius:g} mm",
        (crack + 0.7 * radius, height / 2 + 0.7 * radius),
        xytext=(crack - 1.2 * radius, height / 2 + 2.6 * radius),
        color=BLUE,
        fontsize=7,
        arrowprops={"arrowstyle": "-", "color": BLUE, "lw": 0.6},
    )
    for x in np.linspace(0.0, width, ARROWS):
        for end, way in ((height, 1.0), (0.0, -1.0)):
            axes.annotate(
                "",
                (x, end + way * LONG * height),
                xytext=(x, end),
                arrowprops={"arrowstyle": "-|>", "color": BLUE, "lw": 0.8, "mutation_scale": 7},
            )
    load = f"{plate.traction:g} MPa"
    axes.text(width / 2, (1.0 + LONG) * height, load, ha="center", va="bottom", color=BLUE)
    axes.text(width / 2, -LONG * height, load, ha="center", va="top", color=BLUE)
    _dimension(axes, (0.0, 0.42 * height), (crack, 0.42 * height), f"a$_0$ = {crack:g} mm", "left")
    _dimension(axes, (0.0, 0.1 * height), (width, 0.1 * height), f"w = {width:g} mm")
    _dimension(axes, (0.88 * width, 0.0), (0.88 * width, height), f"h = {height:g} mm")
    length_axes(axes)
    frame_plate(axes, plate)


def frame_plate(axes: Axes, plate: SingleEdge) -> None:
    """Show a plate on the scale of `draw_plate`."""
    axes.set_xlim(-0.06 * plate.width, 1.06 * plate.width)
    axes.set_ylim(-0.15 * plate.height, 1.15 * plate.height)


def _dimension(
    axes: Axes,
    first: tuple[float, float],
    last: tuple[float, float],
    text: str,
    side: str = "center",
) -> None:
    """A length between two places, with its text beside its middle, or from its beginning on."""
    style = {"arrowstyle": "<->", "color": GREY, "lw": 0.7, "shrinkA": 0.0, "shrinkB": 0.0}
    axes.annotate("", last, xytext=first, arrowprops=style)
    upright = first[0] == last[0]
    middle = (0.5 * (first[0] + last[0]), 0.5 * (first[1] + last[1]))
    if side == "left":
        middle = (first[0] + 0.15 * (last[0] - first[0]), first[1])
    axes.annotate(
        text,
        middle,
        xytext=(-3, 50) if upright else (0, -3),
        textcoords="offset points",
        rotation=90 if upright else 0,
        ha="right" if upright else side,
        va="center" if upright else "top",
        fontsize=7,
    )
