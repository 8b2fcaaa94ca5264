"""A film of the deformed grid as cracks grow."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from cfmpm.body.grid import Floats
from cfmpm.output.fields_by_step import list_fields
from cfmpm.output.files import written_aside_by_name
from cfmpm.output.reading import read_result
from cfmpm.plotting.deformed import draw_deformed, magnification
from cfmpm.plotting.mesh import Mesh
from cfmpm.plotting.style import COLOUR_BAR, RC, STRESS_MAP, size_around

RESOLUTION = 100  # dots per inch
# Left, bottom, width and height of the axes and of the colour bar as parts of the figure: a layout
# by what stands in a frame would make them jump.
PLACE, PLACE_OF_BAR = (0.12, 0.12, 0.66, 0.76), (0.82, 0.18, 0.025, 0.64)
# Around the body, as a part of its size.
MARGIN = 0.03
# How long the first and the last frame stay [s].
HELD = 1.5


def animate_growth(
    frames: Path | Sequence[Path | xr.Dataset],
    path: Path,
    *others: Path,
    stress: str = "von_mises",
    per_second: float = 5.0,
) -> Path:
    """Write a film of the deformed grid as the cracks grow.

    Parameters
    ----------
    frames : Path or sequence of Path or Dataset
        Folder of a run with ``output.every``, or its fields in the order of the film. Only one is
        in memory at a time. If the first is of step 1, it is shown without load before.
    path : Path
        A GIF file, or by the ending of its name an animated PNG. It is written aside and renamed.
    *others : Path
        Further files of the same film.
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
    images = _images(frames, stress)
    held, each = (round(1000.0 * seconds) for seconds in (HELD, 1.0 / per_second))
    ends = (0, len(images) - 1)
    duration = [held if k in ends else each for k in range(len(images))]
    for file in (path, *others):
        with written_aside_by_name(Path(file)) as aside:
            images[0].save(
                aside, save_all=True, append_images=images[1:], duration=duration, loop=0
            )
    return Path(path)


def _images(frames: Sequence[Path | xr.Dataset], stress: str) -> list[Image.Image]:
    """All frames, drawn."""
    shown, palette, images = _shown(frames, stress), _palette(), []
    with matplotlib.rc_context(RC):
        figure = Figure(figsize=size_around(shown.corners, COLOUR_BAR), dpi=RESOLUTION)
        canvas = FigureCanvasAgg(figure)
        for fields in _from_rest(frames, stress):
            _draw(figure, fields, stress, shown)
            canvas.draw()
            image = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
            images.append(image.quantize(palette=palette, dither=Image.Dither.NONE))
    return images


def _draw(figure: Figure, fields: xr.Dataset, stress: str, shown: _Shown) -> None:
    """Draw one frame."""
    figure.clear()
    axes, bar = figure.add_axes(PLACE), figure.add_axes(PLACE_OF_BAR)
    draw_deformed(axes, fields, stress, factor=shown.factor, limits=shown.colours, bar=bar)
    axes.set(xlim=shown.corners[:, 0], ylim=shown.corners[:, 1])
    step, load = fields["time"].values[-1], fields["load_factor"].values[-1]
    axes.set_title(f"step {step:g}, load factor {load:.3f}, displacement × {shown.factor:g}")


def _from_rest(frames: Sequence[Path | xr.Dataset], stress: str) -> Iterator[xr.Dataset]:
    """The frames, and before the first step the body as it is without load."""
    for k, fields in enumerate(_opened(frames)):
        if k == 0 and fields["time"].values[-1] == 1:
            still = fields.assign(
                {name: xr.zeros_like(fields[name]) for name in ("u_x", "u_y", stress)}
            )
            yield still.assign_coords(time=[0], load_factor=("time", [0.0]))
        yield fields


def _palette() -> Image.Image:
    """The colours of all frames: of stress, of stress below a line of the grid, greys.

    A palette of each frame's own would show one stress in other colours from frame to frame.
    """
    colours = matplotlib.colormaps[STRESS_MAP](np.linspace(0.0, 1.0, 154))[:, :3]
    light = 0.8 * colours[::2] + 0.2
    # Apart by more than Pillow takes for one colour, so that white stays white.
    grey = np.linspace(0.0, 1.0, 24)[:, None] * np.ones(3)
    image = Image.new("P", (1, 1))
    image.putpalette(np.round(255.0 * np.vstack([colours, light, grey])).astype(np.uint8).tobytes())
    return image


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
