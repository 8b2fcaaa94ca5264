"""Malicious files, and places where nothing can be written."""

from __future__ import annotations

import json
import os
import resource
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

from cfmpm.cli.app import app
from cfmpm.errors import SceneError
from cfmpm.output import netcdf
from cfmpm.output.checkpoint import read_checkpoint
from cfmpm.output.files import store
from cfmpm.output.netcdf import DamagedError, read_netcdf
from cfmpm.output.run_writer import RunWriter
from cfmpm.scene import load_scene
from cfmpm.simulation import run

SCENE = """\
name: small
family: {kind: single_edge, width: 10, height: 20, crack_length: 4, traction: 10}
material: {E: 210e3, nu: 0.3, g_c: 1.0}
mesh: {element: T3, size: 4}
growth: {control: crack, increments: 2}
output: {every: 1, fields: true}
"""
STUDY = "name: s\nbase: {}\nproduct: {{t: {{key: family.traction, values: [1]}}}}\n"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scene file, a finished run and an interrupted run."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "scene.yaml").write_text(SCENE)
    for name in ("finished", "broken_off"):
        (folder / name).mkdir()
        writer = RunWriter(folder / name)
        result = run(load_scene(folder / "scene.yaml"), observe=writer.observe)
        if name == "finished":
            writer.finish(result)
    return folder


@pytest.fixture
def folder(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of both beside a file that must not change."""
    shutil.copytree(made, tmp_path / "a" / "copy")
    monkeypatch.chdir(tmp_path / "a" / "copy")
    (tmp_path / "a" / "precious.png").write_text("dear")
    return tmp_path / "a" / "copy"


def refused(*words: object) -> str:
    """The single line of the error message."""
    done = CliRunner().invoke(app, [str(word) for word in words])
    assert done.exit_code == 2, done.output
    assert done.stderr.count("\n") == 1, done.stderr
    return done.stderr


def changed(path: Path, **values: Any) -> None:
    """Put other values into a dataset."""
    dataset = xr.load_dataset(path)
    for name, value in values.items():
        dataset[name] = (dataset[name].dims, value, dataset[name].attrs)
    path.unlink()
    store(dataset, path)


def python(*words: object, **options: Any) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "cfmpm", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, **options)


@pytest.mark.parametrize("name", ["../../precious.png", "/etc/passwd", "scene.png", "fields_01.nc"])
@pytest.mark.parametrize("command", ["resume", "export", "plot"])
def test_a_table_of_fields_names_files_of_its_own_folder(
    folder: Path, name: str, command: str
) -> None:
    for result in ("finished", "broken_off"):
        files = xr.load_dataset(folder / result / "fields_index.nc")["file"].values.astype(object)
        files[-1] = name
        changed(folder / result / "fields_index.nc", file=files)
    result = folder / ("broken_off" if command == "resume" else "finished")
    before = {path: path.read_bytes() for path in result.iterdir()}
    done = CliRunner().invoke(app, [command, str(result)])
    assert "fields_index.nc: is damaged: the fields of step 3 are in fields_0003.nc" in done.stderr
    assert done.exit_code == (0 if command == "plot" else 2)  # but for the film all is drawn
    assert (folder.parent / "precious.png").read_text() == "dear"
    assert {path: path.read_bytes() for path in before} == before


def test_names_of_tips_stay_in_the_folder(folder: Path) -> None:
    """Not even if a folder of that name exists."""
    history = folder / "finished" / "history.nc"
    (folder / "finished" / "mesh_").mkdir()
    changed(history, tip=np.array(["/../../../precious"], object))
    done = CliRunner().invoke(app, ["plot", str(folder / "finished")])
    assert done.exit_code in (0, 2), done.output
    done = CliRunner().invoke(
        app, ["run", "scene.yaml", "--output", str(folder / "finished"), "--overwrite"]
    )
    assert done.exit_code == 0, done.output
    assert (folder.parent / "precious.png").read_text() == "dear"


def test_links_out_of_a_result_are_not_followed(folder: Path) -> None:
    outside = folder.parent / "outside"
    outside.mkdir()
    (outside / "grid_0001.vtu").write_text("dear")
    (outside / "lock").write_text("dear")
    result = folder / "finished"
    (result / "vtu").symlink_to(outside)
    (result / ".lock").symlink_to(outside / "lock")
    (result / ".started").symlink_to(outside / "started")
    assert "vtu: is a link" in refused("export", result)
    done = CliRunner().invoke(app, ["run", "scene.yaml", "--output", str(result)])
    assert done.exit_code == 0, done.output
    assert xr.load_dataset(result / "history.nc").attrs["run_status"] == "increments"
    assert {path.name: path.read_text() for path in outside.iterdir()} == {
        "grid_0001.vtu": "dear",
        "lock": "dear",
    }
    study = folder / "study.yaml"
    study.write_text(STUDY.format("scene.yaml"))
    Path("out").mkdir()
    Path("out/members").symlink_to(outside)
    assert "members: is a link" in refused("study", study, "--output", "out")


def test_a_folder_in_the_place_of_a_file_is_told_before_the_run(folder: Path) -> None:
    (folder / "other" / "fields_0001.nc").mkdir(parents=True)
    assert "fields_0001.nc: is a folder" in refused("run", "scene.yaml", "--output", "other")


@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_pipes_and_devices_are_no_files(folder: Path, kind: str) -> None:
    def put(path: Path) -> Path:
        path.unlink(missing_ok=True)
        if kind == "pipe":
            os.mkfifo(path)
        else:
            path.symlink_to("/dev/zero")
        return path

    what = {"pipe": "it is a named pipe, not a file", "device": "it is a device, not a file"}[kind]
    odd = put(folder / "odd.yaml")
    for command in (["run", odd], ["check", odd], ["study", odd], ["resume", "finished", odd]):
        assert what in refused(*command)
    study = folder / "study.yaml"
    study.write_text(STUDY.format("odd.yaml"))
    assert what in refused("study", study)
    (folder / "mesh.yaml").write_text(
        "name: m\nmesh_file: {file: odd.msh}\nmaterial: {E: 1, nu: 0.3}\n"
        "loads: [{edge: a, traction: [0, 1]}]\n"
    )
    put(folder / "odd.msh")
    assert "mesh_file.file: no such file" in refused("check", "mesh.yaml")
    put(folder / "broken_off" / "checkpoint.npz")
    assert what in refused("resume", "broken_off")
    for name in ("history.nc", "fields_0002.nc", "fields_index.nc"):
        shutil.copytree("finished", f"with {name}")
        put(folder / f"with {name}" / name)
        assert what in refused("export", f"with {name}")


def test_a_large_file_is_refused(folder: Path) -> None:
    (folder / "large.yaml").write_text("# " + "x" * 2**22)
    assert "it has 4 MB, more than 2 MB" in refused("check", "large.yaml")
    (folder / "long.yaml").write_text("[" + "1," * 200_000 + "1]")
    assert "more than 100000 values" in refused("study", "long.yaml")


def test_a_run_without_stderr_or_stdout_is_kept(folder: Path) -> None:
    """No library may write messages into a file that reuses the descriptor of stderr."""
    for closed in ("2>&-", ">&- 2>&- <&-", "2>/dev/full"):
        command = f'exec "{sys.executable}" -m cfmpm run scene.yaml --output out -v {closed}'
        shutil.rmtree("out", ignore_errors=True)
        done = subprocess.run(["sh", "-c", command], timeout=300, check=False)
        assert done.returncode == 0, closed
        assert xr.load_dataset("out/history.nc").attrs["run_status"] == "increments"


def test_an_export_to_a_full_disk_leaves_nothing(folder: Path) -> None:
    """File size is limited to 20 kB, less than any file of the export."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))

    done = python("export", "finished", preexec_fn=limit)
    assert done.returncode == 1, done.stderr
    assert done.stderr == "cfmpm: cannot write finished/vtu/grid_0001.vtu: File too large\n"
    assert not Path("finished/vtu").exists()
    done = python("run", "scene.yaml", "--output", "finished", "-q", preexec_fn=limit)
    assert done.returncode == 1, done.stderr
    assert "cannot write finished/" in done.stderr
    assert "File too large" in done.stderr
    assert xr.load_dataset("finished/history.nc").attrs["run_status"] == "increments"


def test_netcdf_that_claims_more_than_the_file_holds(tmp_path: Path) -> None:
    path = tmp_path / "large.nc"
    with netCDF4.Dataset(path, "w") as file:
        file.createDimension("n", 10**9)
        file.createVariable("x", "f8", ("n",))
    with pytest.raises(DamagedError, match=r"says it holds 7.63e\+03 MB in"):
        read_netcdf(path)


def test_reading_that_does_not_end_is_ended(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = folder / "finished" / "history.nc"
    assert read_netcdf(path).attrs["run_status"] == "increments"
    with monkeypatch.context() as patched:
        patched.setattr(netcdf, "PATIENCE", 0.0)
        with pytest.raises(DamagedError, match="does not come to an end"):
            read_netcdf(path)
    with monkeypatch.context() as patched:
        patched.setattr(netcdf, "SECONDS", 1e-6)
        patched.setattr(netcdf, "PATIENCE", 1e6)
        with pytest.raises(DamagedError, match="breaks down"):
            read_netcdf(path)
    assert read_netcdf(path).attrs["run_status"] == "increments"


def test_crafted_checkpoints(folder: Path) -> None:
    """Each of these once caused a read beyond an array, or unlimited use of memory."""
    path = folder / "broken_off" / "checkpoint.npz"
    with np.load(path) as file:
        whole = dict(file)
    triangles = whole["mesh.triangles"].copy()
    triangles[0, 0] = 10**9
    crafted = [
        ({"mesh.triangles": triangles}, "mesh.triangles counts what is not there"),
        ({"points.element": whole["points.element"] - 10}, "points.element counts"),
        ({"points.volume": whole["points.volume"][1:]}, "points.volume has a wrong shape"),
        ({"mesh.edges.0": whole["mesh.edges.0"].ravel()}, "mesh.edges.0 has a wrong shape"),
        ({"mesh.nodes": whole["mesh.nodes"] * np.nan}, "mesh.nodes is not finite"),
        ({"mesh.nodes": whole["mesh.nodes"] * 0.0}, "without an area"),
        (
            {"steps.conjugates": whole["steps.conjugates"][:, :2]},
            "steps.conjugates has a wrong shape",
        ),
    ]
    for other, reason in crafted:
        np.savez(path, **{**whole, **other})
        with pytest.raises(SceneError, match=reason):
            read_checkpoint(path)
    texts = json.loads(str(whole["texts"]))
    for key in texts.keys() - {"format"}:
        np.savez(path, **{**whole, "texts": np.array(json.dumps(texts | {key: 1.5}))})
        with pytest.raises(SceneError, match="is damaged"):
            read_checkpoint(path)
    np.savez_compressed(path, **whole)
    with pytest.raises(SceneError, match="its arrays are compressed"):
        read_checkpoint(path)
