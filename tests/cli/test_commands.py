"""The command line: what it writes, what it says, how it fails."""

from __future__ import annotations

import errno
import io
import json
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr
from typer.testing import CliRunner, Result

from cfmpm import __version__, build, simulation, state
from cfmpm.cli import running
from cfmpm.cli.app import app
from cfmpm.equilibrium import small_strain
from cfmpm.errors import MeshError, SolveError
from cfmpm.scene import Scene, load_scene
from cfmpm.scene.schema import schema
from cfmpm.study.model import Study

SCENE = """\
name: small
family: {kind: single_edge, width: 10, height: 20, crack_length: 4, traction: 10}
material: {E: 210e3, nu: 0.3, g_c: 1.0}
mesh: {element: T3, size: 2, grading: uniform}
fracture: {radii: 3}
"""


def call(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A small scene file, in a working directory of its own."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "small.yaml"
    path.write_text(SCENE)
    return path


def expect_failure(result: Result, status: int, *words: str) -> None:
    assert result.exit_code == status, result.output
    assert result.exception is None or isinstance(result.exception, SystemExit)
    assert "Traceback" not in result.output
    for word in words:
        assert word in result.stderr


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
        """Whatever a run, plot and export can write is gone when the next run has ended."""
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
    def test_output_that_is_a_file(self, scene: Path, command: str) -> None:
        expect_failure(call(command, scene, "--output", scene), 1, "cannot write", str(scene))

    def test_a_full_disk_leaves_nothing_behind(
        self, scene: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def fill(_: xr.Dataset, path: Path, **__: object) -> None:
            Path(path).write_bytes(b"half")
            raise OSError(errno.ENOSPC, "No space left on device", str(path))

        monkeypatch.setattr(xr.Dataset, "to_netcdf", fill)
        expect_failure(call("run", scene), 1, "No space left on device")
        assert list(Path("results/small").iterdir()) == []

    def test_a_failed_run_keeps_the_result_of_the_last(
        self, scene: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        assert call("run", scene).exit_code == 0
        before = Path("results/small/history.nc").read_bytes()

        def fail(*_: object, **__: object) -> None:
            raise OSError(errno.EIO, "Input/output error")

        monkeypatch.setattr(xr.Dataset, "to_netcdf", fail)
        expect_failure(call("run", scene), 1, "cannot write: Input/output error")
        assert Path("results/small/history.nc").read_bytes() == before


class TestCheck:
    def test_counts_and_draws_and_does_not_solve(
        self, scene: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def solve(*_: object) -> None:
            raise AssertionError("check must not solve")

        monkeypatch.setattr(small_strain, "solve_linear", solve)
        result = call("check", scene, "--set", "solver=superlu")
        assert result.exit_code == 0, result.output
        for word in (
            "triangles T3",
            "unknowns",
            "superlu",
            "crack_1 at (4, 10)",
            "clearance",
            "left out",
        ):
            assert word in result.stdout
        assert Path("results/small/scene.png").read_bytes().startswith(b"\x89PNG")

    def test_says_what_looks_like_another_unit(self, scene: Path) -> None:
        assert "outside the usual range" not in call("check", scene).stdout
        for command in ("check", "run"):
            result = call(command, scene, "--set", "material={E: 210e9, nu: 0.3, g_c: 2500}")
            said = " ".join(result.stdout.split())
            usual = "is outside the usual range of 0.001"
            assert f"material.E: 2.1e+11 MPa {usual} to 2e+06 MPa" in said
            assert f"material.g_c: 2500 N/mm {usual} to 1000 N/mm" in said

    def test_says_that_nothing_loads_the_body(self, scene: Path) -> None:
        for command in ("check", "run"):
            assert "has no load" not in call(command, scene).stdout
            result = call(command, scene, "--set", "family.traction=0")
            assert result.exit_code == 0, result.output
            assert "the body has no load" in result.stdout

    def test_says_which_crack_has_two_tips(self, scene: Path) -> None:
        assert "two tips" not in call("check", scene).stdout
        scene.write_text(
            "name: two\n"
            "geometry: {outline: [[0, 0], [10, 0], [10, 20], [0, 20]],\n"
            "  cracks: [{points: [[1, 10], [5, 10]]}]}\n"
            "material: {E: 210e3, nu: 0.3}\n"
            "loads: [{edge: edge_1, traction: [0, -1]}, {edge: edge_3, traction: [0, 1]}]\n"
            "mesh: {size: 2}\n"
        )
        said = call("check", scene).stdout
        assert "crack_1 has two tips: neither end is on an edge or a hole" in said

    @pytest.mark.parametrize("command", ["run", "check"])
    def test_says_how_many_triangles_are_coming(
        self, scene: Path, monkeypatch: pytest.MonkeyPatch, command: str
    ) -> None:
        def give_up(*_: object) -> None:
            raise MeshError("no time")

        monkeypatch.setattr(build, "triangulate", give_up)
        result = call(command, scene, "--set", "mesh.size=0.02")
        assert "meshing about 1.2e+06 triangles" in result.stderr
        assert "triangles" not in call(command, scene).stderr

    def test_unknowns_are_those_of_the_run(self, scene: Path) -> None:
        checked = call("check", scene).stdout
        call("run", scene)
        with xr.open_dataset("results/small/history.nc") as history:
            assert f"unknowns  {int(history['n_unknowns'][-1])}\n" in checked


class TestPlot:
    PICTURES = frozenset(
        {f"{name}.png" for name in ("scene", "deformed")}
        | {f"{name}_crack_1.png" for name in ("mesh", "radii", "cf")}
    )

    @pytest.mark.parametrize("form", ["results/small", "results/small/history.nc"])
    def test_solves_again_where_there_are_no_fields(self, scene: Path, form: str) -> None:
        call("run", scene)
        result = call("plot", form)
        assert result.exit_code == 0, result.output
        assert "solving small again" in result.stderr
        assert {p.name for p in Path("results/small").glob("*.png")} == self.PICTURES
        assert {Path(line).name for line in result.stdout.splitlines()} == self.PICTURES

    def test_uses_the_fields_that_are_there(
        self, scene: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        call("run", scene, "--set", "output.fields=true")

        def solve(*_: object) -> None:
            raise AssertionError("plot must not solve")

        monkeypatch.setattr(small_strain, "solve_linear", solve)
        result = call("plot", "results/small", "--output", "pictures")
        assert (result.exit_code, result.stderr) == (0, "")
        assert {p.name for p in Path("pictures").iterdir()} == self.PICTURES

    def test_fields_of_another_run_are_not_used(self, scene: Path) -> None:
        call("run", scene, "--set", "output.fields=true", "--output", "other")
        call("run", scene)
        Path("other/fields.nc").rename("results/small/fields.nc")
        result = call("plot", "results/small")
        assert result.exit_code == 0, result.output
        assert "belongs to another run" in result.stderr

    def test_no_such_result(self, scene: Path) -> None:
        expect_failure(call("plot", "results/none"), 2, "results/none: no such result")
        Path("empty").mkdir()
        expect_failure(call("plot", "empty"), 2, "history.nc: no such result")

    @pytest.mark.parametrize("content", [b"", b"not netCDF", b"\x89HDF\r\n\x1a\n" + bytes(64)])
    def test_a_damaged_result(self, scene: Path, content: bytes) -> None:
        Path("history.nc").write_bytes(content)
        expect_failure(call("plot", "history.nc"), 2, "history.nc: cannot be read as netCDF")

    def test_a_result_cut_short(self, scene: Path) -> None:
        call("run", scene)
        whole = Path("results/small/history.nc").read_bytes()
        Path("results/small/history.nc").write_bytes(whole[: len(whole) // 2])
        expect_failure(call("plot", "results/small"), 2, "cannot be read as netCDF")

    def test_what_cfmpm_did_not_write(self, scene: Path) -> None:
        xr.Dataset({"T": ("x", [1.0])}).to_netcdf("other.nc")
        expect_failure(call("plot", "other.nc"), 2, "is not what cfmpm run writes")

    def test_fields_in_place_of_the_history(self, scene: Path) -> None:
        call("run", scene, "--set", "output.fields=true")
        result = call("plot", "results/small/fields.nc")
        expect_failure(result, 2, "give the folder of a run, or its history.nc")

    @pytest.mark.parametrize(
        ("config", "word"), [("{", "config is damaged"), ('{"name": "x"}', "material")]
    )
    def test_a_damaged_configuration(self, scene: Path, config: str, word: str) -> None:
        call("run", scene)
        history = xr.load_dataset("results/small/history.nc")
        history.assign_attrs(config=config).to_netcdf("history.nc")
        expect_failure(call("plot", "history.nc"), 2, word)


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


def python(code: str, *arguments: str) -> str:
    """Run code in an interpreter of its own; its output."""
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_a_run_does_not_load_matplotlib(scene: Path) -> None:
    code = (
        "import sys; from cfmpm.cli import app\n"
        "app(['run', sys.argv[1], '--set', 'output.fields=true'], standalone_mode=False)\n"
        "print('matplotlib' in sys.modules)"
    )
    assert python(code, str(scene)).splitlines()[-1] == "False"


def test_the_command_line_itself_loads_nothing_heavy() -> None:
    heavy = ["numpy", "numba", "gmsh", "xarray", "matplotlib", "pydantic", "scipy", "tqdm"]
    code = f"import sys, cfmpm, cfmpm.cli; print([m for m in {heavy} if m in sys.modules])"
    assert python(code) == "[]\n"


def test_python_m_cfmpm_gives_the_status_of_the_command(scene: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "cfmpm", "run", "nowhere.yaml"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr == "nowhere.yaml: no such file\n"


class TestGrowth:
    """What run, check and plot say of cracks that grow."""

    @pytest.fixture
    def scene(self, scene: Path) -> Path:
        graded = SCENE.replace("element: T3, size: 2, grading: uniform", "element: T6, size: 2")
        scene.write_text(graded + "growth: {control: crack, increments: 4}\n")
        return scene

    def test_the_last_elements_before_an_arrival_count_for_nothing(self, scene: Path) -> None:
        """There no domain holds enough of them for J and G to be the same."""
        result = call("run", scene, "--set", "growth.increments=300")
        assert result.exit_code == 0, result.output
        assert "arrived at boundary" in result.stdout
        (told,) = [line for line in result.stdout.splitlines() if line.startswith("J / G - 1")]
        with xr.open_dataset("results/small/history.nc") as history:
            tip = history.isel(tip=0)
            apart = abs(tip["J"] / tip["G"] - 1)
            roomy = tip["clearance"] >= 3 * tip["tip_size"]
            within = float(apart.where(roomy).max())
        assert told.split()[-1] == f"{within:.1e}"
        assert within < float(apart.max())

    def test_the_summary_states_the_numbers_of_the_history(self, scene: Path) -> None:
        result = call("run", scene)
        assert result.exit_code == 0, result.output
        with xr.open_dataset("results/small/history.nc") as history:
            factor = history["load_factor"].values
            said = f"{factor[0]:.6g} at first growth, largest {factor.max():.6g} in step"
            assert said in result.stdout
            assert f"{float(history['kink_angle'][0, 0]):.3f}" in result.stdout
            for name in ("K_I", "K_II", "G"):
                values = history[name].values[:, 0]
                assert f"{values[0]:.6g} to {values[-1]:.6g}" in result.stdout
            apart = float(abs(history["J"] / history["G"] - 1).max())
            assert f"J / G - 1, largest       {apart:.1e}" in result.stdout
            end = f"({float(history['tip_x'][-1, 0]):.6g}, {float(history['tip_y'][-1, 0]):.6g})"
            assert end in result.stdout
            assert history.attrs["ending"] in result.stdout
            gap = history["external_work"] - history["strain_energy"] - history["fracture_energy"]
            assert float(abs(gap).max() / history["external_work"].max()) < 0.05
        for word in ("increments   4", "balance", "status", "growing", "path [mm]"):
            assert word in result.stdout
        assert max(map(len, result.stdout.splitlines())) <= 100

    def test_cycles_are_said_when_asked_for(self, scene: Path) -> None:
        changes = ("fatigue={C: 1e-12, m: 3}", "growth.control=fatigue", "material.g_c=null")
        result = call("run", scene, *(word for change in changes for word in ("--set", change)))
        assert result.exit_code == 0, result.output
        with xr.open_dataset("results/small/history.nc") as history:
            assert f"{float(history['cycles'][-1]):.6g}" in result.stdout
            for name in ("delta_K", "da_dN"):
                assert f"{float(history[name][0, 0]):.6g} to " in result.stdout

    @pytest.mark.parametrize(
        ("changes", "words"),
        [
            (
                [],
                (
                    "in each increment",
                    "G of the kink of the first tip",
                    "hoop",
                    "at most 4 increments",
                ),
            ),
            (["growth.control=load", "growth.criterion=cf_norm"], ("whose |CF| reaches g_c",)),
            (["growth.tips=largest", "growth.direction=cf"], ("only", "configurational force")),
            (["growth.control=fatigue", "fatigue={C: 1e-12, m: 3}"], ("by load cycles", "Paris'")),
        ],
    )
    def test_check_says_what_growth_will_do(
        self, scene: Path, changes: list[str], words: tuple[str, ...]
    ) -> None:
        result = call("check", scene, *(part for text in changes for part in ("--set", text)))
        assert result.exit_code == 0, result.output
        (start,) = (k for k, x in enumerate(result.stdout.splitlines()) if x.startswith("growth "))
        said = " ".join(" ".join(result.stdout.splitlines()[start : start + 3]).split())
        for word in words:
            assert word in said

    def test_the_log_has_a_line_for_each_increment(self, scene: Path) -> None:
        result = call("run", scene, "--verbose")
        lines = [line for line in result.stderr.splitlines() if line.startswith("increment")]
        assert [line.split(",")[0] for line in lines] == [f"increment {k}" for k in range(5)]
        assert "crack length 4 mm, load factor" in lines[0]

    def test_the_bar_on_a_terminal_shows_how_far_it_is(
        self, scene: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        class Terminal(io.StringIO):
            def isatty(self) -> bool:
                return True

        terminal = Terminal()
        monkeypatch.setattr(sys, "stderr", terminal)
        grown = load_scene(scene)
        with running._progress(grown, visible=True) as (announce, advance):
            simulation.run(grown, announce, advance)
        shown = terminal.getvalue()
        assert "increment 4, crack length 4." in shown
        assert "equilibrium" in shown

    def test_plot_draws_paths_forces_and_a_film(self, scene: Path) -> None:
        call("run", scene, "--set", "output.every=2", "--set", "output.fields=true")
        result = call("plot", "results/small")
        assert result.exit_code == 0, result.output
        names = {Path(line).name for line in result.stdout.split()}
        assert {"paths.png", "force_top_y.png", "deformed.png", "growth.gif"} <= names
        assert all(Path(line).is_file() for line in result.stdout.split())
