"""Check of figures: each axis has its unit in brackets after its name."""

from __future__ import annotations

from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter


def require_units(figure: Figure) -> None:
    """Raise an error for a figure with an axis of numbers without a unit."""
    for axes in figure.axes:
        # Colour bars are drawn by functions that have tests of their own.
        if axes.get_visible() and axes.get_label() != "<colorbar>":
            for axis in (axes.xaxis, axes.yaxis):
                said = (axes.get_title(loc="left"), axis.get_label_text())
                assert not _has_numbers(axis) or said[1].endswith("]"), said


def _has_numbers(axis: Axis) -> bool:
    """Inner axes have no tick labels, twins share an axis, and categories have names."""
    shown = axis.get_visible() and any(label.get_visible() for label in axis.get_ticklabels())
    return shown and not isinstance(axis.get_major_formatter(), FuncFormatter)
