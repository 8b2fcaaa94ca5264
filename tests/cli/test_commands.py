"""The command line: files, messages and errors."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from commands import SCENE, call, expect_failure, output_of, stderr_of

from cfmpm import __version__, build, state
from cfmpm.errors import MeshError, Problem, SceneError, SolveError
from cfmpm.scene import Scene
from cfmpm.scene.schema import schema
from cfmpm.study.model import Study


def forbid(monkeypatch: pytest.MonkeyPatch, path: str) -> None:
    """Let the system refuse a file, as it does without permission; root has it for all."""

    def refusing(function: Callable[..., Any]) -> Callable[..., Any]:
        def call(place: Any, *arguments: Any, **keywords: Any) -> Any:
            if str(place) == path:
                raise PermissionError(errno.EACCES, "Permission denied", path)
            return function(place, *arguments, **keywords)

        return call

    name = "open" if Path(path).exists() else "stat"
    monkeypatch.setattr(os, name, refusing(getattr(os, name)))


class TestRun:
    def test_writes_the_history_and_says_so(self, scene: Path) -> None:
        result = call("run", scene)
        assert result.exit_code == 0, result.output
        folder = Path("results/small")
        assert [p.name for p in folder.iterdir()] == ["history.nc"]
        with xr.open_dataset(folder / "history.nc") as history:
            said = f"{float(history['G'][-1, 0]):#.6g}"
            assert f"{float(history['critical_load_factor'][-1, 0]):#.6g}" in result.stdout
        assert said in result.stdout
        for word in (
            "K_II [MPa mm^0.5]",
            "load factor at fracture",
            "left out",
            "history.nc",
            "(4, 10)",
        ):
            assert word in result.stdout
        assert result.stderr == ""

    def test_lines_fit_and_long_names_do_not_widen_them(self, scene: Path) -> None:
        crack = "a_crack_with_a_name_of_many_words_in_it_for_the_sake_of_this_test"[:64]
        scene.write_text(
            "name: two\n"
            "geometry:\n"
            "  outline: [[0, 0], [10, 0], [10, 20], [0, 20]]\n"
            f"  cracks: [{{name: {crack}, points: [[3, 10], [7, 10]]}}]\n"
            "material: {E: 210e3, nu: 0.3}\n"
            "loads: [{name: pull, box: [[-1, 19], [11, 21]], traction: [0, 5]},\n"
            "        {name: hold, box: [[-1, -1], [11, 1]], displacement: {x: 0, y: 0}}]\n"
            "mesh: {size: 2}\n"
            "fracture: {radii: 3}\n"
        )
        for command in ("run", "check"):
            result = call(command, scene)
            assert result.exit_code == 0, result.output
            assert max(map(len, result.stdout.splitlines())) <= 100

    def test_j_stands_against_g(self, scene: Path) -> None:
        (line,) = (x for x in call("run", scene).stdout.splitlines() if x.startswith("J / G"))
        with xr.open_dataset("results/small/history.nc") as history:
            assert float(line.split()[-1]) == pytest.approx(
                float(history["J"][0, 0] / history["G"][0, 0]) - 1, rel=0.05
            )

    def test_fields_only_when_asked_for(self, scene: Path) -> None:
        result = call("run", scene, "--set", "output.fields=true", "--output", "here")
        assert result.exit_code == 0, result.output
        assert {p.name for p in Path("here").iterdir()} == {"history.nc", "fields.nc"}

    def test_overrides_are_yaml(self, scene: Path) -> None:
        result = call(
            "run", scene, "--set", "fracture.radii=[1, 2.5]", "--set", "family.traction=20"
        )
        assert result.exit_code == 0, result.output
        with xr.open_dataset("results/small/history.nc") as history:
            assert history["radius"].values.tolist() == [1.0, 2.5]
            assert json.loads(history.attrs["config"])["family"]["traction"] == 20

    def test_quiet_says_nothing(self, scene: Path) -> None:
        result = call("run", scene, "--quiet")
        assert (result.exit_code, result.output) == (0, "")

    def test_verbose_logs_the_phases_in_order(self, scene: Path) -> None:
        result = call("run", scene, "--verbose")
        phases = [line.split()[1] for line in result.stderr.splitlines() if "phase:" in line]
        assert list(dict.fromkeys(phases)) == list(state.PHASES)

    def test_a_scene_without_cracks(self, scene: Path) -> None:
        scene.write_text(
            "name: whole\n"
            "geometry: {outline: [[0, 0], [10, 0], [10, 20], [0, 20]]}\n"
            "material: {E: 210e3, nu: 0.3}\n"
            "loads: [{name: hold, box: [[-1, -1], [11, 1]], displacement: {x: 0, y: 0}},\n"
            "        {name: weight, body_force: [0, -1e-3]}]\n"
            "mesh: {size: 4}\n"
        )
        result = call("run", scene)
        assert result.exit_code == 0, result.output
        assert "no crack tip" in result.stdout
        result = call("plot", "results/whole")
        assert result.exit_code == 0, result.output
        assert not list(Path("results/whole").glob("cf_*"))

    def test_nothing_of_two_runs_stands_side_by_side(self, scene: Path) -> None:
        """Files written by an earlier run, plot and export are removed by the next run."""
        pytest.importorskip("pyvista")
        folder = Path("results/small")
        folder.mkdir(parents=True)
        mine = {"notes.txt", "cf_mine.png", "fields_mine.nc", ".history.nc.mine", "vtu"}
        for name in mine - {"vtu"}:
            (folder / name).touch()
        growing = ["growth={control: crack, increments: 2}", "output={every: 1, fields: true}"]
        call("run", scene, *(part for text in growing for part in ("--set", text)))
        for command in ("plot", "export"):
            assert call(command, folder).exit_code == 0
        (folder / "vtu" / "mine.vtu").touch()
        (folder / ".history.nc.0123abcd.part").touch()  # of a run that was killed
        assert len(list(folder.iterdir())) > 20
        assert call("run", scene).exit_code == 0
        assert {path.name for path in folder.iterdir()} == {*mine, "history.nc"}
        assert [path.name for path in (folder / "vtu").iterdir()] == ["mine.vtu"]


class TestFailures:
    def test_every_problem_of_a_scene_on_its_line(self, scene: Path) -> None:
        scene.write_text(SCENE.replace("nu: 0.3", "nu: 0.7").replace("size:", "sice:"))
        result = call("run", scene)
        expect_failure(result, 2, "small.yaml:3", "small.yaml:4", "did you mean size?")
        assert len(result.stderr.splitlines()) == 2
        assert not Path("results").exists()

    def test_overrides_that_are_none(self, scene: Path) -> None:
        result = call("run", scene, "--set", "mesh.size", "--set", "=3", "--set", "mesh.size=2")
        expect_failure(result, 2, "mesh.size: not of the form", "=3: not of the form")
        assert len(result.stderr.splitlines()) == 2

    def test_overrides_given_twice(self, scene: Path) -> None:
        result = call("run", scene, "--set", "material.E=1", "--set", "material.E=2")
        expect_failure(result, 2, "override material.E: given twice")

    @pytest.mark.parametrize("command", ["run", "check"])
    def test_no_such_scene(self, scene: Path, command: str) -> None:
        expect_failure(call(command, "nowhere.yaml"), 2, "nowhere.yaml: no such file")

    @pytest.mark.parametrize(
        ("error", "status", "words"),
        [
            (MeshError("no grid"), 1, "cfmpm: no grid"),
            (SolveError("no balance"), 1, "cfmpm: no balance"),
            (MemoryError(), 1, "not enough memory"),
            (KeyboardInterrupt(), 130, "interrupted"),
        ],
    )
    @pytest.mark.parametrize("command", ["run", "check"])
    def test_status_by_kind(
        self,
        scene: Path,
        monkeypatch: pytest.MonkeyPatch,
        error: BaseException,
        status: int,
        words: str,
        command: str,
    ) -> None:
        def fail(*_: object) -> None:
            raise error

        monkeypatch.setattr(build, "triangulate", fail)
        expect_failure(call(command, scene), status, words)

    def test_loads_that_make_no_sense_on_the_grid(self, scene: Path) -> None:
        loads = "loads: [{edge: top, traction: [0, 1]}]\n"
        scene.write_text(SCENE.replace(", traction: 10}", "}") + loads)
        expect_failure(call("run", scene), 2, "out of balance")

    @pytest.mark.parametrize("command", ["run", "check"])
    def test_output_that_is_no_folder(
        self, scene: Path, command: str, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """It is refused before anything is solved."""
        reason = f"--output {scene}: is not a folder\n"
        assert stderr_of(call(command, scene, "--output", scene), 2) == reason
        inner, long = scene / "inner", "a" * 300
        reason = f"--output {inner}: cannot be made: {scene} is not a folder\n"
        assert stderr_of(call(command, scene, "--output", inner), 2) == reason
        reason = f"--output {long}: cannot be made: File name too long\n"
        assert stderr_of(call(command, scene, "--output", long), 2) == reason
        monkeypatch.setattr(os, "access", lambda *_: False)
        reason = "--output new: cannot be written: no permission for .\n"
        assert stderr_of(call(command, scene, "--output", "new"), 2) == reason
        reason = "results/small: cannot be written: no permission for .; give another folder by"
        expect_failure(call(command, scene), 2, reason)
        assert [path.name for path in Path().iterdir()] == [scene.name]

    @pytest.mark.parametrize("command", ["run", "check", "resume", "plot", "export", "study"])
    def test_input_that_cannot_be_read(
        self, scene: Path, command: str, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """By none but cfmpm itself, in one line."""
        monkeypatch.setattr(os, "access", lambda *_: False)  # which click asks
        forbid(monkeypatch, str(scene))
        forbid(monkeypatch, str(Path("results/small/history.nc")))
        source = "results/small" if command in ("resume", "plot", "export") else scene
        Path("results/small").mkdir(parents=True)
        said = stderr_of(call(command, source), 2)
        assert said == f"{source}: cannot be read: Permission denied\n"

    def test_a_mesh_file_that_cannot_be_read(
        self, scene: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        mesh = scene.with_name("a.msh")
        mesh.touch()
        scene.write_text(
            "name: m\nmaterial: {E: 1, nu: 0}\nmesh_file: {file: a.msh}\n"
            "loads: [{body_force: [0, 1]}]\n"
        )
        forbid(monkeypatch, str(mesh))
        said = stderr_of(call("run", scene), 2)
        place = f"{scene}:3:13: mesh_file.file"
        assert said == f"{place}: cannot be read: {mesh}: Permission denied\n"

    def test_the_reason_comes_before_what_is_left(
        self, scene: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def fail(*_: object) -> None:
            raise SceneError([Problem("no balance", "material.nu")])

        def said() -> list[str]:
            with monkeypatch.context() as patched:
                patched.setattr(build, "triangulate", fail)
                return stderr_of(call("run", scene), 2).splitlines()

        place = f"{scene}:3:22: material.nu: no balance"
        assert said() == [place]
        assert call("run", scene).exit_code == 0
        assert said() == [place, "no step was solved; results/small is unchanged"]

    def test_a_figure_that_cannot_be_written_is_named(
        self, scene: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def forbidden(folder: str, *_: object) -> None:
            raise PermissionError(errno.EACCES, "Permission denied", folder)

        monkeypatch.setattr(os, "mkdir", forbidden)
        result = call("check", scene, "--output", ".")
        assert stderr_of(result, 1) == "cfmpm: cannot write scene.png: Permission denied\n"

    def test_a_full_disk_leaves_nothing_behind(
        self, scene: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def fill(_: xr.Dataset, path: Path, **__: object) -> None:
            Path(path).write_text("half")
            raise OSError(errno.ENOSPC, "No space left on device")

        monkeypatch.setattr(xr.Dataset, "to_netcdf", fill)
        said = "cannot write results/small/history.nc: No space left on device"
        expect_failure(call("run", scene), 1, said)
        assert list(Path("results/small").iterdir()) == []

    def test_a_failed_run_keeps_the_result_of_the_last(
        self, scene: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        assert call("run", scene).exit_code == 0
        before = Path("results/small/history.nc").read_bytes()

        def fail(*_: object, **__: object) -> None:
            raise OSError(errno.EIO, "Input/output error")

        monkeypatch.setattr(xr.Dataset, "to_netcdf", fail)
        expect_failure(call("run", scene), 1, "history.nc: Input/output error")
        assert Path("results/small/history.nc").read_bytes() == before


def test_schema_is_the_schema() -> None:
    for kind, model in {(): Scene, ("scene",): Scene, ("study",): Study}.items():
        result = call("schema", *kind)
        assert result.exit_code == 0
        assert json.loads(result.stdout) == schema(model)


def test_version() -> None:
    assert call("--version").stdout == f"cfmpm {__version__}\n"


@pytest.mark.parametrize("command", ["run", "check", "plot", "schema"])
def test_help_has_an_example(command: str) -> None:
    result = call(command, "--help")
    assert result.exit_code == 0
    assert f"Example: cfmpm {command}" in result.stdout
    assert command in call("--help").stdout


def test_a_run_does_not_load_matplotlib(scene: Path) -> None:
    code = (
        "import sys; from cfmpm.cli import app\n"
        "app(['run', sys.argv[1], '--set', 'output.fields=true'], standalone_mode=False)\n"
        "print('matplotlib' in sys.modules)"
    )
    assert output_of(code, str(scene)).splitlines()[-1] == "False"


def test_the_command_line_itself_loads_nothing_heavy() -> None:
    heavy = ["numpy", "numba", "gmsh", "xarray", "matplotlib", "pydantic", "scipy", "tqdm"]
    code = f"import sys, cfmpm, cfmpm.cli; print([m for m in {heavy} if m in sys.modules])"
    assert output_of(code) == "[]\n"


def test_python_m_cfmpm_gives_the_status_of_the_command(scene: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "cfmpm", "run", "nowhere.yaml"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr == "nowhere.yaml: no such file\n"
