"""Style of the figures: colours, sizes, and atomic writing of files."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from string import ascii_lowercase
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cfmpm.body.grid import Floats
from cfmpm.output.files import written_aside_by_name

# Okabe and Ito (2008): distinguishable with any kind of colour vision.
BLACK = "#000000"
ORANGE = "#E69F00"
SKY = "#56B4E9"
GREEN = "#009E73"
BLUE = "#0072B2"
VERMILLION = "#D55E00"
PURPLE = "#CC79A7"
GREY = "#8C8C8C"
LIGHT_GREY = "#C4C4C4"

# Tints of the body and of its regions.
REGIONS = ("#F2F2F2", "#CFE6F5", "#FBE3B5", "#CDEBDD", "#F3D9E6")

STRESS_MAP = "viridis"

RESOLUTION = 200  # dots per inch
# Width of a legend beside the axes [inch].
LEGEND, COLOUR_BAR = 2.6, 0.9
RC: dict[Any, Any] = {
    "axes.axisbelow": True,
    "axes.labelsize": 9,
    "axes.linewidth": 0.6,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 9,
    "font.family": "DejaVu Sans",  # included in matplotlib: the same on every machine
    "font.size": 8,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "xtick.labelsize": 8,
    "xtick.major.width": 0.6,
    "ytick.labelsize": 8,
    "ytick.major.width": 0.6,
}


@contextmanager
def picture(path: Path, size: tuple[float, float], shows: str = "") -> Iterator[Axes]:
    """Open a figure with one axes, and write it if the ``with`` block ends without an error.

    Parameters
    ----------
    path : Path
        A PNG, PDF or SVG file. It is written aside and renamed.
    size : (float, float)
        Width and height [inch].
    shows : str
        Description in the file.
    """
    with panels(path, size, 1, 1, shows) as axes:
        yield axes[0, 0]


@contextmanager
def panels(
    path: Path, size: tuple[float, float], rows: int, columns: int, shows: str = ""
) -> Iterator[Any]:
    """Open a figure with several axes, (rows, columns), lettered (a), (b) ...; see `picture`."""
    with matplotlib.rc_context(RC):
        figure = Figure(figsize=size, layout="constrained")
        axes = figure.subplots(rows, columns, squeeze=False)
        yield axes
        if axes.size > 1:
            for letter, one in zip(ascii_lowercase, axes.flat, strict=False):
                one.set_title(f"({letter}) {one.get_title(loc='left')}")
        write_figure(figure, path, shows)


def size_around(nodes: Floats, beside: float = 0.0) -> tuple[float, float]:
    """Size of a figure of a body without empty margins.

    Parameters
    ----------
    nodes : (n, 2) float
        [mm].
    beside : float
        Width beside the axes, for example for a legend [inch].

    Returns
    -------
    (float, float)
        Width and height [inch].
    """
    width, height = np.ptp(nodes, axis=0)
    scale = min(5.5 / width, 6.0 / height)
    return max(scale * width + 1.0 + beside, 4.8), max(scale * height, 1.2) + 1.2


def write_figure(figure: Figure, path: Path, shows: str = "") -> None:
    """Write a figure to a temporary file and rename it, so that `path` is never incomplete."""
    metadata = {"Description": shows} if shows else None
    with written_aside_by_name(Path(path)) as aside, warnings.catch_warnings():
        # A name may have letters that the font has not: they become boxes.
        warnings.filterwarnings("ignore", r"Glyph .* missing from font")
        figure.savefig(
            aside, dpi=RESOLUTION, bbox_inches="tight", pad_inches=0.08, metadata=metadata
        )


def as_label(name: object) -> str:
    """A name as a text of matplotlib, for which $ begins a formula and _ hides a label."""
    text = str(name).replace("$", r"\$")
    return f" {text}" if text.startswith("_") else text


def length_axes(axes: Axes) -> None:
    """Set up axes for a body: equal scales in mm along x and y."""
    axes.set_aspect("equal")
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("y [mm]")
