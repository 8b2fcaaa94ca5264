"""Pictures of cracks that grow: the equilibrium path, angles, and a film."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.animation import PillowWriter
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from cfmpm.plotting.curves import STYLES
from cfmpm.plotting.deformed import draw_deformed, magnification
from cfmpm.plotting.mesh import Mesh
from cfmpm.plotting.style import (
    BLACK,
    BLUE,
    GREY,
    LIGHT_GREY,
    ORANGE,
    RC,
    VERMILLION,
    size_around,
)
from cfmpm.results import TIP_STATUS
from cfmpm.series import list_fields

# Colour and dashes both differ, so that the parts are told apart without colour too.
PARTS = {
    "stable": (BLUE, "-", "stable: the load rises"),
    "unstable": (ORANGE, (0, (5, 1.5)), "unstable: the load falls"),
    "snap_back": (VERMILLION, (0, (1.5, 1)), "snap-back"),
    "undefined": (GREY, ":", "under the load as it is"),
}
FILM_RESOLUTION = 100  # dots per inch
COLOUR_BAR = 0.9  # width [inch]


def draw_load_displacement(
    axes: Axes, history: xr.Dataset, boundary: str, component: str | None = None
) -> Axes:
    """Draw force against displacement of a loaded part, with its stable and unstable parts.

    Parameters
    ----------
    axes : Axes
    history : xarray.Dataset
        Of a growth run.
    boundary : str
        Name of the loaded part.
    component : {"x", "y"}, optional
        Default: that of the larger force.

    Returns
    -------
    Axes
        Force and displacement are positive along the first force. The way from the origin to the
        first growth is that of the body with its initial cracks.
    """
    part = history.sel(boundary=boundary)
    if component is None:
        component = max("xy", key=lambda axis: float(np.abs(part[f"reaction_{axis}"]).max()))
    force, motion = part[f"reaction_{component}"].values, part[f"displacement_{component}"].values
    sense = -1.0 if force[0] < 0.0 else 1.0
    points = sense * np.column_stack([motion, force])
    axes.plot(*np.array([(0.0, 0.0), points[0]]).T, color=BLACK, lw=1.1, label="no growth")
    flags = history["stability"]
    parts = np.array(flags.attrs["flag_meanings"].split())[flags.values[:-1]]
    named: set[str] = set()
    for first, last in _runs(parts):
        colour, dashes, label = PARTS[parts[first]]
        shown = "_" if parts[first] in named else label
        named.add(parts[first])
        axes.plot(*points[first : last + 1].T, color=colour, ls=dashes, lw=1.6, label=shown)
    axes.plot(*points.T, "o", color=BLACK, ms=2.0, zorder=3)
    direction = f"{'-' if sense < 0.0 else ''}{component}"
    axes.set_xlabel(f"displacement of {boundary} along {direction} [mm]")
    axes.set_ylabel(f"force along {direction} [N/mm]")
    axes.legend()
    return axes


def _runs(words: NDArray[np.str_]) -> list[tuple[int, int]]:
    """First index, and the one after the last, of each run of equal words."""
    ends = np.flatnonzero(words[1:] != words[:-1]) + 1
    bounds = [0, *ends.tolist(), len(words)]
    return [(a, b) for a, b in pairwise(bounds) if b > a]


def draw_angles(axes: Axes, history: xr.Dataset) -> Axes:
    """Draw the angle of the configurational force and the kink angle along each path.

    Parameters
    ----------
    axes : Axes
    history : xarray.Dataset
        Of a growth run.

    Returns
    -------
    Axes
        Angles are taken from the tangent of the tip: both vanish where a crack runs straight on.
        Increments in which a tip waits for another one are left out.
    """
    axes.axhline(0.0, color=LIGHT_GREY, lw=0.8, zorder=1)
    for i, name in enumerate(history["tip"].values):
        colour, marker = STYLES[i % len(STYLES)]
        of_tip = history.sel(tip=name)
        steps = np.hypot(np.diff(of_tip["tip_x"]), np.diff(of_tip["tip_y"]))
        grown = np.concatenate([[0.0], np.cumsum(steps)])
        runs = of_tip["tip_status"].values == TIP_STATUS.index("growing")
        line: dict[str, Any] = {"color": colour, "lw": 1.1, "ms": 3.0, "marker": marker}
        for angle, called, dashes, inside in (
            ("kink_angle", "largest hoop stress", "-", colour),
            ("cf_angle", "configurational force", "--", "none"),
        ):
            values, label = of_tip[angle].values[runs], f"{name}: {called}"
            axes.plot(grown[runs], values, dashes, mfc=inside, label=label, **line)
    axes.set_xlabel("growth of the tip along its path [mm]")
    axes.set_ylabel("angle from the tangent [°]")
    axes.legend()
    return axes


def animate_growth(
    frames: Path | Sequence[Path | xr.Dataset],
    path: Path,
    *,
    stress: str = "von_mises",
    per_second: float = 8.0,
) -> Path:
    """Write a film of the deformed grid as the cracks grow.

    Parameters
    ----------
    frames : Path or sequence of Path or Dataset
        Folder of a run with ``output.every``, or its fields in the order of the film. One is held
        in memory at a time.
    path : Path
        A GIF file. It is written aside and renamed.
    stress : str
        A variable on the faces.
    per_second : float
        Frames per second.

    Returns
    -------
    Path
        Of the film. Magnification and colours are the same in all frames.

    Raises
    ------
    FileNotFoundError
        Where a folder holds no fields by step.
    """
    if isinstance(frames, str | Path):
        frames = list_fields(Path(frames))
    largest, highest = 0.0, []
    for fields in _opened(frames):
        last = fields.isel(time=-1)
        u, nodes = np.column_stack([last["u_x"], last["u_y"]]), Mesh.of_fields(fields).nodes
        largest = max(largest, float(np.hypot(*u.T).max()))
        highest.append(np.percentile(last[stress].values, [1.0, 97.0]))
    low, high = np.min(highest, axis=0)[0], np.median(highest, axis=0)[1]
    factor = magnification(np.array([[largest, 0.0]]), nodes)
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with (
        matplotlib.rc_context(RC),
        tempfile.TemporaryDirectory(prefix=f".{path.name}.", dir=path.parent) as aside,
    ):
        figure = Figure(figsize=size_around(nodes, COLOUR_BAR), layout="constrained")
        # Pillow takes a fraction, whatever matplotlib has typed.
        writer = PillowWriter(fps=per_second)  # type: ignore[arg-type]
        with writer.saving(figure, Path(aside) / path.name, FILM_RESOLUTION):
            for fields in _opened(frames):
                figure.clear()
                axes = figure.add_subplot()
                draw_deformed(axes, fields, stress, factor=factor, limits=(low, high))
                step, load = fields["time"].values[-1], fields["load_factor"].values[-1]
                axes.set_title(f"step {step:g}, load factor {load:.3f}, displacement × {factor:g}")
                writer.grab_frame()
        os.replace(Path(aside) / path.name, path)
    return path


def _opened(frames: Sequence[Path | xr.Dataset]) -> Iterator[xr.Dataset]:
    for frame in frames:
        if isinstance(frame, xr.Dataset):
            yield frame
        else:
            with xr.open_dataset(frame, engine="netcdf4", mask_and_scale=False) as fields:
                yield fields
