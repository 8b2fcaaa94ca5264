from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from matplotlib.figure import Figure
from units_on_axes import require_units

ROOT = Path(__file__).resolve().parents[2]

for name in ("skfem", "snakemake"):
    pytest.importorskip(name)


@pytest.fixture(autouse=True)
def units_on_axes(monkeypatch):
    """Every axis of a written figure has its unit."""
    save = Figure.savefig

    def save_with_units(figure, *arguments, **options):
        require_units(figure)
        save(figure, *arguments, **options)

    monkeypatch.setattr(Figure, "savefig", save_with_units)


@pytest.fixture(scope="session")
def root():
    """The repository."""
    return ROOT


@pytest.fixture(scope="session")
def snakemake():
    """Call snakemake as a user does; return the completed process."""

    def call(*arguments, folder=ROOT, check=True, **environment):
        done = subprocess.run(
            [sys.executable, "-m", "snakemake", *arguments],
            cwd=folder,
            env={**os.environ, **environment},
            capture_output=True,
            text=True,
            check=False,
        )
        if check:
            assert done.returncode == 0, done.stdout + done.stderr
        return done

    return call


@pytest.fixture(scope="session")
def scene_file(root):
    return str(root / "configs/paper/single_edge_crack.yaml")


@pytest.fixture(scope="session")
def checkout(root, tmp_path_factory):
    """A copy of the repository for results."""
    copy = tmp_path_factory.mktemp("checkout") / "repository"
    leave = shutil.ignore_patterns("results", ".git", ".snakemake", ".venv", "tests", ".*_cache")
    shutil.copytree(root, copy, ignore=leave)
    (copy / "results").mkdir()
    return copy
