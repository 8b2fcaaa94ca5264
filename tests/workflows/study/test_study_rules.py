"""Parameter studies by rules: their jobs, and results equal to those of `cfmpm study`."""

from __future__ import annotations

import os
import random
import re
import shutil
import signal
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
    """A study file outside the repository."""
    (tmp_path / "scene.yaml").write_text(SCENE)
    path = tmp_path / "study.yaml"
    path.write_text(STUDY)
    shutil.rmtree(checkout / "results" / "by_rules", ignore_errors=True)
    return path


@pytest.fixture
def call(snakemake, checkout):
    """Call Snakemake in the copy and return its output."""

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
    """A dataset without variables that differ between two runs."""
    dataset = xr.load_dataset(path).drop_vars(["run_time", "cpu_time"])
    for name in ("date_created", "history"):
        del dataset.attrs[name]
    return dataset


def by_command(study: Path, folder: Path, *paths: Path, workers: int = 1) -> xr.Dataset:
    """The dataset that `cfmpm study` makes."""
    subprocess.run(
        [
            *(sys.executable, "-m", "cfmpm", "study", str(study)),
            *(f"--workers={workers}", "--output", str(folder)),
        ],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(map(str, paths))},
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
    # In a folder of the study, or the log of its batch 0 would be that of a study by_rules_0.
    logs = (checkout / "results" / "logs" / "study" / "by_rules").iterdir()
    assert {path.name for path in logs} == {"0.log", "1.log", "2.log"}
    first, times = plain(dataset), xr.load_dataset(dataset)["run_time"]
    assert first["status"].values.tolist() == [[0, 0, 0], [1, 1, 1]]
    assert "out of balance" in str(first["reason"].values[1, 0])
    for workers in (1, 2):
        other = by_command(study, tmp_path / f"command_{workers}", checkout, workers=workers)
        assert first.identical(other)
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
    dataset = checkout / "results" / "by_rules" / "study.nc"
    call(study, "--cores", "2")
    assert jobs(call(study, "--dry-run")) == []
    first = xr.load_dataset(dataset)["run_time"]
    module = checkout / "cfmpm" / "clock.py"
    before = module.read_text()
    try:
        module.write_text(before + "\n# Another version.\n")
        # After the warm-up, which is due as well, jobs might still find all members known.
        assert len(jobs(call(study, "--cores", "2"))) == 4
    finally:
        module.write_text(before)
    solved = first.notnull()
    assert solved.any()
    assert (xr.load_dataset(dataset)["run_time"] != first).where(solved, True).all()


def test_a_bad_member_stops_before_any_job(call, study, checkout) -> None:
    study.write_text(STUDY.replace("300e3", "-1"))
    said = call(study, "--cores", "1", check=False)
    told = "in 2 members, such as pull=5, E=-1: material.E: must be greater than 0"
    assert f"{study}:5:3: {told}" in said
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


def test_all_shipped_studies_are_planned(snakemake, checkout) -> None:
    done = snakemake("studies", "--dry-run", folder=checkout)
    gathered = [one for one in jobs(done.stdout + done.stderr) if one.startswith("Gathering")]
    assert len(gathered) == len(list((checkout / "configs" / "studies").glob("*.yaml")))


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


# Kills the process that solves a certain member, as long as a file is there.
DEADLY = """\
import importlib.util, os, sys

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name != "cfmpm.simulation":
            return None
        sys.meta_path.remove(self)
        spec = importlib.util.find_spec(name)
        load = spec.loader.exec_module

        def load_deadly(module):
            load(module)
            run = module.run

            def deadly(scene, *arguments, **keywords):
                if scene.material.E == 2e5 and os.path.exists(__file__ + ".armed"):
                    os.kill(os.getpid(), 9)
                return run(scene, *arguments, **keywords)

            module.run = deadly

        spec.loader.exec_module = load_deadly
        return spec

sys.meta_path.insert(0, Finder())
"""


def test_a_member_whose_process_is_killed_is_marked(snakemake, study, checkout, tmp_path) -> None:
    study.write_text(STUDY.replace("[5, 6]", "[5]"))
    site = tmp_path / "site" / "sitecustomize.py"
    site.parent.mkdir()
    site.write_text(DEADLY)
    armed = site.with_name(site.name + ".armed")
    armed.touch()
    path = os.pathsep.join([str(site.parent), str(checkout)])

    def call(*arguments: str) -> list[str]:
        given = ("study", "--configfile", str(study), *arguments)
        done = snakemake(*given, folder=checkout, PYTHONPATH=path)
        return jobs(done.stdout + done.stderr)

    call("--cores", "1")
    dataset = checkout / "results" / "by_rules" / "study.nc"
    first = plain(dataset)
    assert first["status"].values.tolist() == [[0, 1, 0]]
    assert first["reason"].values[0, 1] == "its process was killed; not enough memory?"
    assert first.identical(by_command(study, tmp_path / "command", site.parent, checkout))
    # It is due as long as it is lost, and then no more.
    due = ["Gathering study by_rules", "Study by_rules, batch 0"]
    assert call("--dry-run") == due
    assert set(call("--cores", "1")) == set(due)
    assert call("--dry-run") == due
    armed.unlink()
    call("--cores", "1")
    assert (xr.load_dataset(dataset)["status"] == 0).all()
    assert call("--dry-run") == []


def test_a_mistake_in_a_given_study_is_told_by_its_place(call, study) -> None:
    study.write_text(STUDY.replace("product:", "prodct:"))
    said = call(study, "--dry-run", check=False)
    assert f"{study}:3:1: prodct: unknown key; did you mean product?" in said
    assert "pydantic" not in said
    study.write_text(STUDY.replace("base:", "bse:"))
    assert f"{study}:2:1: bse: unknown key; did you mean base?" in call(
        study, "--dry-run", check=False
    )


def test_two_given_studies_of_one_name(call, study) -> None:
    other = study.with_name("other.yaml")
    other.write_text(STUDY)
    said = call(study, str(other), "--dry-run", check=False)
    assert f"{other}: name: is the name of {study} too" in said


@pytest.mark.slow
def test_killed_at_random_moments(study, checkout, tmp_path) -> None:
    values = ", ".join(f"{100 + 10 * i}e3" for i in range(12))
    study.write_text(STUDY.replace("100e3, 200e3, 300e3", values))
    command = [sys.executable, "-m", "snakemake", "study", "--configfile", str(study)]

    def start() -> subprocess.Popen:
        return subprocess.Popen(
            [*command, "--cores", "2"],
            cwd=checkout,
            env={**os.environ, "PYTHONPATH": str(checkout)},
            start_new_session=True,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    moments, kills = random.Random(1), 0
    while kills < 6:
        run = start()
        try:
            run.wait(timeout=moments.uniform(2.0, 12.0))
        except subprocess.TimeoutExpired:
            os.killpg(run.pid, signal.SIGKILL)
            run.wait()
            kills += 1
        else:
            assert run.returncode == 0
            shutil.rmtree(checkout / "results" / "by_rules")
    assert start().wait() == 0
    folder = checkout / "results" / "by_rules"
    whole = by_command(study, tmp_path / "command", checkout, workers=2)
    assert plain(folder / "study.nc").identical(whole)
    assert sorted(path.name for path in folder.iterdir()) == ["members", "study.nc"]
    names = {path.name for path in (folder / "members").iterdir()}
    assert names == {f"batch_{i}.npz" for i in range(12)}
