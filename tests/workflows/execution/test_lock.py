"""A killed run leaves no lock and no temporary files to the next run."""

from __future__ import annotations

import os
import socket
import subprocess
import sys

import pytest

from cfmpm.output.run_folder import held
from workflows.execution.lock import clear_after_kill, remove_unfinished

HOLD = (
    "import sys, pathlib; from workflows.execution.lock import clear_after_kill\n"
    "clear_after_kill(pathlib.Path(sys.argv[1])); print('held', flush=True)\n"
    "sys.stdin.read()"
)
OUTPUTS = (
    *("results/.compiled", "results/paper/fig4.png", "results/paper/growth/{study,edge|beam}.nc"),
    *("results/stability/cases.nc", "results/{study,[A-Z]*}/study.nc"),
    "results/{study}/members/batch_{batch}.npz",
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
    """Another run that holds the lock of the operating system."""
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


def begin(locked):
    """Start another run."""
    alive = clear_after_kill(locked.parents[1])
    remove_unfinished(alive, locked.parents[2], OUTPUTS)
    return alive


@pytest.fixture
def unfinished(locked):
    """Temporary files of jobs in all folders of results."""
    results = locked.parents[2] / "results"
    folder = results / "paper/.fig4.png.x1y_2z3a"
    paths = [
        *(folder / "fig4.png", results / "paper/growth/.edge.nc.0123abcd.part"),
        *(results / "stability/.cases.nc.0123abcd.part", results / "..compiled.0123abcd.part"),
        results / "lengths/members/.batch_0.npz.0123abcd.part",
        results / "lengths/.study.nc.0123abcd.part",
    ]
    touch(paths)
    return [*paths, folder]


def touch(paths):
    for path in paths:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()


@pytest.mark.parametrize(("host", "freed"), [(socket.gethostname(), True), ("elsewhere", False)])
def test_a_lock_that_nobody_holds_is_freed(locked, host, freed):
    """A lock of another machine is kept: its state is not known."""
    (locked.parents[1] / "alive").write_text(host)
    os.close(begin(locked))
    assert locked.exists() != freed
    if not freed:
        locked.unlink()  # by `snakemake --unlock`
        begin(locked)
        assert (locked.parents[1] / "alive").read_text() == socket.gethostname()


def test_what_a_run_holds_and_writes_is_left(locked, other, unfinished):
    begin(locked)
    assert locked.exists()
    assert all(path.exists() for path in unfinished)


def test_what_a_killed_run_has_left_is_removed(locked, other, unfinished):
    results = locked.parents[2] / "results"
    kept = [
        *(results / "paper/growth/edge.nc", results / "paper/fig4.png", results / ".compiled"),
        # Of `cfmpm run` and `cfmpm study`, which may be running, and `cfmpm plot`.
        *(results / "paper" / name for name in (".started", ".paths.png.x1y_2z3a")),
        results / "stability/.history.nc.0123abcd.part",
        results / "lengths/members/.part.01.npz.0123abcd.part",
    ]
    touch(kept)
    other.kill()
    other.wait()
    begin(locked)
    assert not locked.exists()
    assert not any(path.exists() for path in unfinished)
    assert all(path.exists() for path in kept)


def test_what_is_in_a_folder_that_a_run_holds_is_left(locked, unfinished):
    results = locked.parents[2] / "results"
    with held(results / "lengths"):
        os.close(begin(locked))
    left = [path for path in unfinished if path.exists()]
    assert left == [path for path in unfinished if results / "lengths" in path.parents] != []
    os.close(begin(locked))
    assert not any(path.exists() for path in unfinished)


def test_snakemake_goes_on_after_a_kill_and_waits_for_none_that_runs(root, tmp_path, snakemake):
    """The whole sequence, on a workflow of one job that waits."""
    (tmp_path / "Snakefile").write_text(
        f"import sys; sys.path.insert(0, {str(root)!r})\n"
        "from pathlib import Path\n"
        "from workflows.execution.lock import clear_after_kill, remove_unfinished\n"
        "ALIVE = clear_after_kill(Path('.snakemake'))\n"
        "onstart: remove_unfinished(ALIVE, Path(), ['results/paper/fig4.nc'])\n"
        "rule wait:\n    output: 'done'\n"
        "    shell: 'touch begun; while [ ! -e go ]; do sleep 0.1; done; touch done'\n"
    )
    command = [sys.executable, "-m", "snakemake", "--cores", "1"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    first = subprocess.Popen(command, cwd=tmp_path, **quiet)
    try:
        while not (tmp_path / "begun").exists():
            assert first.poll() is None
        aside = tmp_path / "results/paper/.fig4.nc.0123abcd.part"
        touch([aside])
        refused = snakemake("--cores", "1", folder=tmp_path, check=False)
        assert "cannot be locked" in refused.stdout + refused.stderr
        snakemake("--dry-run", folder=tmp_path)
        assert list((tmp_path / ".snakemake" / "locks").iterdir())
        assert aside.exists()
    finally:
        first.kill()
        first.wait()
        (tmp_path / "go").touch()
    snakemake("--dry-run", "--rerun-incomplete", folder=tmp_path)
    assert aside.exists()
    snakemake("--cores", "1", "--rerun-incomplete", folder=tmp_path)
    assert (tmp_path / "done").exists()
    assert not aside.exists()
