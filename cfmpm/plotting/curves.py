"""Curves: a quantity against the number of points, the domain radius or the run time."""

from __future__ import annotations

from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from cfmpm.plotting.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILLION,
)

# Colour and marker both differ, so that curves can be distinguished without colour.
STYLES = (
    (BLUE, "o"),
    (VERMILLION, "s"),
    (GREEN, "^"),
    (ORANGE, "D"),
    (PURPLE, "v"),
    (SKY, "P"),
    (BLACK, "x"),
)


def draw_curve(
    axes: Axes,
    x: ArrayLike,
    y: ArrayLike,
    label: str,
    style: int,
    *,
    line: str = "-",
    hollow: bool = False,
) -> Axes:
    """Draw a curve with a marker at each value.

    Parameters
    ----------
    axes : Axes
    x, y : (n,) float
    label : str
        Label in the legend.
    style : int
        Index of colour and marker in `STYLES`.
    line : str
        Line style of matplotlib; "" for markers alone.
    hollow : bool
        Large open markers, which leave a curve beneath them visible.

    Returns
    -------
    Axes
    """
    colour, marker = STYLES[style % len(STYLES)]
    size, inside = (8.0, "none") if hollow else (4.0, colour)
    axes.plot(
        x,
        y,
        linestyle=line or "none",
        color=colour,
        marker=marker,
        markersize=size,
        markerfacecolor=inside,
        linewidth=1.1,
        label=label,
    )
    return axes


def draw_level(axes: Axes, value: float, label: str, *, line: str = "--") -> Axes:
    """Draw a horizontal line at a reference value."""
    axes.axhline(value, color=BLACK, linestyle=line, linewidth=0.9, label=label, zorder=1)
    return axes


def draw_power(axes: Axes, x: tuple[float, float], y: float, exponent: float, label: str) -> Axes:
    """Draw y (x / x[0])^exponent between two abscissae, as a guide in logarithmic axes."""
    ends = [y, y * (x[1] / x[0]) ** exponent]
    axes.plot(x, ends, ":", color=GREY, linewidth=1.1, zorder=1)
    axes.annotate(
        label, (x[1], ends[1]), xytext=(2, 0), textcoords="offset points", color=GREY, va="center"
    )
    return axes
