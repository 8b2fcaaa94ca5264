"""The accessor ``ds.cfmpm``, and how a history is opened."""

from __future__ import annotations

import json
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import gmsh
import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.quiver import Quiver

import cfmpm
from cfmpm.api import Result, run
from cfmpm.output.files import write_dataset
from cfmpm.scene import scene_from_dict
from cfmpm.study import expansion
from cfmpm.study.collecting import collect
from cfmpm.study.member import solve
from cfmpm.study.reading import Plan, load_study

SCENE = {
    "name": "plate",
    "family": {
        "kind": "plate_with_holes",
        "width": 20,
        "height": 10,
        "holes": [{"centre": [15, 5], "radius": 2}],
        "cracks": [{"name": "left", "points": [[0, 5], [3, 5]]}],
    },
    "material": {"E": 210e3, "nu": 0.3, "g_c": 1.0},
    "loads": [
        {"edge": "bottom", "displacement": {"x": 0, "y": 0}},
        {"edge": "top", "displacement": {"x": 0, "y": 0.01}},
    ],
    "mesh": {"element": "T3", "size": 1},
    "growth": {"control": "crack", "increments": 3},
}


@pytest.fixture(scope="module")
def result() -> Result:
    return run(scene_from_dict(SCENE))


@pytest.fixture
def axes() -> Axes:
    return Figure().add_subplot()


def test_a_path_begins_at_the_tip_and_follows_the_steps(result: Result) -> None:
    (path,) = result.history.cfmpm.path().values()
    assert path[0].tolist() == [3.0, 5.0]
    assert len(path) == result.history.sizes["step"]
    np.testing.assert_array_equal(path[:, 1], result.history["tip_y"].values[:, 0])
    lengths = np.hypot(*np.diff(path, axis=0).T)
    grown = result.history["crack_length"].values[:, 0]
    assert lengths.sum() == pytest.approx(grown[-1] - grown[0], rel=1e-12)


def test_steps_that_a_shorter_run_lacks_are_no_places(result: Result) -> None:
    longer = result.history.reindex(step=np.arange(1, 9))
    np.testing.assert_array_equal(longer.cfmpm.path()["left"], result.history.cfmpm.path()["left"])


def test_the_plotted_path_is_the_path(result: Result, axes: Axes) -> None:
    assert result.history.cfmpm.plot_path(axes, {"other": [[1.0, 2.0]]}) is axes
    lines = {str(line.get_label()): np.column_stack(line.get_data()) for line in axes.lines}
    np.testing.assert_array_equal(lines["left"], result.history.cfmpm.path()["left"])
    np.testing.assert_array_equal(lines["other"], [[1.0, 2.0]])
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x [mm]", "y [mm]")


def test_arrows_have_the_direction_and_size_of_the_force(result: Result, axes: Axes) -> None:
    result.history.cfmpm.plot_cf(axes)
    (arrows,) = (c for c in axes.collections if isinstance(c, Quiver))
    tip = result.history.sel(tip="left")
    rows = [int(np.argmin(np.abs(tip["tip_x"].values - x))) for x in arrows.X]
    np.testing.assert_array_equal(arrows.U, tip["cf_x"].values[rows])
    np.testing.assert_array_equal(arrows.V, tip["cf_y"].values[rows])
    # Forward, and none longer than its share of the plate.
    assert (arrows.U > 0.0).all()
    assert float(tip["cf_norm"].max()) / arrows.scale == pytest.approx(0.06 * 20.0)


def test_without_axes_there_is_a_new_figure(result: Result) -> None:
    made = result.history.cfmpm.plot_path()
    assert made.figure.number in plt.get_fignums()
    plt.close(made.figure)


def test_work_is_stored_or_spent_on_fracture(result: Result) -> None:
    balance = result.history.cfmpm.energy_balance()
    work, stored, spent = (
        balance[name].values for name in ("external_work", "strain_energy", "fracture_energy")
    )
    np.testing.assert_allclose(balance["missing"], work - stored - spent, atol=1e-14 * work.max())
    # Linear up to the first growth: no work is missing. Then g_c times the new length.
    assert work[0] == pytest.approx(stored[0], rel=1e-12)
    length = result.history["crack_length"].values[:, 0]
    np.testing.assert_allclose(spent, 1.0 * (length - length[0]), rtol=1e-12)
    assert all(balance[name].attrs["units"] == "N" for name in balance.data_vars)


def test_energy_is_left_over_at_a_load_above_the_critical_one() -> None:
    loads = [SCENE["loads"][0], {"edge": "top", "displacement": {"x": 0, "y": 0.1}}]
    scene = SCENE | {
        "loads": loads,
        "mesh": {"element": "T6", "size": 0.4, "grading": "uniform"},
        "growth": {"control": "load", "increments": 3},
    }
    history = run(scene_from_dict(scene)).history
    missing = history.cfmpm.energy_balance()["missing"].values
    # Fixed grips do no work: between G and g_c lies what is set free.
    length = history["crack_length"].values[:, 0]
    g = history["G"].values[:, 0]
    assert g.min() > 10.0
    assert (np.diff(missing) > 0.0).all()
    released = 0.5 * (g[1:] + g[:-1]) * np.diff(length)
    np.testing.assert_allclose(np.diff(missing), released - np.diff(length), rtol=0.05)


def test_plastic_work_is_not_missing(result: Result) -> None:
    spent = result.history["external_work"] * 0.25
    balance = result.history.assign(plastic_work=spent).cfmpm.energy_balance()
    without = result.history.cfmpm.energy_balance()
    assert "plastic_work" not in without
    np.testing.assert_allclose(balance["missing"], without["missing"] - spent)


def test_the_scene_of_a_history_is_the_one_that_was_run(result: Result) -> None:
    assert result.history.cfmpm.scene == scene_from_dict(SCENE)


def test_a_history_is_opened_by_folder_or_file(result: Result, tmp_path: Path) -> None:
    write_dataset(result.history, tmp_path / "history.nc")
    for path in (tmp_path, str(tmp_path), tmp_path / "history.nc"):
        xr.testing.assert_identical(cfmpm.open_history(path), result.history)
    (tmp_path / "history.nc").unlink()  # it is in memory, and the file is closed


def test_a_folder_without_a_history_is_refused(tmp_path: Path) -> None:
    with pytest.raises(cfmpm.SceneError, match=r"history\.nc: no such result"):
        cfmpm.open_history(tmp_path)


def test_a_damaged_configuration_names_the_file(result: Result, tmp_path: Path) -> None:
    write_dataset(result.history.assign_attrs(config="{"), tmp_path / "history.nc")
    with pytest.raises(cfmpm.SceneError, match=r"history\.nc: .*damaged"):
        _ = cfmpm.open_history(tmp_path).cfmpm.scene


def test_a_dataset_of_something_else_has_no_accessor() -> None:
    with pytest.raises(ValueError, match="not the history"):
        xr.Dataset({"a": 1}).cfmpm.path()


def test_of_several_runs_one_is_to_be_chosen(result: Result) -> None:
    both = xr.concat([result.history] * 2, "E")
    assert "plot_path" in dir(both.cfmpm)  # what an editor completes
    with pytest.raises(ValueError, match=r"select one along E"):
        both.cfmpm.path()
    assert set(both.isel(E=0).cfmpm.path()) == {"left"}


def write_square(path: Path) -> None:
    """A square of side 10 as a mesh file, with the curve of a crack from the left to its middle."""
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 1)
        cad = gmsh.model.geo
        corners = [(0, 0), (10, 0), (10, 10), (0, 10), (0, 5), (5, 5)]
        points = [cad.addPoint(x, y, 0) for x, y in corners]
        *ring, mouth, tip = points
        sides = [cad.addLine(a, b) for a, b in pairwise([*ring, mouth, ring[0]])]
        slit = cad.addLine(mouth, tip)
        surface = cad.addPlaneSurface([cad.addCurveLoop(sides)])
        cad.synchronize()
        gmsh.model.mesh.embed(1, [slit], 2, surface)
        for name, curve in {"bottom": sides[0], "top": sides[2], "slit": slit}.items():
            gmsh.model.addPhysicalGroup(1, [curve], name=name)
        gmsh.model.addPhysicalGroup(2, [surface], name="plate")
        gmsh.model.mesh.generate(2)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


def test_one_step_and_one_tip_are_enough(result: Result, axes: Axes) -> None:
    last = result.history.isel(step=-2, tip=0).cfmpm
    x, y = (result.history[name].values[-2, 0] for name in ("tip_x", "tip_y"))
    assert last.path()["left"].tolist() == [[x, y]]
    last.plot_cf(axes)
    assert sum(isinstance(c, Quiver) for c in axes.collections) == 1


def solved(folder: Path, **sections: Any) -> tuple[Plan, xr.Dataset]:
    """A study of the plate, and its dataset as it is read back."""
    study = {"name": "both", "base": "base.yaml", **sections}
    (folder / "base.yaml").write_text(json.dumps(SCENE))
    (folder / "study.yaml").write_text(json.dumps(study))
    plan = load_study(folder / "study.yaml")
    found = {one.key: solve(one.job()) for one in plan.members}
    write_dataset(collect(plan, found), folder / "study.nc")
    return plan, xr.load_dataset(folder / "study.nc")


@pytest.mark.slow
def test_a_member_of_a_study_has_its_own_scene(tmp_path: Path, axes: Axes) -> None:
    sections = {
        "replace": {"material.nu": 0.2},
        "product": {
            "E": {"key": "material.E", "values": [1e5, 2e5]},
            "growth": {
                "key": "growth",
                "values": {"one": {"control": "crack", "increments": 1}},
            },
            "element": {"key": "mesh.element", "values": ["T3", "T6"]},
        },
    }
    plan, whole = solved(tmp_path, **sections)
    for one in plan.members:
        member = whole.isel(dict(zip(("E", "growth", "element"), one.index, strict=True)))
        assert member.cfmpm.scene == one.scene
        alone = run(one.scene).history.cfmpm
        np.testing.assert_array_equal(member.cfmpm.path()["left"], alone.path()["left"])
    member.cfmpm.plot_path(axes)
    for name in ("E", "growth"):
        with pytest.raises(ValueError, match=f"coordinate {name}"):
            _ = member.drop_vars(name).cfmpm.scene


@pytest.mark.slow
def test_what_was_drawn_at_random_stands_in_the_dataset(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another scipy may draw other numbers."""
    uniform = {"distribution": "uniform", "arguments": {"loc": 1e5, "scale": 1e5}}
    cube = {"samples": 2, "parameters": {"E": {"key": "material.E", **uniform}}}
    plan, whole = solved(tmp_path, latin_hypercube=cube)
    monkeypatch.setattr(expansion, "draws", lambda cube: {"E": [1.5e5, 1.6e5]})
    for one in plan.members:
        assert whole.isel(sample=one.index[0]).cfmpm.scene == one.scene


def test_the_body_of_a_mesh_file_is_its_grid(tmp_path: Path, axes: Axes) -> None:
    write_square(tmp_path / "a.msh")
    scene = {key: SCENE[key] for key in ("name", "material", "loads", "growth")} | {
        "mesh_file": {"file": str(tmp_path / "a.msh"), "cracks": ["slit"]},
        "mesh": {"element": "T3"},
    }
    history = run(scene_from_dict(scene)).history
    history.cfmpm.plot_path(axes)
    assert history.cfmpm.path()["slit"][0] == pytest.approx([5.0, 5.0])
    assert axes.get_xlim()[1] >= 10.0


def test_importing_costs_no_numba_and_no_matplotlib() -> None:
    code = (
        "import sys, cfmpm\n"
        "assert 'xarray' not in sys.modules\n"
        "import xarray, cfmpm.accessor\n"
        "assert xarray.Dataset.cfmpm is cfmpm.accessor.History\n"
        "heavy = {'numba', 'matplotlib', 'gmsh', 'pydantic', 'scipy'}\n"
        "sys.exit(str(heavy & set(sys.modules)) if heavy & set(sys.modules) else 0)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
