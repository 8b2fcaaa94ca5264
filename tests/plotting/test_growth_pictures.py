"""Figures of crack growth: the data that they show."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.quiver import Quiver
from structured import rectangle

from cfmpm.body.grid import build_grid
from cfmpm.output.analysis import tip_path
from cfmpm.output.variables import TIP_STATUS
from cfmpm.plotting import (
    draw_angles,
    draw_cycles,
    draw_energy,
    draw_factors,
    draw_load,
    draw_load_displacement,
    draw_paths,
    draw_steps,
    draw_tip_cf,
)
from cfmpm.plotting.files import save_growth, save_steps
from cfmpm.plotting.growth import PARTS
from cfmpm.plotting.style import BLACK
from cfmpm.scene import expand, scene_from_dict
from cfmpm.simulation import run

SCENE = {
    "name": "plate",
    "family": {
        "kind": "plate_with_holes",
        "width": 20,
        "height": 10,
        "holes": [{"centre": [15, 5], "radius": 2}],
        "cracks": [{"points": [[0, 5], [3, 5]]}],
    },
    "material": {"E": 210e3, "nu": 0.3, "g_c": 1.0},
    "loads": [
        {"edge": "bottom", "displacement": {"x": 0, "y": 0}},
        {"edge": "top", "displacement": {"x": 0, "y": 0.01}},
    ],
    "mesh": {"element": "T3", "size": 1},
    "growth": {"control": "crack", "increments": 3},
}


def history_of(flags: list[int], force: list[float], motion: list[float]) -> xr.Dataset:
    """Two tips, the second without growth in one step; one loaded part."""
    n = len(flags)
    growing, stopped = TIP_STATUS.index("growing"), TIP_STATUS.index("stopped")
    status = np.column_stack([[growing] * n, [stopped] + [growing] * (n - 1)])
    x = np.column_stack([np.arange(n), [9.0, 9.0, *(9.0 - np.arange(1.0, n - 1))]])
    angle = np.arange(2.0 * n).reshape(n, 2)
    return xr.Dataset(
        {
            "tip_x": (("step", "tip"), x),
            "tip_y": (("step", "tip"), np.zeros((n, 2))),
            "tip_status": (("step", "tip"), status),
            "load_factor": ("step", np.linspace(1.0, 2.0, n)),
            "kink_angle": (("step", "tip"), angle),
            "cf_angle": (("step", "tip"), -angle),
            "stability": ("step", flags, {"flag_meanings": " ".join(reversed(PARTS))}),
            "reaction_x": (("step", "boundary"), np.zeros((n, 1))),
            "displacement_x": (("step", "boundary"), np.zeros((n, 1))),
            "reaction_y": (("step", "boundary"), np.array(force)[:, None]),
            "displacement_y": (("step", "boundary"), np.array(motion)[:, None]),
        },
        {"tip": ["left", "right"], "boundary": ["top"]},
    )


@pytest.fixture
def axes() -> Axes:
    return Figure().add_subplot()


@pytest.fixture
def history() -> xr.Dataset:
    words = list(reversed(PARTS))
    names = ["stable", "stable", "unstable", "snap_back", "undefined"]
    return history_of(
        [words.index(name) for name in names],
        [-1.0, -1.5, -2.0, -1.8, -1.0],
        [-0.1, -0.2, -0.3, -0.4, -0.3],
    )


def lines(axes: Axes) -> dict[str, np.ndarray]:
    return {str(line.get_label()): np.column_stack(line.get_data()) for line in axes.lines}


def test_a_path_has_each_place_once(history: xr.Dataset) -> None:
    assert tip_path(history, "left").tolist() == [[k, 0.0] for k in range(5)]
    assert tip_path(history, "right").tolist() == [[x, 0.0] for x in (9.0, 8.0, 7.0, 6.0)]


@pytest.mark.parametrize("kind", ["scene", "grid"])
def test_paths_lie_over_the_body(axes: Axes, history: xr.Dataset, kind: str) -> None:
    scene = expand(scene_from_dict(SCENE))
    grid = build_grid(rectangle(6, 4, 20.0, 10.0, crack=(2, 0, 3)), "T3")
    draw_paths(axes, history, scene if kind == "scene" else grid, {"Smith": [[1, 2], [3, 4]]})
    shown = lines(axes)
    np.testing.assert_array_equal(shown["left"], tip_path(history, "left"))
    np.testing.assert_array_equal(shown["Smith"], [[1, 2], [3, 4]])
    assert axes.get_xlim()[0] <= 0
    assert axes.get_xlim()[1] >= 20


@pytest.mark.parametrize(
    ("status", "marker", "label"),
    [
        ("growing", ">", "still growing"),
        ("stopped", "s", "stopped"),
        ("arrived_boundary", "X", "arrived"),
        ("arrived_crack", "X", "arrived"),
        ("severed", "D", "in a severed body"),
    ],
)
def test_what_became_of_a_tip_is_marked(
    axes: Axes, history: xr.Dataset, status: str, marker: str, label: str
) -> None:
    """The legend lists only what the figure contains."""
    history["tip_status"][-1] = TIP_STATUS.index(status)
    draw_paths(axes, history, expand(scene_from_dict(SCENE)))
    ends = [line for line in axes.lines if line.get_marker() == marker]
    places = [np.column_stack(line.get_data()).tolist() for line in ends]
    assert places == [[[4.0, 0.0]], [[6.0, 0.0]], []]
    assert axes.get_legend_handles_labels()[1] == ["left", "right", label]


@pytest.mark.parametrize("absent", [["right"], ["left", "right"]])
@pytest.mark.filterwarnings("error")
def test_tips_that_a_member_of_a_study_lacks_are_not_drawn(
    axes: Axes, history: xr.Dataset, absent: list[str]
) -> None:
    """Other members have these tips: here all values are nan, and the status is -1."""
    lacks = history["tip"].isin(absent)
    force = {name: xr.ones_like(history["tip_x"]) for name in ("cf_x", "cf_y", "cf_norm")}
    member = history.assign(force)
    for name in ("tip_x", "tip_y", *force):
        member[name] = member[name].where(~lacks)
    member["tip_status"] = member["tip_status"].where(~lacks, -1)
    for draw in (draw_paths, draw_tip_cf):
        axes.clear()
        draw(axes, member, expand(scene_from_dict(SCENE)))
        labels = axes.get_legend_handles_labels()[1]
        assert any(label.startswith("left") for label in labels) == ("left" not in absent)
        assert not any(label.startswith("right") for label in labels)
        assert (axes.get_legend() is None) == (not labels)


def test_every_reference_is_drawn(axes: Axes, history: xr.Dataset) -> None:
    """Any number of references: markers repeat."""
    named = {f"author {k}": [[k, 1.0]] for k in range(9)}
    draw_paths(axes, history, expand(scene_from_dict(SCENE)), named)
    assert {name: lines(axes)[name].tolist() for name in named} == named


def test_a_part_that_cannot_be_seen_is_not_named(axes: Axes, history: xr.Dataset) -> None:
    """The last step of a severed body has no force; a step of zero length has no line."""
    words = list(reversed(PARTS))
    history["stability"][:] = [words.index(name) for name in ("stable", *["undefined"] * 4)]
    history["reaction_y"][2:] = np.nan
    history["reaction_y"][1], history["displacement_y"][1] = -1.0, -0.1
    draw_load_displacement(axes, history, "top")
    assert axes.get_legend_handles_labels()[1] == ["no growth"]


def test_steps_are_numbered_where_they_lie_apart(axes: Axes, history: xr.Dataset) -> None:
    draw_load_displacement(axes, history, "top")
    placed = {text.get_text(): tuple(text.xy) for text in axes.texts}
    assert placed == {
        f"step {k + 1}": (
            -float(history["displacement_y"][k, 0]),
            -float(history["reaction_y"][k, 0]),
        )
        for k in range(5)
    }


def test_a_hole_of_the_outline_stays_empty(axes: Axes, history: xr.Dataset) -> None:
    draw_paths(axes, history, expand(scene_from_dict(SCENE)))
    (path,) = axes.collections[0].get_paths()
    codes = np.asarray(path.codes)
    assert (codes == path.MOVETO).sum() == 2  # the outline and one hole


def test_parts_of_the_equilibrium_path_are_told_apart(axes: Axes, history: xr.Dataset) -> None:
    draw_load_displacement(axes, history, "top")
    shown = lines(axes)
    # Positive along the first force.
    np.testing.assert_allclose(shown["no growth"], [[0, 0], [0.1, 1.0]])
    np.testing.assert_allclose(shown[PARTS["stable"][2]], [[0.1, 1], [0.2, 1.5], [0.3, 2]])
    np.testing.assert_allclose(shown[PARTS["unstable"][2]], [[0.3, 2], [0.4, 1.8]])
    np.testing.assert_allclose(shown[PARTS["snap_back"][2]], [[0.4, 1.8], [0.3, 1.0]])
    assert PARTS["undefined"][2] not in shown
    assert axes.get_xlabel() == "displacement of top along -y [mm]"


def test_a_part_that_comes_back_is_named_once(axes: Axes, history: xr.Dataset) -> None:
    history["stability"][:] = [3, 2, 3, 2, 0]
    draw_load_displacement(axes, history, "top")
    labels = axes.get_legend_handles_labels()[1]
    assert len(labels) == len(set(labels)) == 3


def test_load_steps_come_before_growth(axes: Axes, history: xr.Dataset) -> None:
    waiting = history.copy(deep=True)
    waiting["tip_x"][1] = waiting["tip_x"][0]  # nothing grows in the first step
    draw_load_displacement(axes, waiting, "top")
    shown = lines(axes)
    before = [line.get_xydata().tolist() for line in axes.lines if line.get_color() == BLACK]
    assert before[:2] == [[[0, 0], [0.1, 1.0]], [[0.1, 1.0], [0.2, 1.5]]]
    np.testing.assert_allclose(shown[PARTS["stable"][2]], [[0.2, 1.5], [0.3, 2]])


def test_j_of_load_steps(axes: Axes, history: xr.Dataset) -> None:
    tips = ("step", "tip")
    j = np.arange(10.0).reshape(5, 2)
    draw_steps(axes, history.assign(J=(tips, j), cf_norm=(tips, j + 1.0)), "right")
    shown = lines(axes)
    assert shown["J"][:, 1].tolist() == [1.0, 3.0, 5.0, 7.0, 9.0]
    np.testing.assert_allclose(shown["|CF|"][:, 0], np.linspace(1.0, 2.0, 5))


def test_finite_deformation_has_no_kink_angle(axes: Axes, history: xr.Dataset) -> None:
    history["kink_angle"][:] = np.nan
    draw_angles(axes, history)
    assert not any("hoop" in label for label in lines(axes))


def test_one_state_alone_can_be_drawn(axes: Axes, history: xr.Dataset) -> None:
    draw_load_displacement(axes, history.isel(step=[0]), "top")
    np.testing.assert_allclose(axes.lines[0].get_xydata(), [[0, 0], [0.1, 1.0]])


def test_angles_stand_where_the_tip_ran(axes: Axes, history: xr.Dataset) -> None:
    draw_angles(axes, history)
    shown = lines(axes)
    right = shown["right: largest hoop stress"]
    assert right[:, 0].tolist() == [0.0, 1.0, 2.0, 3.0]  # the waiting step is left out
    assert right[:, 1].tolist() == [3.0, 5.0, 7.0, 9.0]
    assert (shown["left: configurational force"][:, 1] <= 0.0).all()


def test_load_against_the_growth_of_all_tips(axes: Axes, history: xr.Dataset) -> None:
    load = [1.0, 1.5, 1.2, 0.9, np.nan]  # after the last one the body is in two parts
    draw_load(axes, history.assign(load_factor=("step", load)))
    shown = lines(axes)
    # The second tip waits for a step.
    np.testing.assert_allclose(shown[PARTS["unstable"][2]], [[3.0, 1.2], [5.0, 0.9]])
    assert axes.get_ylim()[0] == 0.0
    assert (axes.get_xlabel()[-4:], axes.get_ylabel()[-3:]) == ("[mm]", "[1]")


def test_stress_intensity_factors_along_each_path(axes: Axes, history: xr.Dataset) -> None:
    k = np.arange(10.0).reshape(5, 2)
    tips = ("step", "tip")
    draw_factors(axes, history.assign(K_I=(tips, k), K_II=(tips, -k)))
    shown = lines(axes)
    np.testing.assert_array_equal(shown["left: $K_I$"], [[i, 2.0 * i] for i in range(5)])
    assert shown["right: $K_{II}$"][:, 1].tolist() == [-3.0, -5.0, -7.0, -9.0]
    assert "MPa mm" in axes.get_ylabel()


def test_each_tip_runs_by_its_own_cycles(axes: Axes, history: xr.Dataset) -> None:
    cycles = [0.0, 10.0, 30.0, 60.0, 100.0]
    draw_cycles(axes, history.assign(cycles=("step", cycles)))
    shown = lines(axes)
    np.testing.assert_array_equal(shown["right"], np.column_stack([cycles, [0, 0, 1, 2, 3]]))
    assert shown["left"][-1].tolist() == [100.0, 4.0]


def test_energies_add_up(axes: Axes, history: xr.Dataset) -> None:
    terms = {"external_work": 5.0, "strain_energy": 3.0, "fracture_energy": 1.5}
    rise = np.arange(5.0)
    draw_energy(axes, history.assign({k: ("step", v * rise) for k, v in terms.items()}))
    shown = lines(axes)
    np.testing.assert_array_equal(shown["external work"][:, 1], 5.0 * rise)
    np.testing.assert_allclose(shown["missing: external work - others"][:, 1], 0.5 * rise)
    assert shown["strain energy"][:, 0].tolist() == [0.0, 1.0, 3.0, 5.0, 7.0]
    assert "[N mm/mm]" in axes.get_ylabel()


def test_forces_are_drawn_of_the_parts_that_move(tmp_path: Path) -> None:
    result = run(scene_from_dict(SCENE))
    paths = save_growth(tmp_path, result.history, result.scene, result.grid)
    paths += save_steps(tmp_path, result.history)
    names = ["paths", "cf", "angles", "energy", "factors", "load", "force_top_y"]
    assert [path.name for path in paths] == [f"{name}.png" for name in names]
    assert {path.name for path in tmp_path.iterdir()} == {path.name for path in paths}


def test_arrows_that_would_cover_each_other_are_left_out(axes: Axes, history: xr.Dataset) -> None:
    tips = ("step", "tip")
    near = history.assign(
        tip_x=history["tip_x"] * 0.4,  # steps of 0.4 in a plate of 20: one arrow every fourth
        cf_x=(tips, np.ones((5, 2))),
        cf_y=(tips, np.zeros((5, 2))),
        cf_norm=(tips, np.ones((5, 2))),
    )
    draw_tip_cf(axes, near, expand(scene_from_dict(SCENE)))
    left, right = (c for c in axes.collections if isinstance(c, Quiver))
    assert left.X.tolist() == pytest.approx([0.0, 1.6])
    assert right.X.tolist() == pytest.approx([3.6])
    assert left.get_label() == "left: |CF| 1 N/mm"
