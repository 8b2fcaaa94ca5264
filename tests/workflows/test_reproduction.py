"""The whole paper from a clean clone: once, twice, killed and resumed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest
import xarray as xr

pytestmark = pytest.mark.slow

SECTION = ["fig4.nc", "fig5.nc", "fig6.nc", "fig7.nc", "section_5_1.csv"]
FIGURES = (4, 5, 6, 7, *range(9, 17))
EVERYTHING = [
    *(f"fig{n}.{kind}" for n in FIGURES for kind in ("nc", "png")),
    *(f"growth/{study}.nc" for study in ("edge", "shear", "holes", "beam")),
    *(f"{study}.gif" for study in ("edge", "shear", "holes", "beam")),
    *(
        f"{section}.{kind}"
        for section in ("section_5_1", "sections_5_2_to_5_5")
        for kind in ("csv", "md", "html")
    ),
]


@pytest.fixture(scope="module")
def clone(root, tmp_path_factory):
    """Make a clean clone of HEAD, and an environment with a cold cache of kernels."""

    def make():
        folder = tmp_path_factory.mktemp("clone")
        subprocess.run(["git", "clone", "-q", str(root), str(folder)], check=True)
        return folder, {"NUMBA_CACHE_DIR": str(folder / ".numba")}

    return make


@pytest.fixture(scope="module")
def reproduced(clone, snakemake):
    folder, environment = clone()
    snakemake("reproduce-paper", folder=folder, **environment)
    return folder, environment


def test_everything_is_there(reproduced):
    folder, _ = reproduced
    for name in EVERYTHING:
        assert (folder / "results/paper" / name).stat().st_size > 0


def test_second_call_does_nothing(reproduced, snakemake):
    folder, environment = reproduced
    done = snakemake("reproduce-paper", folder=folder, **environment)
    assert "Nothing to be done" in done.stdout + done.stderr


def test_report(reproduced, snakemake):
    folder, environment = reproduced
    snakemake("reproduce-paper", "--report", "report.html", folder=folder, **environment)
    text = (folder / "report.html").read_text(encoding="utf-8")
    for name in EVERYTHING:
        assert name in text or not name.endswith((".png", ".gif", ".html"))


def test_killed_run_resumes_to_the_same_data(reproduced, clone, snakemake):
    whole, environment = reproduced  # its cache of kernels is warm
    folder, _ = clone()
    targets = [f"results/paper/{name}" for name in SECTION]
    process = subprocess.Popen(
        [sys.executable, "-m", "snakemake", *targets],
        cwd=folder,
        env={**os.environ, **environment},
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    deadline = time.monotonic() + 120
    first = folder / "results/paper/section_5_1"
    while not list(first.glob("*.nc")) and time.monotonic() < deadline:
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    kept = {path.name: path.stat().st_mtime_ns for path in first.glob("*.nc")}
    assert kept
    assert not all((folder / target).exists() for target in targets)

    snakemake("--unlock", folder=folder, **environment)  # a killed run leaves its lock
    snakemake(*targets, folder=folder, **environment)
    for name in SECTION:
        ours, theirs = folder / "results/paper" / name, whole / "results/paper" / name
        if name.endswith(".nc"):
            xr.testing.assert_equal(xr.load_dataset(ours), xr.load_dataset(theirs))
        else:
            assert ours.read_bytes() == theirs.read_bytes()
    # The job that was done was not done again, unless the kill came before Snakemake noted it.
    done_again = [name for name in kept if (first / name).stat().st_mtime_ns != kept[name]]
    assert len(done_again) <= len(os.sched_getaffinity(0))
