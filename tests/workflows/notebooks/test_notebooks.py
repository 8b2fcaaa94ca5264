"""The notebooks run and give the expected values."""

from __future__ import annotations

import runpy
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jupytext
import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from units_on_axes import require_units

NOTEBOOKS = Path(__file__).parents[3] / "workflows" / "notebooks"
NAMES = sorted(path.stem for path in NOTEBOOKS.glob("*.py"))


@pytest.fixture(autouse=True)
def no_windows(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Figures are not shown, and the style is restored."""
    monkeypatch.chdir(NOTEBOOKS)  # where Jupyter runs a notebook
    with mpl.rc_context():
        plt.switch_backend("agg")
        yield
        plt.close("all")


def run(name: str) -> dict[str, Any]:
    """Run a notebook and return its variables."""
    variables = runpy.run_path(f"{name}.py")
    for number in plt.get_fignums():
        figure = plt.figure(number)
        figure.draw_without_rendering()
        require_units(figure)
    return variables


@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_is_text_and_code_in_turns(name: str) -> None:
    notebook = jupytext.read(NOTEBOOKS / f"{name}.py")
    assert notebook.metadata["jupytext"]["text_representation"]["format_name"] == "percent"
    kinds = [cell.cell_type for cell in notebook.cells]
    assert kinds[:2] == ["markdown", "code"]
    assert notebook.cells[0].source.startswith("# ")


def test_first_look() -> None:
    shown = run("first_look")
    assert shown["found"] == pytest.approx(shown["published"], rel=0.005)
    assert shown["along"] == pytest.approx(shown["j"], rel=1e-3)
    assert len(plt.get_fignums()) == 1


@pytest.mark.slow
def test_radius_study() -> None:
    shown = run("radius_study")
    fine, coarse = (shown["study"].sel(grid=name) for name in ("T6 graded", "T3 uniform"))
    # Converged values of an independent study: K_I 107.65, K_II 14.347 for 1 MPa.
    exact = (107.65**2 + 14.347**2) * (1 - 0.25**2) / 206.8e3
    assert shown["exact"] == pytest.approx(exact, rel=2e-3)
    assert float(fine["J_spread"]) < 2e-4 * exact
    # The uniform grid settles, and stays below.
    settled = coarse["J_radius"].values[-3:]
    assert np.ptp(settled) < 5e-3 * exact
    assert 0.9 * exact < settled.mean() < 0.97 * exact
    assert 1.0 < shown["turned"] < 2.0


@pytest.mark.slow
def test_failure_load() -> None:
    shown = run("failure_load")
    strength, study = shown["strength"].values, shown["study"]
    # Brown and Srawley's polynomial, for an endless strip, is within a per cent of this plate.
    length = study["a"].values
    a = length / 500.0
    f = 1.12 - 0.231 * a + 10.55 * a**2 - 21.72 * a**3 + 30.39 * a**4
    toughness = (study["E"] / (1 - 0.3**2) * study["g_c"]).values
    expected = np.sqrt(toughness / (np.pi * length)) / f
    assert strength == pytest.approx(expected, rel=0.015)
    assert float(np.abs(shown["residual"]).max()) < 1e-3


@pytest.mark.slow
def test_crack_paths() -> None:
    shown = run("crack_paths")
    assert len(plt.get_fignums()) == len(shown["SCENES"]) == 4
    left = shown["histories"]["paper/plate_two_holes"].cfmpm.path()["left_crack"]
    x, y = shown["others"].T
    near = (x > 1.0) & (x < 11.0)  # further on, sound methods differ by 0.15 mm
    assert np.abs(np.interp(x[near], *left.T) - y[near]).max() < 0.15
    assert shown["angles"][0] == pytest.approx(-14.7, abs=2.0)
    assert shown["share"] < 0.01
    slanted = shown["histories"]["examples/centre_crack"].cfmpm.path()
    start, end = (slanted[f"crack_1_{end}"] for end in ("start", "end"))
    for path in ([100.0, 200.0] - start, end):  # half a turn about the centre of the scene
        steps = np.diff(path, axis=0)
        angles = np.degrees(np.arctan2(*steps.T[::-1]))
        # At 45 degrees in an endless plate K_I is K_II, and the kink is 53.13 degrees.
        assert angles[0] == pytest.approx(45.0 - 53.13, abs=1.5)
        # Then it goes level, across the pull.
        half = len(steps) // 2
        along = path[-2] - path[half]
        assert abs(np.degrees(np.arctan2(along[1], along[0]))) < 2.0


def test_every_notebook_has_its_test() -> None:
    assert {f"test_{name}" for name in NAMES} <= set(globals())
