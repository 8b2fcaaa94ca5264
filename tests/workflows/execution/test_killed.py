"""Runs killed at random times and restarted: equal results, no partial files.

CI runs a small part. The whole paper, killed twenty times, is
``pytest --log-cli-level=INFO tests/workflows/execution/test_killed.py`` with the environment
``KILLED_TARGET=reproduce-paper KILLS=20``.
"""

from __future__ import annotations

import contextlib
import logging
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import xarray as xr

log = logging.getLogger(__name__)
pytestmark = pytest.mark.slow

TARGET, KILLS = os.environ.get("KILLED_TARGET", "section_5_2"), int(os.environ.get("KILLS", "4"))
TIMES = ["run_time", "cpu_time"]
UNFINISHED = re.compile(r"batch_\d+\.[0-9a-f]+\.npz")


def start(folder, environment):
    return subprocess.Popen(
        [sys.executable, "-m", "snakemake", TARGET],
        cwd=folder,
        env={**os.environ, **environment},
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def visible(folder):
    """Result files without the logs and benchmarks of Snakemake."""
    results = folder / "results"
    found = {
        path.relative_to(results): path
        for path in results.rglob("*")
        if path.is_file() and not any(part.startswith(".") for part in path.parts)
    }
    return {
        name: path for name, path in found.items() if name.parts[0] not in ("logs", "benchmarks")
    }


def assert_same(ours, theirs):
    """Compare two files."""
    if ours.suffix == ".nc":  # their attributes tell when they were made
        both = [xr.load_dataset(path) for path in (ours, theirs)]
        xr.testing.assert_equal(*(one.drop_vars(TIMES, errors="ignore") for one in both))
    elif ours.suffix == ".npz":  # members with their times, from which the dataset is gathered
        with np.load(ours, allow_pickle=False) as found:
            assert all(len(found[name]) for name in found.files)
    elif ours.name == "overview.html":  # tells how long it took
        texts = [path.read_text(encoding="utf-8") for path in (ours, theirs)]
        assert len(texts[0]) == pytest.approx(len(texts[1]), abs=100)
        assert texts[0].endswith("</html>\n")
    else:
        assert ours.read_bytes() == theirs.read_bytes(), ours


@pytest.fixture(scope="module")
def whole(root, tmp_path_factory):
    """Results of an undisturbed run, its configuration, and its run time [s]."""
    folder = tmp_path_factory.mktemp("whole")
    subprocess.run(["git", "clone", "-q", str(root), str(folder)], check=True)
    environment = {"NUMBA_CACHE_DIR": str(tmp_path_factory.mktemp("numba"))}
    assert start(folder, environment).wait() == 0  # fills the cache of kernels
    shutil.rmtree(folder / "results/paper", ignore_errors=True)
    (folder / "results/.compiled").unlink()
    begun = time.monotonic()
    assert start(folder, environment).wait() == 0
    return folder, environment, time.monotonic() - begun


def test_killed_at_random_moments(root, whole, tmp_path):
    reference, environment, seconds = whole
    expected = visible(reference)
    folder = tmp_path / "killed"
    subprocess.run(["git", "clone", "-q", str(root), str(folder)], check=True)
    moments, kills, done, orphaned = random.Random(0), 0, 0, []
    while kills < KILLS:
        process = start(folder, environment)
        try:
            assert process.wait(timeout=moments.uniform(0.0, seconds)) == 0
        except subprocess.TimeoutExpired:
            kills += 1
            if moments.random() < 0.5:  # its jobs live on, and write
                orphaned.append(process.pid)
                os.kill(process.pid, signal.SIGKILL)
            else:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        else:
            done += 1
        for name, path in visible(folder).items():
            if name in expected:
                assert_same(path, expected[name])
            else:  # what is solved of a batch that is not done
                assert UNFINISHED.fullmatch(path.name), name
        if process.returncode == 0:
            shutil.rmtree(folder / "results/paper", ignore_errors=True)
    told = "%d kills in a run of %.0f s, %d of Snakemake alone; %d runs came to their end"
    log.info(told, kills, seconds, len(orphaned), done)
    for group in orphaned:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(group, signal.SIGKILL)
    last = start(folder, environment)
    assert last.wait() == 0  # no lock is in its way
    assert visible(folder).keys() == expected.keys()
    for name, path in visible(folder).items():
        assert_same(path, expected[name])
    assert not list((folder / "results/paper").rglob(".*"))
