"""Output of run, check and plot for growing cracks."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import pytest
import xarray as xr
from commands import SCENE, call

from cfmpm import simulation
from cfmpm.cli import running
from cfmpm.scene import load_scene


class TestGrowth:
    """Output of run, check and plot for growing cracks."""

    @pytest.fixture
    def scene(self, scene: Path) -> Path:
        graded = SCENE.replace("element: T3, size: 2, grading: uniform", "element: T6, size: 2")
        scene.write_text(graded + "growth: {control: crack, increments: 4}\n")
        return scene

    def test_the_last_elements_before_an_arrival_count_for_nothing(self, scene: Path) -> None:
        """A domain there contains too few elements for J and G to agree."""
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
