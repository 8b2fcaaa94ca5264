"""Geometry and load of the specimens of sections 5.3 to 5.5, as the paper's drawings of them."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from cfmpm.plotting.style import BLACK, BLUE, GREEN, REGIONS, length_axes
from cfmpm.scene import Scene
from cfmpm.scene.geometry import BodyShape
from workflows.growth.drawing import SMALL, arrow, dimension, draw_body

# Marks along an edge.
MARKS = 7


def draw_sheared(axes: Axes, scene: Scene) -> None:
    """Draw the plate of section 5.3: clamped below, pulled sideways above."""
    _body(axes, scene)
    for x in np.linspace(0.0, 60.0, MARKS):
        arrow(axes, (x, 165.0), (x + 10.0, 165.0))
        axes.plot([x + 5.0 - 4.0, x + 5.0], [-5.0, 0.0], color=GREEN, lw=0.8)
    axes.text(35.0, 168.0, "100 MPa", color=BLUE, ha="center", va="bottom", fontsize=SMALL)
    axes.text(35.0, -8.0, "u = 0", color=GREEN, ha="center", va="top", fontsize=SMALL)
    dimension(axes, (0.0, 70.0), (35.0, 70.0), "35", (0, -6))
    dimension(axes, (0.0, 20.0), (70.0, 20.0), "70", (0, 6))
    dimension(axes, (60.0, 0.0), (60.0, 160.0), "160", (-9, 30))
    axes.set_xlim(-6.0, 80.0)
    axes.set_ylim(-22.0, 182.0)


def draw_two_holes(axes: Axes, scene: Scene, *, lengths: bool) -> None:
    """Draw the plate of section 5.4 with its dimensions, or with its load."""
    _body(axes, scene)
    axes.set_xlim(-1.2, 21.2)
    axes.set_ylim(-3.0, 13.0)
    if not lengths:
        for x in np.linspace(0.5, 19.5, MARKS):
            arrow(axes, (x, 10.0), (x, 11.4))
            arrow(axes, (x, 0.0), (x, -1.4))
        for y, side in ((11.6, "bottom"), (-1.6, "top")):
            text = "u$_y$ = 1 mm outwards, u$_x$ = 0"
            axes.text(10.0, y, text, color=BLUE, ha="center", va=side, fontsize=SMALL)
        return
    dimension(axes, (0.0, -1.0), (20.0, -1.0), "l = 20", (0, -7))
    dimension(axes, (10.5, 0.0), (10.5, 10.0), "h = 10", (16, 0))
    dimension(axes, (0.0, 3.6), (1.0, 3.6), "a = 1", (14, 2))
    dimension(axes, (1.8, 0.0), (1.8, 2.85), "h$_0$ = 2.85", (24, 0))
    dimension(axes, (0.0, 11.0), (3.0, 11.0), "d = 3", (0, 7))
    dimension(axes, (6.0, 7.0), (6.0, 10.0), "d = 3", (15, 0))
    dimension(axes, (3.0, 7.0), (3.0 + 2.0**0.5, 7.0 + 2.0**0.5), "R = 2", (0, -12))


def draw_beam(axes: Axes, scene: Scene, a: float, b: float) -> None:
    """Draw the beam of section 5.5 with its crack of length a at b from the middle [mm]."""
    _body(axes, scene)
    arrow(axes, (254.0, 240.0), (254.0, 203.2))
    axes.text(262.0, 222.0, "P = 50 N", color=BLUE, va="center", fontsize=SMALL)
    for x in (25.4, 482.6):
        axes.plot([x], [-7.0], "^", color=GREEN, ms=5.0)
    foot = 254.0 - b
    dimension(axes, (foot, -24.0), (254.0, -24.0), f"b = {b:g}", (0, -7))
    axes.plot([foot, foot], [-30.0, 0.0], color=BLACK, lw=0.4)
    axes.plot([254.0, 254.0], [-30.0, 203.2], color=BLACK, lw=0.4, ls="--")
    axes.annotate(
        f"a = {a:g}",
        (foot, a),
        (-30, 4),
        textcoords="offset points",
        ha="center",
        fontsize=SMALL,
        arrowprops={"arrowstyle": "-", "lw": 0.5},
    )
    dimension(axes, (340.0, 0.0), (340.0, 203.2), "203.2", (14, 0))
    dimension(axes, (25.4, -58.0), (482.6, -58.0), "457.2", (0, -7))
    dimension(axes, (190.0, 120.65), (190.0, 171.45), "50.8", (12, 0))
    dimension(axes, (190.0, 69.85), (190.0, 120.65), "50.8", (12, 0))
    dimension(axes, (186.0, 0.0), (186.0, 69.85), "69.85", (13, 0))
    dimension(axes, (152.4, 215.0), (254.0, 215.0), "101.6", (0, 6))
    axes.set_xlim(-12.0, 520.0)
    axes.set_ylim(-90.0, 250.0)


def _body(axes: Axes, scene: Scene) -> None:
    outline = np.array(BodyShape.of(scene).outline.exterior.coords)
    axes.add_patch(Polygon(outline, facecolor=REGIONS[0], edgecolor="none", zorder=0))
    for hole in BodyShape.of(scene).holes.values():
        axes.add_patch(Polygon(np.array(hole.exterior.coords), facecolor="white", zorder=0))
    draw_body(axes, scene)
    length_axes(axes)
