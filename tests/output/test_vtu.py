"""VTU files, read by pyvista."""

from __future__ import annotations

import errno
import json
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from growing_scene import growing
from typer.testing import CliRunner, Result

from cfmpm.cli.app import app
from cfmpm.output.fields import build_fields
from cfmpm.output.fields_by_step import FieldsByStep, list_fields
from cfmpm.output.files import write_dataset
from cfmpm.output.run_folder import HISTORY, INDEX
from cfmpm.output.vtu import export_vtu
from cfmpm.scene import scene_from_dict
from cfmpm.simulation import run

pyvista = pytest.importorskip("pyvista")


@pytest.fixture(scope="module", params=["T3", "T6"])
def folder(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run")
    scene = scene_from_dict(growing(request.param))
    run(scene, observe=FieldsByStep(folder, 2).observe)
    export_vtu(folder, folder / "vtu")
    return folder


@pytest.fixture(scope="module")
def finished(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that holds the history of its run too."""
    copy = shutil.copytree(folder, tmp_path_factory.mktemp("finished") / "run")
    scene = scene_from_dict(json.loads(xr.load_dataset(copy / INDEX).attrs["config"]))
    write_dataset(run(scene).history, copy / "history.nc")
    return copy


def call(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_time_is_the_step(folder: Path) -> None:
    for kind in ("grid", "points", "cracks"):
        assert pyvista.get_reader(folder / "vtu" / f"{kind}.pvd").time_values == [1.0, 3.0, 5.0]
    assert len(list((folder / "vtu").iterdir())) == 3 * (3 + 1)


@pytest.mark.parametrize("k", [0, 2])
def test_values_are_those_of_the_fields(folder: Path, k: int) -> None:
    fields = xr.load_dataset(list_fields(folder)[k]).isel(time=0)
    read = {}
    for kind in ("grid", "points", "cracks"):
        reader = pyvista.get_reader(folder / "vtu" / f"{kind}.pvd")
        reader.set_active_time_point(k)
        (read[kind],) = reader.read()
    grid, points, cracks = read["grid"], read["points"], read["cracks"]
    x = np.column_stack([fields["node_x"], fields["node_y"]])
    np.testing.assert_array_equal(grid.points[:, :2], x)
    np.testing.assert_array_equal(grid.point_data["u"][:, 1], fields["u_y"])
    np.testing.assert_array_equal(grid.point_data["cf"][:, 0], fields["cf_x"])
    np.testing.assert_array_equal(grid.point_data["cf"][:, 2], 0.0)
    np.testing.assert_array_equal(grid.cell_data["von_mises"], fields["von_mises"])
    np.testing.assert_array_equal(grid.cells_dict[pyvista.CellType.TRIANGLE], fields["face_nodes"])
    np.testing.assert_array_equal(points.points[:, 0], fields["point_x"])
    np.testing.assert_array_equal(points.point_data["sigma_xy"], fields["point_sigma_xy"])
    assert points.n_cells == fields.sizes["point"]
    # An edge crack of 4 mm, and what has grown.
    assert cracks.n_cells == 1
    length = float(cracks.compute_cell_sizes()["Length"].sum())
    assert length == pytest.approx(float(fields["crack_length"]), rel=1e-12)


def test_two_cracks_are_two_lines(tmp_path: Path) -> None:
    scene = growing()
    del scene["family"], scene["growth"]
    scene["geometry"] = {
        "outline": [[0, 0], [10, 0], [10, 20], [0, 20]],
        "cracks": [
            {"name": "low", "points": [[0, 6], [3, 6]]},
            {"name": "bent", "points": [[3, 12], [5, 12], [6, 13]]},
        ],
    }
    scene["loads"] = [
        {"edge": "edge_1", "displacement": {"x": 0, "y": 0}},
        {"edge": "edge_3", "traction": [0, 10]},
    ]
    fields = build_fields(run(scene_from_dict(scene)))
    write_dataset(fields, tmp_path / "fields.nc")
    export_vtu(tmp_path, tmp_path)
    cracks = pyvista.read(tmp_path / "cracks_0001.vtu")
    lengths = cracks.compute_cell_sizes()["Length"]
    np.testing.assert_allclose(lengths, [3.0, 2.0 + np.sqrt(2.0)], rtol=1e-12)
    assert cracks.cell_data["crack"].tolist() == [0, 1]


def test_the_command_names_what_it_wrote(folder: Path, tmp_path: Path) -> None:
    result = call("export", folder, "--format", "vtu", "--output", tmp_path / "out")
    assert result.exit_code == 0, result.output
    lines = result.stdout.split()
    assert [Path(line).name for line in lines] == ["grid.pvd", "points.pvd", "cracks.pvd"]
    assert all(Path(line).is_file() for line in lines)


def test_without_fields_it_says_what_makes_them(finished: Path, tmp_path: Path) -> None:
    shutil.copy(finished / HISTORY, tmp_path)
    result = call("export", tmp_path)
    assert result.exit_code == 2
    assert "output.fields" in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == [HISTORY]


@pytest.fixture(scope="module")
def mixed(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Fields of one scene beside the history of another."""
    copy = shutil.copytree(folder, tmp_path_factory.mktemp("mixed") / "run")
    other = growing()
    other["material"]["g_c"] = 2.0
    write_dataset(run(scene_from_dict(other)).history, copy / "history.nc")
    return copy


def test_fields_of_another_run_are_refused(mixed: Path) -> None:
    result = call("export", mixed)
    assert result.exit_code == 2
    assert "fields_index.nc: belongs to another run than history.nc" in result.stderr


@pytest.mark.slow
def test_no_film_of_fields_of_another_run(mixed: Path, tmp_path: Path) -> None:
    """Fields of one scene never go with the history of another."""
    copy = shutil.copytree(mixed, tmp_path / "copy")
    result = call("plot", copy)
    assert result.exit_code == 0
    assert "fields_index.nc: belongs to another run" in result.stderr
    assert not (copy / "growth.gif").exists()


@pytest.mark.parametrize("command", [pytest.param("plot", marks=pytest.mark.slow), "export"])
def test_fields_that_are_gone_are_said_to_be_missing(
    finished: Path, tmp_path: Path, command: str
) -> None:
    copy = shutil.copytree(finished, tmp_path / "copy")
    (copy / "fields_0003.nc").unlink()
    result = call(command, copy)
    assert (result.exit_code, "fields_0003.nc: is listed" in result.stderr) == (
        2 if command == "export" else 0,
        True,
    )
    assert "cannot write" not in result.stderr


@pytest.mark.parametrize("kind", ["series", "end"])
def test_damaged_fields_cannot_be_read(finished: Path, tmp_path: Path, kind: str) -> None:
    copy = shutil.copytree(finished, tmp_path / "copy")
    damaged = copy / "fields_0003.nc"
    if kind == "end":
        (copy / INDEX).unlink()
        damaged = damaged.rename(copy / "fields.nc")
    whole = damaged.read_bytes()
    damaged.write_bytes(whole[: len(whole) // 2])
    result = call("export", copy)
    assert result.exit_code == 2
    assert f"{damaged.name}: cannot be read as netCDF" in result.stderr


@pytest.mark.slow
def test_a_film_of_damaged_fields_leaves_the_other_pictures(finished: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(finished, tmp_path / "copy")
    damaged = copy / "fields_0003.nc"
    whole = damaged.read_bytes()
    damaged.write_bytes(whole[: len(whole) // 2])
    result = call("plot", copy)
    assert result.exit_code == 0
    assert f"no film: {damaged}: cannot be read as netCDF" in result.stderr
    assert {"scene.png", "paths.png"} <= {Path(line).name for line in result.stdout.split()}


def test_a_collection_that_cannot_be_written_leaves_the_old_one(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    copy = shutil.copytree(folder, tmp_path / "copy")
    before = (copy / "vtu" / "grid.pvd").read_text()

    write = Path.write_text

    def write_half(path: Path, text: str) -> int:
        if ".pvd." not in path.name:
            return write(path, text)
        path.write_bytes(text.encode()[: len(text) // 2])
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_text", write_half)
    with pytest.raises(OSError, match="No space"):
        export_vtu(copy, copy / "vtu")
    assert (copy / "vtu" / "grid.pvd").read_text() == before
    assert not list((copy / "vtu").glob(".*"))


def test_without_pyvista_it_names_the_extra(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyvista", None)
    result = call("export", folder, "--output", tmp_path / "out")
    assert result.exit_code == 1
    assert "pip install 'cfmpm[export]'" in result.stderr
    assert not (tmp_path / "out").exists()
