"""Runs that are interrupted or killed, and resumed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from subprocess import PIPE
from typing import Any

import pytest
import xarray as xr
from commands import call
from histories import same

from cfmpm.equilibrium import small_strain
from cfmpm.errors import SolveError
from cfmpm.output.checkpoint import read_checkpoint
from cfmpm.output.fields_by_step import list_fields
from cfmpm.output.run_folder import CHECKPOINT, HISTORY, UNFINISHED


class StopHereError(Exception):
    """Interrupts a run."""


SMALL = """\
name: small
family: {kind: single_edge, width: 10, height: 20, crack_length: 4, traction: 10}
material: {E: 210e3, nu: 0.3, g_c: 1.0}
mesh: {element: T3, size: 2}
growth: {control: crack, increments: 8}
output: {every: 2}
"""


@pytest.fixture
def scene_file(scene: Path) -> Path:
    """A scene file of a crack that grows, in a working directory of its own."""
    scene.write_text(SMALL)
    return scene


def files_in(folder: Path) -> dict[str, bytes]:
    """All files of a folder, by name."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def python(code: str, *arguments: str) -> subprocess.Popen[str]:
    """Start a new interpreter in the folder of the scene."""
    return subprocess.Popen([sys.executable, "-c", code, *arguments], stderr=PIPE, text=True)


def wait_until(condition: Callable[[], object], process: subprocess.Popen[str]) -> None:
    deadline = time.monotonic() + 120
    while not condition() and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.005)


def break_off_at(
    monkeypatch: pytest.MonkeyPatch, step: int, error: BaseException | signal.Signals
) -> None:
    """Let the solve of a step fail, or send a signal during it."""
    solve, calls = small_strain.solve_linear, []

    def failing(*arguments: Any, **keywords: Any) -> Any:
        calls.append(None)
        if len(calls) == step:
            if isinstance(error, signal.Signals):
                signal.raise_signal(error)
            else:
                raise error
        return solve(*arguments, **keywords)

    monkeypatch.setattr(small_strain, "solve_linear", failing)


@pytest.mark.parametrize(
    ("error", "status"),
    [(SolveError("no balance"), 1), (signal.SIGINT, 130), (signal.SIGTERM, 143)],
)
def test_a_run_that_breaks_off_keeps_what_it_found(
    scene_file: Path,
    monkeypatch: pytest.MonkeyPatch,
    error: BaseException | signal.Signals,
    status: int,
) -> None:
    whole = call("run", scene_file, "--output", "whole")
    assert whole.exit_code == 0, whole.output
    with monkeypatch.context() as patched:
        break_off_at(patched, 6, error)
        result = call("run", scene_file)
    assert result.exit_code == status
    assert "has 5 steps; cfmpm resume results/small continues" in result.stderr
    folder = Path("results/small")
    with xr.open_dataset(folder / HISTORY) as history:
        assert history.sizes["step"] == 5
        assert history.attrs["run_status"] == UNFINISHED
    if status == 1:
        assert "step 6: no balance" in result.stderr
    resumed = call("resume", folder, scene_file)
    assert resumed.exit_code == 0, resumed.output
    same(xr.load_dataset("whole/history.nc"), xr.load_dataset(folder / HISTORY))
    assert {path.name for path in folder.iterdir()} == {p.name for p in Path("whole").iterdir()}
    for name in ("fields_0003.nc", "fields_0009.nc", "fields_index.nc"):
        xr.testing.assert_equal(
            xr.load_dataset(Path("whole") / name), xr.load_dataset(folder / name)
        )


@pytest.mark.parametrize("asked", [signal.SIGINT, signal.SIGTERM])
def test_a_request_to_end_waits_for_the_file_that_is_being_written(
    scene_file: Path, monkeypatch: pytest.MonkeyPatch, asked: signal.Signals
) -> None:
    """Interrupting a write would leave netCDF's lock taken, and the final write would hang."""
    begun: list[bool] = []
    write = xr.Dataset.to_netcdf

    def interrupted(dataset: xr.Dataset, *arguments: Any, **keywords: Any) -> Any:
        if not begun:
            signal.raise_signal(asked)
        begun.append(True)
        return write(dataset, *arguments, **keywords)

    with monkeypatch.context() as patched:
        patched.setattr(xr.Dataset, "to_netcdf", interrupted)
        result = call("run", scene_file)
    assert result.exit_code == 128 + asked
    assert "cfmpm resume results/small continues" in result.stderr
    assert len(begun) > 1
    with xr.open_dataset(Path("results/small") / HISTORY) as history:
        assert "interrupted" in history.attrs["ending"]
    assert not list(Path("results/small").glob(".*.part"))


def test_a_run_that_ends_without_balance_is_no_success(
    scene_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With transfer: paper a grid may be singular: the run ends with a reason and status 1."""
    break_off_at(monkeypatch, 3, SolveError("no balance"))
    result = call("run", scene_file, "--set", "growth.transfer=paper")
    assert result.exit_code == 1
    assert "cfmpm: unsolvable: growth.transfer: paper left nodes without stiffness" in result.stderr
    assert "The steps before are in results/small/history.nc" in result.stderr
    with xr.open_dataset("results/small/history.nc") as history:
        assert history.attrs["run_status"] == "unsolvable"
    assert not Path("results/small", CHECKPOINT).exists()


def test_a_run_that_fails_at_once_leaves_nothing(
    scene_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    break_off_at(monkeypatch, 1, SolveError("no balance"))
    result = call("run", scene_file)
    assert result.exit_code == 1
    assert "resume" not in result.stderr
    assert list(Path("results/small").iterdir()) == []


def test_an_ended_run_of_another_scene_is_not_called_done(scene_file: Path) -> None:
    call("run", scene_file)
    for scene in ([scene_file], []):
        result = call("resume", "results/small", *scene, "--set", "material.g_c=2")
        assert result.exit_code == 2
        assert "differs from the scene of results/small in material" in result.stderr
    assert call("resume", "results/small", scene_file).exit_code == 0


def test_what_has_ended_is_left_alone(scene_file: Path) -> None:
    call("run", scene_file)
    before = files_in(Path("results/small"))
    result = call("resume", "results/small")
    assert result.exit_code == 0
    assert "is finished; increments: growth.increments allows 8" in result.stdout
    assert files_in(Path("results/small")) == before


def test_a_folder_that_cannot_be_written(scene_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is told as all input that cannot be used; of a finished run nothing is to be written."""
    with monkeypatch.context() as patched:
        break_off_at(patched, 3, KeyboardInterrupt())
        call("run", scene_file)
    with monkeypatch.context() as patched:
        patched.setattr(os, "access", lambda *_: False)
        result = call("resume", "results/small")
        assert result.exit_code == 2
        where = "results/small: cannot be written: no permission for results/small"
        assert result.stderr == f"{where}; copy it elsewhere, and resume the copy\n"
    assert call("resume", "results/small").exit_code == 0
    monkeypatch.setattr(os, "access", lambda *_: False)
    assert "is finished" in call("resume", "results/small").stdout


def test_a_changed_scene_is_refused(scene_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patched:
        break_off_at(patched, 3, KeyboardInterrupt())
        call("run", scene_file)
    before = Path("results/small/history.nc").read_bytes()
    result = call("resume", "results/small", scene_file, "--set", "material.E=70e3")
    assert result.exit_code == 2
    assert "differs from the scene of results/small in material" in result.stderr
    assert Path("results/small/history.nc").read_bytes() == before
    assert call("resume", "results/small", scene_file).exit_code == 0


def test_nothing_to_go_on_from(scene_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    result = call("resume", "results/small")
    assert result.exit_code == 2
    assert "no such result" in result.stderr
    with monkeypatch.context() as patched:
        break_off_at(patched, 3, KeyboardInterrupt())
        call("run", scene_file)
    Path("results/small", CHECKPOINT).unlink()
    result = call("resume", "results/small")
    assert result.exit_code == 2
    assert "run the scene again" in result.stderr


def test_a_new_run_does_not_go_on_from_an_old_one(
    scene_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patched:
        break_off_at(patched, 3, KeyboardInterrupt())
        call("run", scene_file)
        before = files_in(Path("results/small"))
        result = call("run", scene_file)
        assert result.exit_code == 2
        assert "results/small: has a run that was interrupted" in result.stderr
        assert "cfmpm resume results/small" in result.stderr
        assert "--overwrite" in result.stderr
        assert files_in(Path("results/small")) == before
        break_off_at(patched, 2, KeyboardInterrupt())
        call("run", scene_file, "--overwrite", "--set", "growth.increments=3")
    assert read_checkpoint(Path("results/small", CHECKPOINT)).record.steps == []
    assert call("resume", "results/small").exit_code == 0
    assert xr.load_dataset("results/small/history.nc").sizes["step"] == 4


def test_figures_of_an_interrupted_run_do_not_outlive_it(
    scene_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They show fewer steps than the history of the resumed run."""
    pytest.importorskip("pyvista")
    folder = Path("results/small")
    with monkeypatch.context() as patched:
        break_off_at(patched, 6, KeyboardInterrupt())
        call("run", scene_file)
    before = set(files_in(folder))
    for command in ("plot", "export"):
        assert call(command, folder).exit_code == 0
    (folder / "mine.png").touch()
    assert {"paths.png", "load.png", "mesh_crack_1.png", "growth.gif"} <= set(files_in(folder))
    assert call("resume", folder).exit_code == 0
    # The figure of the scene has no steps.
    kept = {name for name in files_in(folder) if not name.startswith("fields_")}
    assert kept == {HISTORY, "scene.png", "mine.png"}
    assert not (folder / "vtu").exists()
    assert {name for name in before if name.startswith("fields_")} <= set(files_in(folder))


def test_overwriting_takes_nothing_away_before_there_is_something_else(
    scene_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patched:
        break_off_at(patched, 3, KeyboardInterrupt())
        call("run", scene_file)
        before = files_in(Path("results/small"))
        break_off_at(patched, 1, SolveError("no balance"))
        result = call("run", scene_file, "--overwrite")
    assert result.exit_code == 1
    assert "no step was solved; results/small is unchanged" in result.stderr
    assert files_in(Path("results/small")) == before


def test_a_kill_while_a_resumed_run_starts_loses_no_fields(
    scene_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The table of field files lists all finished steps at any time."""
    with monkeypatch.context() as patched:
        break_off_at(patched, 6, KeyboardInterrupt())
        call("run", scene_file)
    folder = Path("results/small")
    listed = list_fields(folder)
    assert [path.name for path in listed] == [f"fields_000{k}.nc" for k in (1, 3, 5)]
    unlink = Path.unlink

    def killed(path: Path, missing_ok: bool = False) -> None:
        if path.name.startswith("fields"):
            raise StopHereError
        unlink(path, missing_ok)

    with monkeypatch.context() as patched:
        patched.setattr(Path, "unlink", killed)
        call("resume", folder)
    # The fifth step is solved again, since a state of balance has more to it than is kept.
    assert list_fields(folder) == listed[:2]
    assert call("resume", folder).exit_code == 0
    assert len(list_fields(folder)) == 5


# A run that stops for good in the solve of a step, and says so in a file.
STUCK = """
import pathlib, sys, time
from cfmpm.cli.app import app
from cfmpm.equilibrium import small_strain
solve, calls = small_strain.solve_linear, []
def stuck(*arguments, **keywords):
    calls.append(None)
    if len(calls) == int(sys.argv[1]):
        pathlib.Path("stuck").touch()
        time.sleep(120)
    return solve(*arguments, **keywords)
small_strain.solve_linear = stuck
app(sys.argv[2:])
"""


@contextmanager
def stuck_at(step: int, *arguments: str) -> Iterator[subprocess.Popen[str]]:
    """Start a process in which a command stops at a step and waits."""
    process = python(STUCK, str(step), *arguments)
    try:
        wait_until(Path("stuck").exists, process)
        assert process.poll() is None
        yield process
    finally:
        process.kill()
        process.communicate()
        Path("stuck").unlink(missing_ok=True)


@pytest.mark.slow
def test_kill_9_of_a_run_as_it_is_shipped(scene_file: Path) -> None:
    """At least the first step is on disk; the resumed run gives the same result."""
    assert call("run", scene_file, "--output", "whole").exit_code == 0
    with stuck_at(6, "run", str(scene_file)) as process:
        process.kill()
    assert process.returncode == -signal.SIGKILL
    folder = Path("results/small")
    history = xr.load_dataset(folder / HISTORY)
    assert 1 <= history.sizes["step"] <= 5
    assert history.attrs["run_status"] == UNFINISHED
    assert "was interrupted" in call("run", scene_file).stderr
    assert call("resume", folder).exit_code == 0
    same(xr.load_dataset("whole/history.nc"), xr.load_dataset(folder / HISTORY))
    assert {path.name for path in folder.iterdir()} == {p.name for p in Path("whole").iterdir()}


@pytest.mark.slow
def test_sigterm_in_a_fresh_process_loses_nothing(scene_file: Path) -> None:
    """gmsh starts after the signal handler is installed and must not replace it."""
    with stuck_at(6, "run", str(scene_file)) as process:
        process.terminate()
        said = process.communicate(timeout=60)[1]
    assert process.returncode == 143
    assert "has 5 steps; cfmpm resume results/small continues" in said
    assert xr.load_dataset("results/small/history.nc").sizes["step"] == 5
    assert call("resume", "results/small").exit_code == 0


@pytest.mark.slow
def test_sigterm_before_the_first_step_is_answered(scene_file: Path) -> None:
    with stuck_at(1, "run", str(scene_file)) as process:
        process.terminate()
        said = process.communicate(timeout=60)[1]
    assert process.returncode == 143
    assert said == "cfmpm: interrupted\n"
    assert list(Path("results/small").iterdir()) == []


@pytest.mark.slow
def test_a_run_killed_before_its_first_step_is_not_taken_for_the_one_before(
    scene_file: Path,
) -> None:
    assert call("run", scene_file).exit_code == 0
    before = xr.load_dataset("results/small/history.nc")
    with stuck_at(1, "run", str(scene_file), "--set", "material.g_c=2") as process:
        process.kill()
    result = call("resume", "results/small")
    assert result.exit_code == 2
    assert "killed before its first step" in result.stderr
    xr.testing.assert_identical(xr.load_dataset("results/small/history.nc"), before)
    assert call("run", scene_file).exit_code == 0
    assert call("resume", "results/small").exit_code == 0


@pytest.mark.slow
def test_two_live_runs_do_not_mix(scene_file: Path) -> None:
    with stuck_at(3, "run", str(scene_file)):
        before = files_in(Path("results/small"))
        for command in (("run", scene_file, "--overwrite"), ("resume", "results/small")):
            result = call(*command)
            assert result.exit_code == 2
            assert "results/small: another run is writing here" in result.stderr
        assert files_in(Path("results/small")) == before
    assert call("resume", "results/small").exit_code == 0


@pytest.mark.slow
def test_kill_9_in_the_middle(scene_file: Path, tmp_path: Path) -> None:
    """SIGKILL cannot be handled: the process cannot write anything at the end."""
    whole = call("run", scene_file, "--set", "growth.increments=20", "--output", "whole")
    assert whole.exit_code == 0, whole.output
    code = (
        "import time; from cfmpm.cli.app import app; from cfmpm.equilibrium import small_strain\n"
        "from cfmpm.output import run_writer; run_writer.SHARE = 1.0\n"
        "solve = small_strain.solve_linear\n"
        "def slow(*arguments):\n    time.sleep(0.05)\n    return solve(*arguments)\n"
        "small_strain.solve_linear = slow\n"
        "app(['run', 'small.yaml', '--set', 'growth.increments=20'])"
    )
    folder = tmp_path / "results" / "small"
    process = subprocess.Popen([sys.executable, "-c", code], cwd=tmp_path)
    try:
        deadline = time.monotonic() + 120
        while not (folder / "fields_0007.nc").exists() and time.monotonic() < deadline:
            time.sleep(0.01)
    finally:
        process.kill()
        process.wait()
    assert process.returncode == -signal.SIGKILL
    done = xr.load_dataset(folder / HISTORY).sizes["step"]
    assert 5 <= done < 21
    assert call("resume", folder).exit_code == 0
    same(xr.load_dataset("whole/history.nc"), xr.load_dataset(folder / HISTORY))
