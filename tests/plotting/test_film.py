"""Common axes and scales of the frames of a film."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.animation import PillowWriter
from PIL import Image

from cfmpm.errors import SceneError
from cfmpm.output.fields import build_fields
from cfmpm.plotting import animate_growth
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


def test_a_film_has_a_frame_of_each_field(result: Result, tmp_path: Path) -> None:
    fields = build_fields(result)
    path = animate_growth(
        [fields, fields.assign_coords(time=[7.0])], tmp_path / "deep" / "film.gif"
    )
    with Image.open(path) as film:
        assert film.n_frames == 2
    assert [p.name for p in path.parent.iterdir()] == ["film.gif"]


def test_axes_and_colours_stay_where_they_are(
    result: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fields = build_fields(result)
    frames: list[Any] = []

    def grab(writer: PillowWriter, **options: Any) -> None:
        writer.fig.canvas.draw()
        axes, bar = writer.fig.axes
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
        plain(writer, **options)

    plain = PillowWriter.grab_frame
    monkeypatch.setattr(PillowWriter, "grab_frame", grab)
    # Displacements of another size, stress beyond the colours at one end, at both and at none.
    animate_growth(
        [
            fields.assign({k: scale * fields[k] for k in ("u_x", "u_y", "von_mises")})
            for scale in (0.02, 1.0, 3.0)
        ],
        tmp_path / "film.gif",
    )
    assert frames[0] == frames[1] == frames[2]
    with Image.open(tmp_path / "film.gif") as film:
        assert film.n_frames == 3


def test_the_axes_hold_the_body_of_every_frame(
    result: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fields = build_fields(result)
    limits: list[Any] = []

    def grab(writer: PillowWriter, **options: Any) -> None:
        axes = writer.fig.axes[0]
        limits.append((axes.get_xlim(), axes.get_ylim()))
        drawn = np.concatenate([path.vertices for path in axes.collections[0].get_paths()])
        for values, (low, high) in zip(drawn.T, limits[-1], strict=True):
            assert low < values.min()
            assert values.max() < high

    monkeypatch.setattr(PillowWriter, "grab_frame", grab)
    monkeypatch.setattr(PillowWriter, "finish", lambda writer: Path(writer.outfile).touch())
    moved = fields.assign(u_x=fields["u_x"] + 4.0)  # the second frame lies aside of the first
    animate_growth([fields, moved], tmp_path / "film.gif")
    assert len(limits) == 2


def test_a_film_of_nothing_says_what_makes_fields(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"output\.every"):
        animate_growth(tmp_path, tmp_path / "film.gif")
