"""The workflow as Snakemake sees it, without running a job."""

from __future__ import annotations

import resource
import subprocess
import sys

import pytest

TARGETS = [
    "reproduce-paper",
    "reproduce_paper",
    "work-precision",
    "scaling",
    "stability",
    "newton-cost",
    "study-overhead",
]


@pytest.mark.parametrize("target", TARGETS)
def test_dry_run_is_quick(snakemake, target):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    snakemake(target, "--dry-run")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    # Processor time, for the machine may have other work.
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    assert spent < 5.0


def jobs(done):
    """Number of jobs of each rule in a dry run, without targets."""
    rows = [line.split() for line in done.stdout.splitlines() + done.stderr.splitlines()]
    pairs = [row for row in rows if len(row) == 2 and row[1].isdecimal()]
    found = {name: int(number) for name, number in pairs if not name.endswith(":")}
    for target in ("total", "all", *TARGETS):
        found.pop(target, None)
    return found


def test_a_bare_call_reproduces_the_paper_by_few_jobs(snakemake):
    bare = jobs(snakemake("--dry-run", "--forceall"))
    assert bare == jobs(snakemake("reproduce-paper", "--dry-run", "--forceall"))
    assert {"warm_up", "growth", "section_5_1", "overview"} <= bare.keys()
    # Starting Python takes two seconds: what takes less shares its process with others, but for
    # the grids of a sweep, of which a few are a job.
    assert bare["study_batch"] > 1
    assert sum(bare.values()) < 40


def test_dry_run_loads_neither_numba_nor_gmsh(root):
    program = (
        "import sys\n"
        "from snakemake.cli import main\n"
        "try:\n"
        "    main(['reproduce-paper', '--dry-run', '--quiet', 'all'])\n"
        "except SystemExit as end:\n"
        "    assert not end.code\n"
        "print('loaded', sorted({'numba', 'gmsh', 'matplotlib', 'skfem'} & set(sys.modules)))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=root, capture_output=True, text=True, check=True
    )
    assert "loaded []" in done.stdout


def test_lint(snakemake):
    text = snakemake("--lint", check=False).stderr
    found = {line.strip() for line in text.splitlines() if line.startswith("    * ")}
    # The one exception: rules run in the environment in which cfmpm is installed. An environment
    # for each rule would state the package's dependencies a second time.
    assert found <= {"* Specify a conda environment or container for each rule.:"}


def test_format(root):
    pytest.importorskip("snakefmt")
    done = subprocess.run(
        [sys.executable, "-m", "snakefmt", "--check", "Snakefile", "workflows"],
        cwd=root,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_bad_configuration_stops_before_any_job(snakemake):
    done = snakemake(
        "reproduce-paper",
        "--dry-run",
        "--config",
        "section_5_1={domain_radius: -1, domain_radios: 50}",
        check=False,
    )
    assert done.returncode != 0
    said = done.stdout + done.stderr
    assert "domain_radius" in said
    assert "domain_radios" in said


def test_bad_grid_stops_before_any_job(snakemake):
    mesh = "{element: T3, size: -5, grading: uniform}"
    done = snakemake(
        "scaling", "--dry-run", "--config", f"scaling={{series: {{T3: [{mesh}]}}}}", check=False
    )
    assert done.returncode != 0
    assert "size" in done.stdout + done.stderr
