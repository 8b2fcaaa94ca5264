"""The command `cfmpm study`: files, messages and errors."""

from __future__ import annotations

import errno
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr
from study_texts import FAILING, STUDY, without_times, write_study
from typer.testing import CliRunner, Result

from cfmpm.cli.app import app
from cfmpm.output.run_folder import held
from cfmpm.study.member import Outcome
from cfmpm.study.reading import load_study
from cfmpm.study.store import write_part


def call(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["study", *map(str, arguments)])


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_writes_one_dataset_and_says_so(folder: Path) -> None:
    path = write_study(folder)
    result = call(path, "--workers", 1)
    assert result.exit_code == 0, result.output
    assert result.stderr == ""
    assert result.stdout.splitlines() == [
        "lengths: 4 members, 2 length x 2 E; 4 done",
        "written  results/lengths/study.nc",
    ]
    assert sorted(p.name for p in Path("results/lengths").iterdir()) == ["members", "study.nc"]
    first = without_times("results/lengths/study.nc")
    result = call(path, "--output", "results/lengths", "--quiet")
    assert (result.exit_code, result.output) == (0, "")
    assert without_times("results/lengths/study.nc").identical(first)
    # A reader needs nothing of this package.
    code = (
        "import sys, xarray\n"
        "ds = xarray.open_dataset('results/lengths/study.nc')\n"
        "assert ds.G.sel(length=4, E=1e5).item() > 0\n"
        "assert 'cfmpm' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_study_and_a_scene_are_told_apart(folder: Path) -> None:
    write_study(folder)
    for wrong, words in (
        (("run", "study.yaml"), "study.yaml:1:1: this is a study: cfmpm study runs it"),
        (("study", "small.yaml"), "small.yaml:1:1: this is a scene: cfmpm run runs it"),
    ):
        result = CliRunner().invoke(app, wrong)
        assert result.exit_code == 2
        assert result.stderr.strip() == words


@pytest.mark.parametrize("name", ["", "study.nc"])
def test_a_study_is_not_drawn_as_a_run(name: str, folder: Path) -> None:
    call(write_study(folder), "--workers", 1)
    result = CliRunner().invoke(app, ["plot", str(Path("results/lengths", name))])
    assert result.exit_code == 2
    assert "this is a study, not a run: open it by ds = xarray.open_dataset(" in result.stderr
    assert "lengths/study.nc" in result.stderr


def test_check_lists_the_members_and_runs_none(folder: Path) -> None:
    result = call(write_study(folder), "--check")
    assert result.exit_code == 0
    assert result.stdout.splitlines() == [
        "lengths: 4 members, 2 length x 2 E",
        "  length=2, E=100000",
        "  length=2, E=200000",
        "  length=4, E=100000",
        "  length=4, E=200000",
    ]
    assert not Path("results").exists()


def test_a_bad_member_stops_all(folder: Path) -> None:
    result = call(write_study(folder, STUDY.replace("[2, 4]", "[2, 40]")))
    assert result.exit_code == 2
    assert "Traceback" not in result.output
    assert "study.yaml:4:3: in 2 members, such as length=40, E=100000: family" in result.stderr
    assert not Path("results").exists()


def test_failed_members_are_told(folder: Path) -> None:
    result = call(write_study(folder, FAILING), "--workers", 1)
    assert result.exit_code == 0
    assert "failing: 4 members, 2 pull x 2 element; 2 done, 2 failed" in result.stdout
    assert "  pull=6, element=T3: loads: the supports leave the body free" in result.stdout
    with xr.open_dataset("results/failing/study.nc") as dataset:
        assert dataset["status"].values.tolist() == [[0, 0], [1, 1]]


def test_nothing_but_failures_is_a_failure(folder: Path) -> None:
    text = FAILING.replace("[5, 6]", "{}").replace("values: {}", "linspace: [6, 7, 4]")
    result = call(write_study(folder, text), "--workers", 1)
    assert result.exit_code == 1
    assert "8 failed" in result.stdout
    assert "and 3 more: see reason in the dataset" in result.stdout
    assert "no member of failing was completed" in result.stderr
    assert Path("results/failing/study.nc").exists()


def test_members_that_became_unstable_are_counted(folder: Path, monkeypatch) -> None:
    path = write_study(folder)
    plan = load_study(path)
    lost = "unstable: no stable state"
    outcomes = {one.key: Outcome(one.key, "unstable", lost) for one in plan.members[:3]}
    write_part(outcomes.values(), folder / "results/lengths/members/part.0.npz")
    result = call(path, "--workers", 1)
    assert result.exit_code == 0
    assert "2 length x 2 E; 1 done, 3 unstable, 3 of them known from before" in result.stdout
    assert f"  length=2, E=100000: {lost}" in result.stdout
    with xr.open_dataset("results/lengths/study.nc") as dataset:
        assert dataset["status"].values.tolist() == [[3, 3], [3, 0]]


def test_one_study_at_a_time_in_a_folder(folder: Path) -> None:
    path = write_study(folder)
    with held(folder / "results/lengths"):
        result = call(path, "--workers", 1)
    assert result.exit_code == 2
    assert "another run is writing here" in result.stderr
    assert call(path, "--workers", 1).exit_code == 0


def test_what_a_kill_left_is_taken_away(folder: Path) -> None:
    path = write_study(folder)
    leavings = [
        folder / "results/lengths" / name
        for name in (".study.nc.01234567.part", "members/.part.ab.npz.01234567.part")
    ]
    for leaving in leavings:
        leaving.parent.mkdir(parents=True, exist_ok=True)
        leaving.write_text("half")
    assert call(path, "--workers", 1).exit_code == 0
    assert not any(leaving.exists() for leaving in leavings)


def test_how_far_it_has_come_is_told_without_a_terminal(folder: Path, monkeypatch) -> None:
    monkeypatch.setattr("cfmpm.cli.studying.LOGGED_EVERY", 0.0)
    path = write_study(folder)
    result = call(path, "--workers", 1)
    assert result.stderr.splitlines() == [f"{i} of 4 members" for i in (1, 2, 3, 4)]
    assert call(path, "--output", "other", "--quiet").stderr == ""


@pytest.mark.parametrize("number", ["0", "-1", "two"])
def test_bad_number_of_workers(number: str, folder: Path) -> None:
    assert call(write_study(folder), "--workers", number).exit_code == 2


def test_a_folder_that_cannot_be_written(folder: Path) -> None:
    (folder / "file").write_text("")
    result = call(write_study(folder), "--output", folder / "file", "--workers", 1)
    assert result.exit_code == 2
    assert result.stderr == f"--output {folder / 'file'}: is not a folder\n"


def test_a_full_disk_leaves_no_half_file(folder: Path, monkeypatch) -> None:
    path = write_study(folder)

    def full(*arguments, **keywords):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("xarray.Dataset.to_netcdf", full)
    result = call(path, "--workers", 1)
    assert result.exit_code == 1
    assert "No space left on device" in result.stderr
    assert [p.name for p in Path("results/lengths").iterdir()] == ["members"]
    monkeypatch.undo()
    monkeypatch.chdir(folder)
    assert "4 done, 4 of them known from before" in call(path, "--workers", 1).stdout
