"""A run that was killed leaves no lock and no litter to the next one."""

from __future__ import annotations

import os
import socket
import subprocess
import sys

import pytest

from workflows.lock import free_stale_lock, remove_leavings

HOLD = (
    "import sys, pathlib; from workflows.lock import free_stale_lock\n"
    "free_stale_lock(pathlib.Path(sys.argv[1])); print('held', flush=True); sys.stdin.read()"
)


@pytest.fixture
def locked(tmp_path):
    """Snakemake's folder with its lock in it."""
    lock = tmp_path / ".snakemake" / "locks" / "0.output.lock"
    lock.parent.mkdir(parents=True)
    lock.write_text("results/paper/fig4.png\n")
    (tmp_path / ".snakemake" / "alive").write_text(socket.gethostname())
    return lock


@pytest.fixture
def other(locked, root):
    """Another run that holds the kernel's lock; it has taken away no lock but its own."""
    text = locked.read_text()
    command = [sys.executable, "-c", HOLD, str(locked.parents[1])]
    process = subprocess.Popen(
        command, cwd=root, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "held\n"
    locked.parent.mkdir()
    locked.write_text(text)
    yield process
    process.kill()
    process.communicate()


@pytest.mark.parametrize(("host", "freed"), [(socket.gethostname(), True), ("elsewhere", False)])
def test_a_lock_that_nobody_holds_is_freed(locked, host, freed):
    """But not that of another machine, whose kernel need not tell."""
    (locked.parents[1] / "alive").write_text(host)
    os.close(free_stale_lock(locked.parents[1]))
    assert locked.exists() != freed
    if not freed:
        locked.unlink()  # by `snakemake --unlock`
        free_stale_lock(locked.parents[1])
        assert (locked.parents[1] / "alive").read_text() == socket.gethostname()


def test_the_lock_of_a_run_is_left(locked, other):
    free_stale_lock(locked.parents[1])
    assert locked.exists()


def test_the_lock_of_a_killed_run_is_freed(locked, other):
    other.kill()
    other.wait()
    free_stale_lock(locked.parents[1])
    assert not locked.exists()


def test_leavings_are_removed_and_results_are_not(tmp_path):
    left = [tmp_path / "growth" / ".edge.nc.0123.part", tmp_path / ".fig4.png.x1" / "fig4.png"]
    kept = [tmp_path / "growth" / "edge.nc", tmp_path / "fig4.png"]
    for path in (*left, *kept):
        path.parent.mkdir(exist_ok=True)
        path.touch()
    remove_leavings(tmp_path, tmp_path / "not_there")
    assert not any(path.exists() for path in left)
    assert not (tmp_path / ".fig4.png.x1").exists()
    assert all(path.exists() for path in kept)


def test_snakemake_goes_on_after_a_kill_and_waits_for_none_that_runs(root, tmp_path, snakemake):
    """The whole of it, on a workflow of one job that waits."""
    (tmp_path / "Snakefile").write_text(
        f"import sys; sys.path.insert(0, {str(root)!r})\n"
        "from pathlib import Path\n"
        "from workflows.lock import free_stale_lock\n"
        "ALIVE = free_stale_lock(Path('.snakemake'))\n"
        "rule wait:\n    output: 'done'\n"
        "    shell: 'touch begun; while [ ! -e go ]; do sleep 0.1; done; touch done'\n"
    )
    command = [sys.executable, "-m", "snakemake", "--cores", "1"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    first = subprocess.Popen(command, cwd=tmp_path, **quiet)
    try:
        while not (tmp_path / "begun").exists():
            assert first.poll() is None
        refused = snakemake("--cores", "1", folder=tmp_path, check=False)
        assert "cannot be locked" in refused.stdout + refused.stderr
        snakemake("--dry-run", folder=tmp_path)
        assert list((tmp_path / ".snakemake" / "locks").iterdir())
    finally:
        first.kill()
        first.wait()
        (tmp_path / "go").touch()
    snakemake("--cores", "1", "--rerun-incomplete", folder=tmp_path)
    assert (tmp_path / "done").exists()
