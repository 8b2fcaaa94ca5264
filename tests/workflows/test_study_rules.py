"""Parameter studies by rules: which jobs there are, and that they give what `cfmpm study` gives."""

from __future__ import annotations

import os
import re
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

# Batches of pull, E: (5, 1), (5, 2) | (5, 3), (6, 1) | (6, 2), (6, 3). 6 is out of balance.
STUDY = """\
name: by_rules
base: scene.yaml
product:
  pull: {key: "loads[0].traction[1]", values: [5, 6]}
  E: {key: material.E, values: [100e3, 200e3, 300e3]}
batch: 2
"""
SCENE = """\
name: pulled
geometry:
  outline: [{at: [0, 0], edge: bottom}, [10, 0], {at: [10, 20], edge: top}, [0, 20]]
  cracks: [{points: [[0, 10], [4, 10]]}]
material: {E: 210e3, nu: 0.3}
loads: [{edge: top, traction: [0, 5]}, {edge: bottom, traction: [0, -5]}]
mesh: {element: T3, size: 2, grading: uniform}
"""


@pytest.fixture
def study(checkout, tmp_path):
    """A study file outside of the repository."""
    (tmp_path / "scene.yaml").write_text(SCENE)
    path = tmp_path / "study.yaml"
    path.write_text(STUDY)
    shutil.rmtree(checkout / "results" / "by_rules", ignore_errors=True)
    return path


@pytest.fixture
def call(snakemake, checkout):
    """Call Snakemake in the copy; what it said."""

    def run(study, *arguments, **options):
        done = snakemake(
            "study",
            "--configfile",
            str(study),
            *arguments,
            folder=checkout,
            PYTHONPATH=str(checkout),
            **options,
        )
        return done.stdout + done.stderr

    return run


def jobs(said: str) -> list[str]:
    """The messages of all jobs, without those of the warm-up."""
    found = re.findall(r"^Job \d+: (.*)$", said, re.MULTILINE)
    return sorted(message for message in found if message != "Compiling the kernels")


def plain(path: Path) -> xr.Dataset:
    """A dataset without what differs between two runs."""
    dataset = xr.load_dataset(path).drop_vars("run_time")
    for name in ("date_created", "history"):
        del dataset.attrs[name]
    return dataset


def by_command(study: Path, folder: Path, checkout: Path, workers: int = 1) -> xr.Dataset:
    """The dataset that `cfmpm study` makes."""
    subprocess.run(
        [
            *(sys.executable, "-m", "cfmpm", "study", str(study)),
            *(f"--workers={workers}", "--output", str(folder)),
        ],
        env={**os.environ, "PYTHONPATH": str(checkout)},
        cwd=folder.parent,
        check=True,
        capture_output=True,
    )
    return plain(folder / "study.nc")


def test_the_same_dataset_and_only_what_a_change_touches(call, study, checkout, tmp_path) -> None:
    dataset = checkout / "results" / "by_rules" / "study.nc"
    gathering, *batches = every = [
        "Gathering study by_rules",
        *(f"Study by_rules, batch {i}" for i in range(3)),
    ]
    assert jobs(call(study, "--cores", "2")) == every
    first, times = plain(dataset), xr.load_dataset(dataset)["run_time"]
    assert first["status"].values.tolist() == [[0, 0, 0], [1, 1, 1]]
    assert "out of balance" in str(first["reason"].values[1, 0])
    assert first.identical(by_command(study, tmp_path / "command", checkout, workers=2))
    assert jobs(call(study, "--dry-run")) == []

    # A description is in no member: the dataset is gathered again, and no more.
    study.write_text(STUDY.replace("base:", "description: six members\nbase:"))
    assert jobs(call(study, "--dry-run")) == [gathering]
    # One value of E, which two members have: their batches.
    study.write_text(STUDY.replace("200e3", "250e3"))
    assert jobs(call(study, "--dry-run")) == [gathering, batches[0], batches[2]]
    # A key of the scene that all members share.
    scene = study.with_name("scene.yaml")
    scene.write_text(SCENE.replace("nu: 0.3", "nu: 0.2"))
    assert jobs(call(study, "--dry-run")) == every
    scene.write_text(SCENE)

    # Another order and one new value: all batches, but in them only what is new is solved.
    study.write_text(STUDY.replace("100e3, 200e3, 300e3", "300e3, 100e3, 250e3"))
    call(study, "--cores", "2")
    second = xr.load_dataset(dataset)
    for E in (100e3, 300e3):
        np.testing.assert_array_equal(second["G"].sel(E=E), first["G"].sel(E=E))
        np.testing.assert_array_equal(second["run_time"].sel(E=E), times.sel(E=E))
    # And back: nothing is solved again, by rules or by the command.
    study.write_text(STUDY)
    call(study, "--cores", "2")
    assert plain(dataset).identical(first)
    assert xr.load_dataset(dataset)["run_time"].identical(times)
    done = subprocess.run(
        [sys.executable, "-m", "cfmpm", "study", str(study)],
        env={**os.environ, "PYTHONPATH": str(checkout)},
        cwd=checkout,
        check=True,
        capture_output=True,
        text=True,
    )
    assert "6 of them known from before" in done.stdout


def test_a_changed_program_solves_all_again(call, study, checkout) -> None:
    module = checkout / "cfmpm" / "clock.py"
    before = module.read_text()
    module.write_text(before + "\n# Another version.\n")
    assert len(jobs(call(study, "--dry-run"))) == 4
    module.write_text(before)


def test_a_bad_member_stops_before_any_job(call, study, checkout) -> None:
    study.write_text(STUDY.replace("300e3", "-1"))
    said = call(study, "--cores", "1", check=False)
    assert f"{study}:5:3: member pull=5, E=-1: material.E: must be greater than 0" in said
    assert not (checkout / "results" / "by_rules").exists()


def test_no_study_is_given(snakemake) -> None:
    done = snakemake("study", "--dry-run", check=False)
    assert done.returncode != 0
    assert "no study given: --configfile" in done.stdout + done.stderr


def test_a_shipped_study_by_its_file(snakemake, checkout) -> None:
    done = snakemake("results/failure_load/study.nc", "--dry-run", folder=checkout)
    messages = jobs(done.stdout + done.stderr)
    assert "Gathering study failure_load" in messages
    assert len(messages) == 5  # 200 members in batches of 50


def test_all_shipped_studies_are_planned_quickly(snakemake, checkout) -> None:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = snakemake("studies", "--dry-run", folder=checkout)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    gathered = [one for one in jobs(done.stdout + done.stderr) if one.startswith("Gathering")]
    assert len(gathered) == len(list((checkout / "configs" / "studies").glob("*.yaml")))
    # Processor time, for the machine may have other work.
    assert after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime < 5.0


def test_planning_a_study_loads_neither_numba_nor_gmsh(checkout) -> None:
    program = (
        "import sys\n"
        "from snakemake.cli import main\n"
        "try:\n"
        "    main(['results/failure_load/study.nc', '--dry-run', '--quiet', 'all'])\n"
        "except SystemExit as end:\n"
        "    assert not end.code\n"
        "print('loaded', sorted({'numba', 'gmsh', 'matplotlib'} & set(sys.modules)))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=checkout, capture_output=True, text=True, check=True
    )
    assert "loaded []" in done.stdout
