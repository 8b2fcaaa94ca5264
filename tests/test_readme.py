"""The examples of the README work as printed."""

from __future__ import annotations

import re
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.quiver import Quiver
from typer.testing import CliRunner

from cfmpm.cli.app import app

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text("utf-8")


def block(language: str, holding: str) -> str:
    """The code block that contains a text."""
    blocks = re.findall(rf"^```{language}\n(.*?)^```$", README, flags=re.MULTILINE | re.DOTALL)
    (found,) = (text for text in blocks if holding in text)
    return found


@pytest.mark.slow
def test_a_scene_of_your_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    plt.switch_backend("agg")
    scene, growth = block("yaml", "name: bracket"), block("yaml", "control: crack")
    Path("bracket.yaml").write_text(scene)
    commands = re.findall(r"^cfmpm (\w+) (\S+)", block("bash", "cfmpm check"), re.MULTILINE)
    assert [name for name, _ in commands] == ["check", "run", "plot"]
    for command in commands:
        done = CliRunner().invoke(app, command)
        assert done.exit_code == 0, done.output
    variables: dict[str, object] = {}
    exec(block("python", "cfmpm.open_history"), variables)
    history, coarse = variables["history"], variables["coarse"]
    assert float(abs(coarse.G / history.G - 1).max()) < 0.02
    assert any(isinstance(c, Quiver) for c in plt.gca().collections)
    plt.close("all")
    # Each block by itself, as a reader pastes it.
    exec(block("python", ".write("), {})
    for length in (10, 20, 30):
        assert Path(f"results/bracket_{length}/history.nc").is_file()

    Path("bracket.yaml").write_text(scene + growth)
    done = CliRunner().invoke(app, ["run", "bracket.yaml", "--set", "growth.increments=2"])
    assert done.exit_code == 0, done.output
    assert "increments: growth.increments allows 2" in done.output


def test_every_link_to_a_file_leads_to_one() -> None:
    links = re.findall(r"\]\((?!https?:)([^)#]+)\)", README)
    assert {"docs/theory.md", "docs/scene.md", "docs/extending.md"} <= set(links)
    for link in links:
        assert (ROOT / link).exists(), link


def test_folders_and_files_that_are_named_exist() -> None:
    named = set(re.findall(r"`((?:configs|workflows|tests|docs)/[\w./-]*)`", README))
    assert len(named) >= 4
    for path in named:
        assert (ROOT / path).exists(), path


def test_the_picture_is_small() -> None:
    pictures = list((ROOT / ".assets").iterdir())
    assert [p.name for p in pictures] == ["growth.png"]
    assert pictures[0].stat().st_size < 150_000
    assert np.ptp(plt.imread(pictures[0])) > 0.5
