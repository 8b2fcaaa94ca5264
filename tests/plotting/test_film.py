"""Common axes and scales of the frames of a film."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image, ImageSequence

from cfmpm.errors import SceneError
from cfmpm.output.fields import build_fields
from cfmpm.plotting import animate_growth, film
from cfmpm.plotting.film import PLACE_OF_BAR
from cfmpm.scene import scene_from_dict
from cfmpm.simulation import run
from cfmpm.state import Result

SCENE = {
    "name": "plate",
    "family": {
        "kind": "plate_with_holes",
        "width": 20,
        "height": 10,
        "holes": [{"centre": [15, 5], "radius": 2}],
        "cracks": [{"points": [[0, 5], [3, 5]]}],
    },
    "material": {"E": 210e3, "nu": 0.3},
    "loads": [
        {"edge": "bottom", "displacement": {"x": 0, "y": 0}},
        {"edge": "top", "displacement": {"x": 0, "y": 0.01}},
    ],
    "mesh": {"element": "T3", "size": 2},
}


@pytest.fixture(scope="module")
def result() -> Result:
    return run(scene_from_dict(SCENE))


def frames_of(path: Path) -> tuple[list[NDArray[np.uint8]], list[int]]:
    """The frames of a film, and how long each stays [ms]."""
    with Image.open(path) as moving:
        shown = [
            (np.asarray(frame.convert("RGB")), frame.info["duration"])
            for frame in ImageSequence.Iterator(moving)
        ]
    frames, stays = zip(*shown, strict=True)
    return list(frames), list(stays)


def test_a_film_has_a_frame_of_each_field_and_one_without_load(
    result: Result, tmp_path: Path
) -> None:
    fields = build_fields(result)
    path = animate_growth(
        [fields, fields.assign_coords(time=[7.0])], tmp_path / "deep" / "film.gif"
    )
    frames, stays = frames_of(path)
    assert len(frames) == 3
    assert stays[0] == stays[-1] > 5 * stays[1]
    assert [p.name for p in path.parent.iterdir()] == ["film.gif"]
    # From a later step on the grid has other cracks than at the start.
    later = animate_growth([fields.assign_coords(time=[7.0])], path)
    assert len(frames_of(later)[0]) == 1


def test_an_animated_png_shows_what_the_gif_shows(result: Result, tmp_path: Path) -> None:
    fields = build_fields(result)
    gif, png = tmp_path / "film.gif", tmp_path / "film.png"
    animate_growth([fields, fields.assign_coords(time=[2.0])], gif, png)
    (of_gif, stays), (of_png, same_stays) = frames_of(gif), frames_of(png)
    np.testing.assert_array_equal(of_png, of_gif)
    assert same_stays == stays


@pytest.fixture
def figures(monkeypatch: pytest.MonkeyPatch) -> list[Callable[[Figure], None]]:
    """Functions that are called with the figure of each frame."""
    seen: list[Callable[[Figure], None]] = []

    def draw(figure: Figure, *arguments: Any) -> None:
        plain(figure, *arguments)
        for look in seen:
            look(figure)

    plain = film._draw
    monkeypatch.setattr(film, "_draw", draw)
    return seen


def test_the_first_frame_is_the_body_as_it_was(
    result: Result, tmp_path: Path, figures: list[Callable[[Figure], None]]
) -> None:
    titles: list[str] = []
    drawn: list[NDArray[np.float64]] = []
    stress: list[Any] = []

    def look(figure: Figure) -> None:
        (faces, *_), title = figure.axes[0].collections, figure.axes[0].get_title(loc="left")
        titles.append(title)
        drawn.append(np.array([path.vertices[:3] for path in faces.get_paths()]))
        stress.append(faces.get_array())

    figures.append(look)
    fields = build_fields(result)
    animate_growth([fields], tmp_path / "film.gif")
    assert titles[0].startswith("step 0, load factor 0.000")
    assert titles[1].startswith("step 1, load factor 1.000")
    np.testing.assert_array_equal(drawn[0], result.grid.nodes[result.grid.triangles])
    assert not np.array_equal(drawn[1], drawn[0])
    assert np.abs(stress[0]).max() == 0.0 < np.abs(stress[1]).max()


def test_axes_and_colours_stay_where_they_are(
    result: Result, tmp_path: Path, figures: list[Callable[[Figure], None]]
) -> None:
    fields = build_fields(result)
    frames: list[Any] = []

    def look(figure: Figure) -> None:
        figure.canvas.draw()
        axes, bar = figure.axes
        frames.append(
            (
                *axes.get_position().bounds,
                *bar.get_position().bounds,
                *axes.get_xlim(),
                *axes.get_ylim(),
                *axes.collections[0].get_clim(),
                *bar.get_ylim(),
                bar.get_ylabel(),
                len(bar.patches),
            )
        )

    figures.append(look)
    # Displacements of another size, stress beyond the colours at one end, at both and at none.
    animate_growth(
        [
            fields.assign(
                {
                    k: fields[k].copy(data=scale * fields[k].values)
                    for k in ("u_x", "u_y", "von_mises")
                }
            )
            for scale in (0.02, 1.0, 3.0)
        ],
        tmp_path / "film.gif",
    )
    assert len(frames) == 4
    assert len(set(frames)) == 1
    # The same in the file: a palette of each frame's own would change the bar's colours.
    images, _ = frames_of(tmp_path / "film.gif")
    height, width = images[0].shape[:2]
    left, bottom, wide, high = PLACE_OF_BAR
    bar = np.s_[
        int((1.0 - bottom - high) * height) : int((1.0 - bottom) * height),
        int(left * width) : int((left + wide) * width),
    ]
    for image in images[1:]:
        np.testing.assert_array_equal(image[bar], images[0][bar])
        assert (image[0] == 255).all()


def test_the_axes_hold_the_body_of_every_frame(
    result: Result, tmp_path: Path, figures: list[Callable[[Figure], None]]
) -> None:
    fields = build_fields(result)
    limits: list[Any] = []

    def look(figure: Figure) -> None:
        axes = figure.axes[0]
        limits.append((axes.get_xlim(), axes.get_ylim()))
        drawn = np.concatenate([path.vertices for path in axes.collections[0].get_paths()])
        for values, (low, high) in zip(drawn.T, limits[-1], strict=True):
            assert low < values.min()
            assert values.max() < high

    figures.append(look)
    moved = fields.assign(u_x=fields["u_x"] + 4.0)  # the second frame lies aside of the first
    animate_growth([fields, moved], tmp_path / "film.gif")
    assert len(limits) == 3


def test_a_film_of_nothing_says_what_makes_fields(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"output\.every"):
        animate_growth(tmp_path, tmp_path / "film.gif")
