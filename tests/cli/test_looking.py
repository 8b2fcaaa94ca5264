"""Output and figures of check and plot."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import xarray as xr
from commands import call, expect_failure

from cfmpm import build
from cfmpm.equilibrium import small_strain
from cfmpm.errors import MeshError


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

    @pytest.mark.parametrize(
        ("change", "said"),
        [
            ("family.traction=100e6", "a traction of 1e+08 gives a strain of the order of 4.8e+02"),
            ("material.E=21", "a traction of 10 gives a strain of the order of 0.48"),
            ("load_steps=[1, 6e3]", "a traction of 60000 gives a strain of the order of 0.29"),
        ],
    )
    def test_says_that_loads_look_like_other_units(
        self, scene: Path, change: str, said: str
    ) -> None:
        assert "check the units" not in call("check", scene).stdout
        told = " ".join(call("check", scene, "--set", change).stdout.split())
        assert f"{said}, its stress by material.E of" in told
        assert "check the units, which are mm, N and MPa" in told

    def test_mistaken_units_are_told_before_what_follows_from_them(self, scene: Path) -> None:
        for change in ("material.E=21", "material={E: 210e9, nu: 0.3}"):
            call("run", scene, "--set", change)
            history = xr.load_dataset("results/small/history.nc")
            assert "check" in json.loads(history.attrs["warnings"])[0]
        change = "loads=[{name: fall, body_force: [0, 7.85]}, {edge: bottom, displacement: {y: 0}}]"
        rest = "family={kind: single_edge, width: 10, height: 20, crack_length: 4}"
        said = " ".join(
            call(
                "check", scene, "--set", change, "--set", rest, "--set", "material.E=210"
            ).stdout.split()
        )
        assert "fall: a body_force of 7.85 gives a strain of the order of 0.75" in said

    def test_large_strain_that_is_meant_is_no_doubt(self, scene: Path) -> None:
        """Nor is the load of growth at the critical one, which is scaled."""
        rubber = ("--set", "material={E: 21, nu: 0.3, g_c: 1}")
        said = " ".join(call("check", scene, *rubber).stdout.split())
        assert "kinematics: finite goes with such strains" in said
        for way in ("kinematics=finite", "growth={control: crack}"):
            result = call("check", scene, *rubber, "--set", way)
            assert result.exit_code == 0, result.output
            assert "check the units" not in result.stdout

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
        pytest.importorskip("pyvista")
        expect_failure(call("export", "results/none"), 2, "results/none/history.nc: no such result")

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
        expect_failure(call("plot", "other.nc"), 2, "is not a result of cfmpm run")

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
