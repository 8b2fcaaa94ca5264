"""The folder of a run: exclusive writing, and the files that stay."""

from __future__ import annotations

from pathlib import Path

import pytest
import xarray as xr
from growing_scene import growing
from typer.testing import CliRunner

from cfmpm.api import Result, run
from cfmpm.cli.app import app
from cfmpm.errors import SceneError
from cfmpm.output.run_folder import CHECKPOINT, held, is_unfinished
from cfmpm.output.run_writer import RunWriter
from cfmpm.scene import scene_from_dict


@pytest.fixture(scope="module")
def result() -> Result:
    return run(scene_from_dict(growing() | {"output": {"fields": True}}))


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


@pytest.mark.slow
def test_a_result_is_written_as_by_the_command(result: Result, tmp_path: Path) -> None:
    written = result.write(tmp_path / "python")
    (tmp_path / "scene.yaml").write_text(str(growing() | {"output": {"fields": True}}))
    done = CliRunner().invoke(
        app, ["run", str(tmp_path / "scene.yaml"), "--output", str(tmp_path / "command")]
    )
    assert done.exit_code == 0, done.output
    assert written == [tmp_path / "python" / name for name in ("history.nc", "fields.nc")]
    assert names(tmp_path / "python") == names(tmp_path / "command") == {p.name for p in written}
    for name in ("history.nc", "fields.nc"):
        one, other = (xr.load_dataset(tmp_path / by / name) for by in ("python", "command"))
        if name == "history.nc":
            one, other = one.drop_vars("wall_time"), other.drop_vars("wall_time")
        xr.testing.assert_equal(one, other)
        assert one.attrs["config_hash"] == other.attrs["config_hash"]


@pytest.mark.slow
def test_a_result_does_not_take_the_place_of_a_run_that_could_go_on(
    result: Result, tmp_path: Path
) -> None:
    writer = RunWriter(tmp_path)
    run(scene_from_dict(growing()), observe=writer.observe)
    assert is_unfinished(tmp_path)
    before = names(tmp_path)
    with pytest.raises(SceneError, match=r"overwrite=True"):
        result.write(tmp_path)
    assert names(tmp_path) == before
    result.write(str(tmp_path), overwrite=True)
    assert not is_unfinished(tmp_path)
    assert CHECKPOINT not in names(tmp_path)
    result.write(tmp_path)  # a whole one is replaced


def test_a_held_folder_is_let_go(tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b"
    with held(folder):
        with pytest.raises(SceneError, match="another run is writing here"), held(folder):
            pass
        assert names(folder) != set()
    assert names(folder) == set()
    with pytest.raises(ZeroDivisionError), held(folder):
        raise ZeroDivisionError
    with held(folder):
        pass
    assert names(folder) == set()


@pytest.mark.slow
def test_the_picture_of_the_scene_stays_where_it_is_still_true(tmp_path: Path) -> None:
    """The picture drawn by `check` is kept for the same scene only."""
    scene, folder = tmp_path / "scene.yaml", tmp_path / "result"
    scene.write_text(str(growing()))
    picture = folder / "scene.png"

    def call(*words: str) -> None:
        done = CliRunner().invoke(app, [*words, str(scene), "--output", str(folder)])
        assert done.exit_code == 0, done.output

    call("check")
    drawn = picture.read_bytes()
    call("run")
    assert picture.read_bytes() == drawn
    call("run")
    assert picture.read_bytes() == drawn
    call("run", "--set", "growth.increments=1")
    assert not picture.exists()
    picture.write_bytes(b"no picture")
    call("run")
    assert not picture.exists()
