"""Figures 9 to 16, and those beyond the paper: the data that they show."""

from __future__ import annotations

from contextlib import contextmanager

import growth_data as made_up
import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from units_on_axes import require_units

from cfmpm.scene import load_scene
from workflows.growth import beam_figures, edge_figures, holes_figures, shear_figures
from workflows.growth.beam_holes import distance_to_path
from workflows.growth.datasets import segment_angles, tip_path
from workflows.growth.drawing import draw_body, draw_reference
from workflows.growth.grown_grids import Grown
from workflows.reference.path_points import reference

SCENES = {
    edge_figures: "edge_crack_growth",
    shear_figures: "shear_plate_growth",
    holes_figures: "plate_two_holes",
    beam_figures: "beam_three_holes",
}


class Drawn:
    """Draws one figure from a dataset, with grids made but nothing solved."""

    def __init__(self, folder, scenes, monkeypatch):
        self.folder, self.scenes, self.monkeypatch = folder, scenes, monkeypatch

    def __call__(self, of, name, dataset, *more, scene=True):
        @contextmanager
        def keep(path, size, rows, columns, **options):
            self.axes = Figure(figsize=size).subplots(rows, columns, squeeze=False)
            assert size[0] == pytest.approx(6.7)
            yield self.axes
            require_units(self.axes.flat[0].figure)

        self.monkeypatch.setattr(of, "panels", keep)
        if hasattr(of, "grow"):
            self.monkeypatch.setattr(of, "grow", without_growth)
        given, data = self.folder / "given.nc", self.folder / f"{name}.nc"
        dataset.to_netcdf(given)
        scene_file = [str(self.scenes / f"{SCENES[of]}.yaml")] if scene else []
        getattr(of, f"write_{name}")(given, *scene_file, *more, self.folder / "a.png", data)
        assert xr.load_dataset(data).sizes["step"] > 1
        return self

    def line(self, label, panel=0):
        """The points of the line with a label, (k, 2)."""
        (found,) = (
            line
            for line in self.axes.flat[panel].get_lines()
            if str(line.get_label()).startswith(label)
        )
        return np.column_stack(found.get_data()).astype(float)

    def arrows(self, panel=0):
        """Where the red arrows of a panel begin, (k, 2)."""
        found = [one for one in self.axes.flat[panel].collections if hasattr(one, "U")]
        return np.vstack([one.XY for one in found])


def without_growth(scene_file, replaced, increments=()):
    """A coarse grid of a scene before it has grown."""
    from cfmpm.build import build

    scene = load_scene(scene_file, {**replaced, "mesh": {"element": "T3"}})
    grid = build(scene).grid
    return Grown(scene, grid, grid, dict.fromkeys(increments, grid), 1234)


@pytest.fixture
def drawn(tmp_path, root, monkeypatch):
    return Drawn(tmp_path, root / "configs/paper", monkeypatch)


def none_replaced(*names):
    return {name: {} for name in names}


def test_fig9_shows_the_angles_and_the_papers_range(drawn):
    dataset = made_up.edge()
    drawn(edge_figures, "fig9", dataset, scene=False)
    for panel, kind in enumerate(("as_printed", "reset")):
        for label, n in (("790", 790), ("2584", 2584)):
            angles = segment_angles(tip_path(dataset, f"{kind}_{n}"))
            np.testing.assert_array_equal(drawn.line(f"{label} points", panel)[:, 1], angles)
    for panel in range(3):
        limits = drawn.axes.flat[panel].get_ylim()
        for n, ends in edge_figures.RANGES.items():
            assert drawn.line(f"paper's range, {n}", panel)[0, 1] == ends[0]
            assert limits[0] < ends[0] < ends[1] < limits[1]


def test_fig9_marks_where_the_crack_runs_straight_on(drawn):
    dataset = made_up.edge()
    level = dataset.tip_y.where(dataset.step < 15, 500.0)
    drawn(edge_figures, "fig9", dataset.assign(tip_y=level), scene=False)
    kept = [
        line for line in drawn.axes.flat[0].get_lines() if str(line.get_label())[:8] == "straight"
    ]
    assert [len(line.get_xdata()) for line in kept] == [5, 5]


def test_fig10_shows_each_path_on_its_grid(drawn):
    dataset = made_up.moved(made_up.edge(), "as_printed_2584", 0.0, 1.25)
    names = ("as_printed_790", "as_printed_2584", "best")
    drawn(edge_figures, "fig10", dataset, none_replaced(*names))
    for panel, name in enumerate(names):
        np.testing.assert_array_equal(drawn.arrows(panel), tip_path(dataset, name)[:-1])
        assert "1234 points" in drawn.axes.flat[panel].get_title()


def test_fig11_shows_load_and_grids(drawn):
    drawn(shear_figures, "fig11", made_up.shear(), none_replaced("as_printed", "best"))
    titles = [one.get_title() for one in drawn.axes.flat]
    assert titles[1:] == ["as printed, 1234 points", "best, 1234 points"]
    assert "100 MPa" in {text.get_text() for text in drawn.axes.flat[0].texts}


def test_fig12_shows_the_crack_after_3_10_and_15_steps(drawn):
    dataset = made_up.moved(made_up.shear(), "best", 0.0, 0.5)
    drawn(shear_figures, "fig12", dataset, none_replaced("as_printed", "best"))
    path = tip_path(dataset, "as_printed")
    for panel, steps in enumerate((3, 10, 15)):
        np.testing.assert_array_equal(drawn.arrows(panel), path[:steps])
    np.testing.assert_array_equal(drawn.line("as printed, 1234", 3), path)
    np.testing.assert_array_equal(drawn.line("best", 3), tip_path(dataset, "best"))
    np.testing.assert_array_equal(drawn.line("FEM", 3), reference("shear_plate"))


def test_convergence_shows_the_distance_from_the_limit(drawn):
    dataset = made_up.moved(made_up.shear(), "hoop_first_1.38", 0.0, -0.3)
    drawn(shear_figures, "convergence_shear", dataset, scene=False)
    missed = drawn.line("T3, hoop stress", 0)[:, 1]
    np.testing.assert_allclose(np.sort(missed), [0.0, 0.3], atol=1e-12)
    np.testing.assert_allclose(drawn.line("T3, hoop stress", 1)[:, 1], 0.0, atol=1e-12)
    np.testing.assert_allclose(drawn.line("T3, direction of CF", 0)[:, 1], 0.0, atol=1e-12)


def test_fig13_shows_lengths_load_and_grids(drawn):
    drawn(holes_figures, "fig13", made_up.holes(), none_replaced("as_printed", "best"))
    texts = {text.get_text() for text in drawn.axes.flat[0].texts}
    assert {"l = 20", "h = 10", "a = 1", "h$_0$ = 2.85", "R = 2", "d = 3"} <= texts


def test_fig14_shows_both_paths_beside_fem(drawn):
    dataset = made_up.moved(made_up.holes(), "best", 0.0, 0.5)
    drawn(holes_figures, "fig14", dataset, none_replaced("as_printed", "best"))
    for panel, name in ((0, "as_printed"), (2, "best")):
        both = [tip_path(dataset, name, tip)[:-1] for tip in holes_figures.TIPS]
        np.testing.assert_array_equal(drawn.arrows(panel), np.vstack(both))
    left = tip_path(dataset, "as_printed", "left_crack")
    np.testing.assert_array_equal(drawn.line("MPM, as printed", 3), left)
    np.testing.assert_array_equal(drawn.line("FEM", 3), reference("holes_remeshing"))


def test_driving_force_of_both_cracks(drawn):
    dataset = made_up.scaled(made_up.holes(), "best", "cf_norm", 2.0)
    drawn(holes_figures, "driving_force_holes", dataset)
    np.testing.assert_array_equal(drawn.line("left crack", 0)[:, 1], 9.0)
    np.testing.assert_array_equal(drawn.line("left crack", 1)[:, 1], 18.0)
    np.testing.assert_array_equal(drawn.line("right crack", 1)[:, 1], 19.0)


BEAMS = none_replaced(*(f"as_printed_{case}" for case in made_up.SPECIMENS), "best_15_5")


def test_fig15_shows_the_beam(drawn):
    drawn(beam_figures, "fig15", made_up.beam(), BEAMS)
    for panel, texts in enumerate(({"a = 38.1", "b = 127"}, {"a = 25.4", "b = 101.6"})):
        assert texts <= {text.get_text() for text in drawn.axes.flat[panel].texts}


def test_fig16_shows_each_specimen(drawn):
    dataset = made_up.moved(made_up.beam(), "best_10_4", 3.0)
    drawn(beam_figures, "fig16", dataset, BEAMS)
    for panel, case in enumerate(("15_5", "10_6", "10_4")):
        printed, best = (tip_path(dataset, f"{kind}_{case}") for kind in ("as_printed", "best"))
        np.testing.assert_array_equal(drawn.line("as printed", panel), printed)
        np.testing.assert_array_equal(drawn.line("best", panel), best)


def test_near_miss_shows_the_gap(drawn):
    """A vertical path 10 mm left of the centre of the hole has a gap of 10 mm less 6.35 mm."""
    upright = made_up.history({"crack_1": [[142.4, 38.1], [142.4, 100.0], [142.4, 150.0]]})
    along = made_up.history({"crack_1": reference("beam_15_5")})
    variants = {
        f"{order}_{size}": run
        for order, run in (("first", upright), ("second", along))
        for size in (12, 8, 5, 3)
    }
    drawn(beam_figures, "near_miss_beam", made_up.stack(variants), [12, 8, 5, 3])
    np.testing.assert_allclose(
        drawn.line("T3, hoop stress, first", 1)[:, 1], 10.0 - 6.35, atol=1e-12
    )
    second = drawn.line("T3, hoop stress, second", 1)[:, 1]
    np.testing.assert_allclose(second, 2.79, atol=0.01)


def test_many_grids_are_a_band(drawn):
    """One line for each grid, and words of how they end."""
    drawn(edge_figures, "scatter_edge", made_up.edge_grids(), scene=False)
    assert len(drawn.axes.flat[0].get_lines()) == 4 + 2
    drawn(shear_figures, "scatter_shear", made_up.shear_grids())
    bands = [one for one in drawn.axes.flat[0].get_lines() if one.get_alpha() == 0.55]
    assert len(bands) == 3
    drawn(holes_figures, "scatter_holes", made_up.holes_grids())
    assert "3 in a hole" in drawn.axes[0, 1].texts[0].get_text()
    drawn(beam_figures, "scatter_beam", made_up.beam_grids(), BEAMS)
    told = {one.get_title().split("\n")[0]: one.texts[0].get_text() for one in drawn.axes.flat}
    assert "2 in the bottom hole" in told["case II: a = 1 in, x = 6 in"]
    assert "2 in the middle hole" in told["case II: a = 1 in, x = 4 in"]


def test_distance_to_path():
    path = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0]])
    for point, distance in (([2, 1], 1.0), ([-3, 4], 5.0), ([5, 1.5], 1.0), ([4, 5], 2.0)):
        assert distance_to_path(path, np.array(point, float)) == pytest.approx(distance)


def test_initial_cracks_are_drawn(root):
    axes = Figure().add_subplot()
    draw_body(axes, load_scene(root / "configs/paper/plate_two_holes.yaml"))
    drawn = [np.column_stack(line.get_data()).tolist() for line in axes.get_lines()]
    assert [[0, 2.85], [1, 2.85]] in drawn
    assert [[20, 7.15], [19, 7.15]] in drawn


def test_every_reference_is_drawn():
    """Any number of references: markers repeat."""
    axes = Figure().add_subplot()
    draw_reference(axes, {f"author {k}": np.array([[k, 1.0]]) for k in range(5)})
    assert [line.get_xdata().tolist() for line in axes.lines] == [[k] for k in range(5)]
