"""A film of the deformed grid as cracks grow."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.animation import PillowWriter
from matplotlib.figure import Figure

from cfmpm.output.fields_by_step import list_fields
from cfmpm.output.files import written_aside_by_name
from cfmpm.output.reading import read_result
from cfmpm.plotting.deformed import draw_deformed, magnification
from cfmpm.plotting.mesh import Mesh
from cfmpm.plotting.style import COLOUR_BAR, RC, size_around

RESOLUTION = 100  # dots per inch


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
        The film. Magnification and colours are the same in all frames.

    Raises
    ------
    SceneError
        If a folder has no fields by step, if they belong to another run than its history, or if
        they cannot be read.
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
    with matplotlib.rc_context(RC), written_aside_by_name(path) as aside:
        figure = Figure(figsize=size_around(nodes, COLOUR_BAR), layout="constrained")
        # Pillow takes a fraction, whatever matplotlib has typed.
        writer = PillowWriter(fps=per_second)  # type: ignore[arg-type]
        with writer.saving(figure, aside, RESOLUTION):
            for fields in _opened(frames):
                figure.clear()
                axes = figure.add_subplot()
                draw_deformed(axes, fields, stress, factor=factor, limits=(low, high))
                step, load = fields["time"].values[-1], fields["load_factor"].values[-1]
                axes.set_title(f"step {step:g}, load factor {load:.3f}, displacement × {factor:g}")
                writer.grab_frame()
    return path


def _opened(frames: Sequence[Path | xr.Dataset]) -> Iterator[xr.Dataset]:
    for frame in frames:
        yield frame if isinstance(frame, xr.Dataset) else read_result(frame, "face_nodes")
