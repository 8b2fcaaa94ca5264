"""A film of the deformed grid as cracks grow."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.animation import PillowWriter
from matplotlib.figure import Figure

from cfmpm.body.grid import Floats
from cfmpm.output.fields_by_step import list_fields
from cfmpm.output.files import written_aside_by_name
from cfmpm.output.reading import read_result
from cfmpm.plotting.deformed import draw_deformed, magnification
from cfmpm.plotting.mesh import Mesh
from cfmpm.plotting.style import COLOUR_BAR, RC, size_around

RESOLUTION = 100  # dots per inch
# Left, bottom, width and height of the axes and of the colour bar as parts of the figure: a layout
# by what stands in a frame would make them jump.
PLACE, PLACE_OF_BAR = (0.12, 0.12, 0.66, 0.76), (0.82, 0.18, 0.025, 0.64)
# Around the body, as a part of its size.
MARGIN = 0.03


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
        Folder of a run with ``output.every``, or its fields in the order of the film. Only one is
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
        Of the film. Axes, magnification and colours are the same in all frames.

    Raises
    ------
    SceneError
        If a folder has no fields by step, if they belong to another run than its history, or if
        they cannot be read.
    """
    if isinstance(frames, str | Path):
        frames = list_fields(Path(frames))
    shown = _shown(frames, stress)
    path = Path(path)
    with matplotlib.rc_context(RC), written_aside_by_name(path) as aside:
        figure = Figure(figsize=size_around(shown.corners, COLOUR_BAR))
        # Pillow takes a fraction, whatever matplotlib has typed.
        writer = PillowWriter(fps=per_second)  # type: ignore[arg-type]
        with writer.saving(figure, aside, RESOLUTION):
            for fields in _opened(frames):
                figure.clear()
                axes, bar = figure.add_axes(PLACE), figure.add_axes(PLACE_OF_BAR)
                draw_deformed(
                    axes, fields, stress, factor=shown.factor, limits=shown.colours, bar=bar
                )
                axes.set(xlim=shown.corners[:, 0], ylim=shown.corners[:, 1])
                step, load = fields["time"].values[-1], fields["load_factor"].values[-1]
                title = f"step {step:g}, load factor {load:.3f}, displacement × {shown.factor:g}"
                axes.set_title(title)
                writer.grab_frame()
    return path


@dataclass(frozen=True)
class _Shown:
    """What all frames of a film share.

    Attributes
    ----------
    factor : float
        On the displacements.
    colours : (float, float)
        Lowest and highest stress of the colours [MPa].
    corners : (2, 2) float
        Lowest and highest x and y of the axes, which hold the body of every frame [mm].
    """

    factor: float
    colours: tuple[float, float]
    corners: Floats


def _shown(frames: Sequence[Path | xr.Dataset], stress: str) -> _Shown:
    """Look through all frames, twice, for what they are to share; one is held at a time."""
    largest, colours, nodes = 0.0, [], np.zeros((1, 2))
    for fields in _opened(frames):
        last = fields.isel(time=-1)
        largest = max(largest, float(np.hypot(last["u_x"].values, last["u_y"].values).max()))
        nodes = Mesh.of_fields(fields).nodes
        colours.append(np.percentile(last[stress].values, [1.0, 97.0]))
    factor = magnification(np.array([[largest, 0.0]]), nodes)
    ends = []
    for fields in _opened(frames):
        last, nodes = fields.isel(time=-1), Mesh.of_fields(fields).nodes
        moved = nodes + factor * np.column_stack([last["u_x"], last["u_y"]])
        ends += [x for place in (nodes, moved) for x in (place.min(axis=0), place.max(axis=0))]
    drawn = np.array(ends)
    margin = MARGIN * np.ptp(drawn, axis=0).max()
    corners = np.array([drawn.min(axis=0) - margin, drawn.max(axis=0) + margin])
    low, high = np.min(colours, axis=0)[0], np.median(colours, axis=0)[1]
    return _Shown(factor, (float(low), float(high)), corners)


def _opened(frames: Sequence[Path | xr.Dataset]) -> Iterator[xr.Dataset]:
    for frame in frames:
        yield frame if isinstance(frame, xr.Dataset) else read_result(frame, "face_nodes")
