"""Parameter studies by rules: which jobs there are, and that they give what `cfmpm study` gives."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr

STUDY = """\
name: by_rules
base: scene.yaml
product:
  length: {key: family.crack_length, values: [2, 3, 4]}
  E: {key: material.E, linspace: [100e3, 200e3, 2]}
batch: 2
"""
SCENE = """\
name: small
family: {kind: single_edge, width: 10, height: 20, crack_length: 4, traction: 10}
material: {E: 210e3, nu: 0.3, g_c: 1e-3}
mesh: {element: T3, size: 2, grading: uniform}
"""
# Two batches of three, and the first member of the third, out of balance.
FAILING = """\
name: by_rules
base:
  name: pulled
  geometry:
    outline: [{at: [0, 0], edge: bottom}, [10, 0], {at: [10, 20], edge: top}, [0, 20]]
    cracks: [{points: [[0, 10], [4, 10]]}]
  material: {E: 210e3, nu: 0.3}
  loads: [{edge: top, traction: [0, 5]}, {edge: bottom, traction: [0, -5]}]
  mesh: {element: T3, size: 2, grading: uniform}
zip:
  pull: {key: "loads[0].traction[1]", values: [5, 6]}
batch: 1
"""


@pytest.fixture(scope="module")
def checkout(root, tmp_path_factory):
    """A copy of the repository in which results may be made."""
    copy = tmp_path_factory.mktemp("checkout") / "repository"
    leave = shutil.ignore_patterns("results", ".git", ".snakemake", ".venv", "tests", "*cache*")
    shutil.copytree(root, copy, ignore=leave)
    (copy / "results").mkdir()
    return copy


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


def test_the_plan(call, study) -> None:
    planned = jobs(call(study, "--dry-run"))
    assert planned == [
        "Gathering study by_rules",
        *(f"Study by_rules, batch {i}" for i in range(3)),
    ]
    study.write_text(STUDY.replace("batch: 2", "batch: 4"))
    assert jobs(call(study, "--dry-run"))[1:] == [
        "Study by_rules, batch 0",
        "Study by_rules, batch 1",
    ]


def test_the_same_dataset_and_only_what_a_change_touches(call, study, checkout, tmp_path) -> None:
    dataset = checkout / "results" / "by_rules" / "study.nc"
    call(study, "--cores", "2")
    first = plain(dataset)
    assert first.identical(by_command(study, tmp_path / "command", checkout, workers=2))
    assert jobs(call(study, "--dry-run")) == []

    # A description is in no member: the dataset is gathered again, and no more.
    study.write_text(STUDY.replace("base:", "description: six members\nbase:"))
    assert jobs(call(study, "--dry-run")) == ["Gathering study by_rules"]
    # One value of three: its batch.
    study.write_text(STUDY.replace("[2, 3, 4]", "[2, 3.5, 4]"))
    assert jobs(call(study, "--dry-run")) == ["Gathering study by_rules", "Study by_rules, batch 1"]
    # A key of the scene that all members share: all of them.
    scene = study.with_name("scene.yaml")
    scene.write_text(SCENE.replace("nu: 0.3", "nu: 0.2"))
    assert len(jobs(call(study, "--dry-run"))) == 4
    scene.write_text(SCENE)

    # Within a batch those that are known are not solved again, and stay known.
    study.write_text(STUDY.replace("[2, 3, 4]", "[3, 4, 2]").replace("200e3", "150e3"))
    call(study, "--cores", "2")
    second = xr.load_dataset(dataset)
    before = xr.load_dataset(tmp_path / "command" / "study.nc")
    assert second["E"].values.tolist() == [100e3, 150e3]
    for length in (2, 3, 4):
        at = {"length": length, "E": 100e3}
        assert second["G"].sel(at).values == before["G"].sel(at).values
    times = xr.load_dataset(dataset)["run_time"].sel(E=100e3)
    study.write_text(STUDY)
    call(study, "--cores", "2")
    assert plain(dataset).identical(first)
    again = xr.load_dataset(dataset)["run_time"].sel(E=100e3)
    assert again.sel(length=times["length"]).values.tolist() == times.values.tolist()
    # What the rules have solved the command knows, and the other way round.
    done = subprocess.run(
        [sys.executable, "-m", "cfmpm", "study", str(study)],
        env={**os.environ, "PYTHONPATH": str(checkout)},
        cwd=checkout,
        check=True,
        capture_output=True,
        text=True,
    )
    assert "6 done, 6 of them known from before" in done.stdout


def test_failed_members_are_marked(call, study, checkout, tmp_path) -> None:
    study.write_text(FAILING)
    call(study, "--cores", "1")
    dataset = plain(checkout / "results" / "by_rules" / "study.nc")
    assert dataset["status"].values.tolist() == [0, 1]
    assert "out of balance" in str(dataset["reason"].values[1])
    assert dataset.identical(by_command(study, tmp_path / "command", checkout))


def test_a_bad_member_stops_before_any_job(call, study, checkout) -> None:
    study.write_text(STUDY.replace("[2, 3, 4]", "[2, 3, 40]"))
    said = call(study, "--cores", "1", check=False)
    assert f"{study}:4:3: member length=40, E=100000: family.crack_length" in said
    assert not (checkout / "results" / "by_rules").exists()


def test_no_study_is_given(snakemake) -> None:
    done = snakemake("study", "--dry-run", check=False)
    assert done.returncode != 0
    assert "no study given: --configfile" in done.stdout + done.stderr


def test_a_shipped_study_by_its_file(snakemake) -> None:
    done = snakemake("results/failure_load/study.nc", "--dry-run")
    messages = jobs(done.stdout + done.stderr)
    assert "Gathering study failure_load" in messages
    assert len(messages) == 5  # 200 members in batches of 50
