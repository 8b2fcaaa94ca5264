"""Figures 9 to 16: the data that they show."""

from __future__ import annotations

from contextlib import contextmanager

import growth_data as made_up
import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from units_on_axes import require_units

from workflows.growth import figures
from workflows.growth.datasets import tip_path
from workflows.reference.path_points import reference

SCENES = {
    "edge": "edge_crack_growth",
    "shear": "shear_plate_growth",
    "holes": "plate_two_holes",
    "beam": "beam_three_holes",
}


class Drawn:
    """Draws one figure from a dataset and returns the data of its axes."""

    def __init__(self, folder, scenes, monkeypatch):
        self.folder, self.scenes = folder, scenes

        @contextmanager
        def keep(path, size, rows, columns, **more):
            self.axes = Figure(figsize=size).subplots(rows, columns, squeeze=False)
            yield self.axes
            require_units(self.axes.flat[0].figure)

        monkeypatch.setattr(figures, "panels", keep)

    def __call__(self, number, study, dataset, *more, scene=True):
        growth, data = self.folder / "growth.nc", self.folder / f"fig{number}.nc"
        dataset.to_netcdf(growth)
        scene_file = [str(self.scenes / f"{SCENES[study]}.yaml")] if scene else []
        write = getattr(figures, f"write_fig{number}")
        write(growth, *scene_file, *more, self.folder / f"fig{number}.png", data)
        assert xr.load_dataset(data).sizes["variant"] > 0
        return self

    def line(self, label, panel=0):
        """The points of the line with a label, (k, 2)."""
        (found,) = (
            line
            for line in self.axes.flat[panel].get_lines()
            if str(line.get_label()).startswith(label)
        )
        return np.column_stack(found.get_data()).astype(float)


@pytest.fixture
def drawn(tmp_path, root, monkeypatch):
    return Drawn(tmp_path, root / "configs/paper", monkeypatch)


def test_fig9_shows_the_angles(drawn):
    dataset = made_up.edge()
    angle = xr.where(dataset.variant == "cf_790", 1.5, 0.5) + 0.0 * dataset.cf_angle
    drawn(9, "edge", dataset.assign(cf_angle=angle), scene=False)
    for panel, expected in enumerate((1.5, 0.5)):
        np.testing.assert_array_equal(drawn.line("domain", panel)[:, 1], expected)
        at_tip = np.degrees(np.arctan(0.05))
        np.testing.assert_allclose(drawn.line("tip node", panel)[:, 1], at_tip, rtol=1e-12)


def test_fig10_shows_how_far_the_path_is_off_the_middle(drawn):
    drawn(10, "edge", made_up.moved(made_up.edge(), "hoop_790", 0.0, 1.25))
    np.testing.assert_array_equal(drawn.line("largest hoop stress (ends at +1.2)", 1)[:, 1], 1.25)
    np.testing.assert_array_equal(drawn.line("CF direction", 1)[:, 1], 0.0)
    np.testing.assert_array_equal(drawn.line("largest hoop stress", 2)[:, 1], 0.0)


def test_titles_count_the_points_of_the_dataset(drawn):
    dataset = made_up.edge()
    graded = dataset.assign(n_points=dataset.n_points.where(dataset.variant != "cf_2584", 2345.0))
    titles = [one.get_title() for one in drawn(10, "edge", graded).axes.flat]
    assert titles == ["CF direction, 2345 points", "790 points", "2345 points"]
    titles = [one.get_title() for one in drawn(13, "holes", made_up.holes()).axes.flat]
    assert "790 points" in titles[0]


def test_fig11_shows_the_path(drawn):
    dataset = made_up.moved(made_up.shear(), "cf", 0.0, 0.5)
    drawn(11, "shear", dataset)
    for panel in (0, 1):
        np.testing.assert_array_equal(drawn.line("CF direction", panel), tip_path(dataset, "cf"))
    np.testing.assert_array_equal(drawn.line("CF, paper's", 1), tip_path(dataset, "paper"))


def test_fig12_shows_the_distance_from_the_limit(drawn):
    dataset = made_up.moved(made_up.shear(), "hoop_first_1.38", 0.0, -0.3)
    drawn(12, "shear", dataset, scene=False)
    missed = drawn.line("T3, hoop stress", 0)[:, 1]
    np.testing.assert_allclose(np.sort(missed), [0.0, 0.3], atol=1e-12)
    np.testing.assert_allclose(drawn.line("T3, hoop stress", 1)[:, 1], 0.0, atol=1e-12)


def test_fig13_shows_both_paths(drawn):
    dataset = made_up.moved(made_up.holes(), "hoop", 0.0, 0.5)
    drawn(13, "holes", dataset)
    for panel, name in enumerate(("cf", "hoop", "rollers")):
        for tip in ("left_crack", "right_crack"):
            (path,) = (
                np.column_stack(line.get_data())
                for line in drawn.axes.flat[panel].get_lines()
                if line.get_label() == tip
            )
            np.testing.assert_array_equal(path, tip_path(dataset, name, tip))


def test_fig14_shows_the_driving_force(drawn):
    dataset = made_up.scaled(made_up.holes(), "hoop", "cf_norm", 2.0)
    drawn(14, "holes", dataset, scene=False)
    np.testing.assert_array_equal(drawn.line("left_crack", 0)[:, 1], 9.0)
    np.testing.assert_array_equal(drawn.line("left_crack", 1)[:, 1], 18.0)


def test_fig15_shows_each_specimen(drawn):
    dataset = made_up.moved(made_up.beam(), "hoop_10_4", 3.0)
    drawn(15, "beam", dataset)
    for panel, case in enumerate(("15_5", "10_4", "10_6")):
        np.testing.assert_array_equal(
            drawn.line("hoop stress", panel), tip_path(dataset, f"hoop_{case}")
        )


def test_fig16_shows_the_gap(drawn):
    """A vertical path 10 mm left of the centre of the hole has a gap of 10 mm less 6.35 mm."""
    upright = made_up.history({"crack_1": [[142.4, 38.1], [142.4, 100.0], [142.4, 150.0]]})
    along = made_up.history({"crack_1": reference("beam_15_5")})
    variants = {
        f"{order}_{size}": run
        for order, run in (("first", upright), ("second", along))
        for size in (12, 8, 5, 3)
    }
    drawn(16, "beam", made_up.stack(variants), [12, 8, 5, 3])
    np.testing.assert_allclose(
        drawn.line("T3, hoop stress, first", 1)[:, 1], 10.0 - 6.35, atol=1e-12
    )
    second = drawn.line("T3, hoop stress, second", 1)[:, 1]
    np.testing.assert_allclose(second, 2.79, atol=0.01)


def test_distance_to_path():
    path = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0]])
    for point, distance in (([2, 1], 1.0), ([-3, 4], 5.0), ([5, 1.5], 1.0), ([4, 5], 2.0)):
        assert figures.distance_to_path(path, np.array(point, float)) == pytest.approx(distance)


def test_every_reference_is_drawn():
    """Any number of references: markers repeat."""
    axes = Figure().add_subplot()
    figures._draw_reference(axes, {f"author {k}": np.array([[k, 1.0]]) for k in range(5)})
    assert [line.get_xdata().tolist() for line in axes.lines] == [[k] for k in range(5)]
