"""Figures: the data that they show."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.image import imread
from matplotlib.patches import Circle
from matplotlib.quiver import Quiver
from structured import rectangle

from cfmpm.body.grid import Grid, build_grid
from cfmpm.body.points import seed
from cfmpm.output.fields import build_fields
from cfmpm.plotting import (
    Mesh,
    draw_deformed,
    draw_grid,
    draw_radii,
    draw_scene,
    draw_tip_forces,
    draw_tip_points,
    picture,
)
from cfmpm.plotting.deformed import magnification
from cfmpm.plotting.files import (
    save_deformed,
    save_radii,
    save_scene,
    save_tip_forces,
    save_tip_points,
)
from cfmpm.plotting.scene import ENTRIES
from cfmpm.plotting.tip import norm_is_apart
from cfmpm.scene import scene_from_dict
from cfmpm.simulation import run
from cfmpm.state import Result


@pytest.fixture
def axes() -> Axes:
    return Figure().add_subplot()


@pytest.fixture(params=["T3", "T6"])
def cracked(request: pytest.FixtureRequest) -> Grid:
    return build_grid(rectangle(6, 4, 6.0, 4.0, crack=(2, 0, 3)), request.param)


@pytest.fixture(scope="module")
def result() -> Result:
    return run(
        scene_from_dict(
            {
                "name": "plate",
                "family": {
                    "kind": "plate_with_holes",
                    "width": 20,
                    "height": 10,
                    "holes": [{"centre": [15, 5], "radius": 2}],
                    "cracks": [{"points": [[0, 5], [6, 5]]}],
                },
                "material": {"E": 210e3, "nu": 0.3},
                "loads": [
                    {"edge": "bottom", "displacement": {"x": 0, "y": 0}},
                    {"edge": "left", "displacement": {"x": 0}},
                    {"edge": "top", "traction": [0, 5]},
                    {"edge": "right", "traction": [-5, 0]},
                    {"edge": "hole_1", "traction": [1, 0]},
                    {"name": "nudge", "point": [12, 10], "force": [3, 0]},
                    {"name": "weight", "body_force": [0, -1e-3]},
                ],
                "mesh": {"size": 1},
                "fracture": {"radii": 2},
            }
        )
    )


@pytest.fixture(scope="module")
def fields(result: Result) -> xr.Dataset:
    return build_fields(result)


def collections(axes: Axes, kind: type) -> list:
    return [c for c in axes.collections if isinstance(c, kind)]


def arrows(axes: Axes, label: str) -> Quiver:
    (found,) = (q for q in collections(axes, Quiver) if str(q.get_label()).startswith(label))
    return found


def test_each_edge_of_the_grid_is_drawn_once(axes: Axes, cracked: Grid) -> None:
    draw_grid(axes, cracked)
    inner, outer, crack = collections(axes, LineCollection)
    parts = 2 if cracked.elements.shape[1] == 6 else 1  # a middle node parts a side
    n_inner = int((cracked.twins >= 0).sum()) // 2
    n_outer = int((cracked.twins < 0).sum())
    assert len(inner.get_segments()) == parts * n_inner
    assert len(outer.get_segments()) == parts * n_outer
    assert len(crack.get_segments()) == 3
    (tip,) = (line for line in axes.lines if line.get_marker() == "o")
    np.testing.assert_array_equal(tip.get_xydata(), [[3.0, 2.0]])


def test_length_axes_are_equal_and_have_units(axes: Axes, cracked: Grid) -> None:
    assert draw_grid(axes, cracked, colour="red") is axes
    assert axes.get_aspect() == 1.0
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x [mm]", "y [mm]")
    assert axes.get_xlim()[0] <= 0.0
    assert axes.get_xlim()[1] >= 6.0


def test_arrows_at_the_nodes_of_the_domain_and_their_sum(axes: Axes, cracked: Grid) -> None:
    (tip,) = cracked.tips
    force = np.random.default_rng(1).normal(size=cracked.nodes.shape)
    draw_tip_forces(axes, cracked, force, tip, 1.5)
    near = np.hypot(*(cracked.nodes - [3.0, 2.0]).T) <= 1.5
    at_nodes, total = arrows(axes, "at "), arrows(axes, "sum over the domain")
    assert len(at_nodes.U) == near.sum()
    assert (total.U[0], total.V[0]) == pytest.approx(tuple(force[near].sum(axis=0)))
    assert total.scale == at_nodes.scale
    (circle,) = (p for p in axes.patches if isinstance(p, Circle))
    assert (circle.center, circle.radius) == ((3.0, 2.0), 1.5)
    assert axes.get_xlim() == pytest.approx((3.0 - 1.725, 3.0 + 1.725))


def test_a_tip_without_force(axes: Axes, cracked: Grid) -> None:
    draw_tip_forces(axes, cracked, np.zeros_like(cracked.nodes), cracked.tips[0], 1.0)
    axes.figure.draw_without_rendering()


def test_points_near_a_tip_and_all_of_them_counted(axes: Axes, cracked: Grid) -> None:
    (tip,) = cracked.tips
    points = seed(cracked)
    draw_tip_points(axes, cracked, points, tip, [2.0, 1.0])
    (drawn,) = (line for line in axes.lines if str(line.get_label()).startswith("material"))
    near = (np.abs(points.position - [3.0, 2.0]) <= 1.15).all(axis=1)
    np.testing.assert_array_equal(drawn.get_xydata(), points.position[near])
    assert drawn.get_label() == f"material points, {len(points)} in all"
    (circle,) = (p for p in axes.patches if isinstance(p, Circle))
    assert circle.radius == 1.0  # the smallest domain
    assert axes.get_xlim() == pytest.approx((3.0 - 1.15, 3.0 + 1.15))


def test_what_the_domains_give_by_radius(axes: Axes) -> None:
    by_radius = {
        name: ("radius", values)
        for name, values in {
            "domain_radius": [4.0, 1.0, 2.0],
            "G_radius": [1.4, 1.1, 1.2],
            "J_radius": [2.4, 2.1, 2.2],
            "cf_norm_radius": [3.4, 3.1, 3.2],
            "K_I_radius": [5.0, 5.0, 5.0],
        }.items()
    }
    at = xr.Dataset(by_radius, {"step": 3, "load_factor": 0.5})
    draw_radii(axes, at)
    shown = {str(line.get_label()): line.get_xydata().tolist() for line in axes.lines}
    assert shown["J"] == [[1.0, 2.1], [2.0, 2.2], [4.0, 2.4]]
    assert shown["|CF|"] == [[1.0, 3.1], [2.0, 3.2], [4.0, 3.4]]
    assert axes.get_title() == "step 3, load factor 0.5"
    assert axes.get_xlabel().endswith("[mm]")
    assert axes.get_ylabel().endswith("[N/mm]")
    axes.clear()
    draw_radii(axes, at, norm=False)
    assert {str(line.get_label()) for line in axes.lines} == {"G from K_I and K_II", "J"}
    axes.clear()
    draw_radii(axes, at.assign(K_I_radius=("radius", [np.nan] * 3)))
    assert {str(line.get_label()) for line in axes.lines} == {"J", "|CF|"}


def test_curves_that_coincide_are_both_seen(axes: Axes) -> None:
    same = ("radius", [1.0, 1.0, 1.0])
    at = xr.Dataset(
        {
            "domain_radius": ("radius", [1.0, 2.0, 4.0]),
            "G_radius": same,
            "J_radius": same,
            "cf_norm_radius": same,
            "K_I_radius": same,
        },
        {"step": 3, "load_factor": 0.5},
    )
    assert not norm_is_apart(at)
    draw_radii(axes, at)
    energy, j, norm = axes.lines
    assert j.get_markerfacecolor() == "none"
    assert j.get_markersize() > max(energy.get_markersize(), norm.get_markersize())
    assert j.get_linestyle() != energy.get_linestyle()


def test_a_norm_far_from_j_has_a_scale_of_its_own(result: Result, tmp_path: Path) -> None:
    """In mixed mode the differences between G and J would not be visible on its scale."""
    j = result.history["G_radius"] * 1.001
    near = result.history.assign(J_radius=j, cf_norm_radius=j * 1.0005)
    far = near.assign(cf_norm_radius=j * 1.3)
    assert not norm_is_apart(near.isel(step=0, tip=0))
    assert norm_is_apart(far.isel(step=0, tip=0))
    heights = [imread(save_radii(tmp_path, history)[0]).shape[0] for history in (near, far)]
    assert heights[1] > 1.7 * heights[0]


def test_a_legend_of_very_many_loads_stays_short(axes: Axes, result: Result) -> None:
    """Equal loads share an entry; the legend does not change the size of a figure."""
    (first, *_) = (load for load in result.scene.loads if load.kind == "traction")
    boundary = result.loading.boundaries[str(first.name)]
    names = [f"bolt_{i}" for i in range(70)]
    alike = [first.model_copy(update={"name": name}) for name in names]
    loading = replace(result.loading, boundaries=dict.fromkeys(names, boundary))
    draw_scene(
        axes, result.scene.model_copy(update={"loads": tuple(alike)}), result.grid, loading, []
    )
    (text,) = axes.get_legend().get_texts()
    assert text.get_text() == "bolt_0 and 69 like it: traction (0, 5) MPa"
    axes.clear()
    differ = [load.model_copy(update={"traction": (0.0, float(i))}) for i, load in enumerate(alike)]
    draw_scene(
        axes, result.scene.model_copy(update={"loads": tuple(differ)}), result.grid, loading, []
    )
    texts = [text.get_text() for text in axes.get_legend().get_texts()]
    assert len(texts) == ENTRIES
    assert texts[-1] == f"and {70 - (ENTRIES - 1)} more loads"


def test_loads_and_supports_of_a_scene(axes: Axes, result: Result) -> None:
    draw_scene(axes, result.scene, result.grid, result.loading, [0.5])
    _, labels = axes.get_legend_handles_labels()
    assert {label.split(":")[0] for label in labels} == {load.name for load in result.scene.loads}
    assert "top: traction (0, 5) MPa" in labels
    assert "left: u_x = 0 mm" in labels
    heads = {}
    for name in ("top", "right", "nudge"):
        drawn = arrows(axes, name)
        tails = np.column_stack([drawn.X, drawn.Y])
        heads[name] = tails, tails + np.column_stack([drawn.U, drawn.V])
    # The top is pulled: its arrows start there. The right side is pushed: they end there.
    assert heads["top"][0][:, 1] == pytest.approx(10.0)
    assert heads["right"][1][:, 0] == pytest.approx(20.0)
    # The force along the top stands off it.
    assert heads["nudge"][0][:, 1] > 10.0
    markers = {str(line.get_label()).split(":")[0]: line.get_marker() for line in axes.lines}
    assert (markers["bottom"], markers["left"]) == ("s", ">")
    (circle,) = (p for p in axes.patches if isinstance(p, Circle))
    assert circle.radius == 0.5


def test_arrows_on_a_hole_lie_in_the_hole(axes: Axes, result: Result) -> None:
    draw_scene(axes, result.scene, result.grid, result.loading)
    drawn = arrows(axes, "hole_1")
    middle = np.column_stack([drawn.X + drawn.U / 2, drawn.Y + drawn.V / 2])
    assert np.hypot(*(middle - [15.0, 5.0]).T).max() < 2.0


def test_the_deformed_grid_is_the_grid_moved(axes: Axes, fields: xr.Dataset) -> None:
    draw_deformed(axes, fields)
    (faces,) = collections(axes, PolyCollection)
    mesh = Mesh.of_fields(fields)
    u = np.column_stack([fields["u_x"][0], fields["u_y"][0]])
    factor = magnification(u, mesh.nodes)
    assert f"× {factor:g}," in axes.get_title()
    np.testing.assert_array_equal(faces.get_array(), fields["von_mises"].values[0])
    corners = np.array([path.vertices[:3] for path in faces.get_paths()])
    np.testing.assert_allclose(corners, (mesh.nodes + factor * u)[mesh.faces])
    low, high = faces.get_clim()
    assert float(fields["von_mises"].min()) <= low < high < float(fields["von_mises"].max())
    colour_bar = axes.figure.axes[-1]
    label, what = colour_bar.get_ylabel().split("\n")
    assert label == "equivalent stress of von Mises [MPa]"
    assert what == "the bar spans 98 % of the area"


def test_a_severed_body_is_drawn_without_stress(axes: Axes, fields: xr.Dataset) -> None:
    # A part that moves as a whole: what stress there is comes from round-off.
    moved = fields.copy(deep=True)
    moved["u_x"][:], moved["u_y"][:] = 0.0, 0.1
    moved["von_mises"][:] = 1e-9 * np.arange(fields.sizes["face"]) / fields.sizes["face"]
    draw_deformed(axes, moved)
    assert "stress-free" in axes.get_title()
    (faces,) = collections(axes, PolyCollection)
    assert faces.get_clim() == (0.0, 1.0)


def test_a_mesh_from_fields_is_that_of_the_grid(result: Result, fields: xr.Dataset) -> None:
    read, made = Mesh.of_fields(fields), Mesh.of_grid(result.grid)
    for name in ("nodes", "faces", "element"):
        np.testing.assert_array_equal(getattr(read, name), getattr(made, name))


@pytest.mark.parametrize(
    ("largest", "factor"), [(5.0, 1.0), (0.5, 10.0), (0.26, 10.0), (0.02, 200.0), (50.0, 1.0)]
)
def test_magnification_is_a_round_number(largest: float, factor: float) -> None:
    nodes = np.array([[0.0, 0.0], [100.0, 40.0]])
    assert magnification(np.array([[0.0, 0.0], [0.0, largest]]), nodes) == pytest.approx(factor)


def test_nothing_moves() -> None:
    assert magnification(np.zeros((2, 2)), np.array([[0.0, 0.0], [1.0, 1.0]])) == 1.0


def test_files_are_pictures(result: Result, fields: xr.Dataset, tmp_path: Path) -> None:
    paths = [
        save_scene(tmp_path, result.scene, result.body),
        save_deformed(tmp_path, fields),
        *save_tip_forces(tmp_path, fields, result.history),
        *save_tip_points(tmp_path, result.body),
        *save_radii(tmp_path, result.history),
    ]
    names = ["cf_crack_1", "deformed", "mesh_crack_1", "radii_crack_1", "scene"]
    names = [f"{name}.png" for name in names]
    assert sorted(path.name for path in tmp_path.iterdir()) == names
    for path in paths:
        assert np.ptp(imread(path)) > 0.5


def test_a_picture_that_fails_leaves_no_file(tmp_path: Path) -> None:
    def draw() -> None:
        with picture(tmp_path / "a.png", (3, 3)) as axes:
            axes.plot([0, 1])
            raise ValueError

    with pytest.raises(ValueError):  # noqa: PT011
        draw()
    assert list(tmp_path.iterdir()) == []
