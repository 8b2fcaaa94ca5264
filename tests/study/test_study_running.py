"""Members in worker processes: equal results for any number of workers, no lost member."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from study_texts import FAILING, GROWING, STUDY, without_times, write_study

from cfmpm import simulation
from cfmpm.errors import MeshError, Problem, SceneError, SolveError
from cfmpm.study import running
from cfmpm.study.collecting import collect
from cfmpm.study.member import Outcome, solve
from cfmpm.study.reading import Plan, load_study
from cfmpm.study.running import run_members
from cfmpm.study.store import DATASET, MEMBERS, Store, read_part

ONE = "name: one\nbase: small.yaml\nzip: {E: {key: material.E, values: [1e5]}}\n"
# Hencky's law loses ellipticity on the way to this elongation.
TORN = """\
name: torn
base: small.yaml
replace:
  kinematics: finite
  load_steps: 4
  family.traction: 60e3
zip: {E: {key: material.E, values: [1e5]}}
"""
LONG = """\
name: long
base: small.yaml
replace: {mesh.element: T6, mesh.size: 0.3}
zip:
  E: {key: material.E, linspace: [100e3, 200e3, 12]}
"""


def ran(plan: Plan, folder: Path, workers: int = 1) -> tuple[dict[str, Outcome], list[str]]:
    """All outcomes, and the keys of those that were solved."""
    store = Store(folder)
    outcomes = store.read({one.key for one in plan.members})
    new: list[str] = []
    run_members(plan.members, outcomes, store, workers, lambda one: new.append(one.key))
    return outcomes, new


def test_one_and_two_processes_give_the_same_bits(tmp_path: Path) -> None:
    text = STUDY.replace("values: [2, 4]", "linspace: [2, 6, 4]")
    plan = load_study(write_study(tmp_path, text))
    one, two = (
        collect(plan, ran(plan, tmp_path / str(workers), workers)[0]).drop_vars(
            ["run_time", "cpu_time"]
        )
        for workers in (1, 2)
    )
    for name, variable in one.variables.items():
        assert variable.dtype == two[name].dtype
        if variable.dtype == object:
            assert (variable.values == two[name].values).all()
        else:
            assert variable.values.tobytes() == two[name].values.tobytes()
    # And those of the scene alone.
    member = plan.members[3]
    alone = solve(member.job())
    at = dict(zip((axis.name for axis in plan.axes), member.index, strict=True))
    assert one["G"].isel(at).values == alone.quantities["G"][1][0]


def test_what_is_known_is_not_solved_again(tmp_path: Path) -> None:
    plan = load_study(write_study(tmp_path))
    first, new = ran(plan, tmp_path / "m")
    assert set(new) == set(first) == {one.key for one in plan.members}
    again, new = ran(plan, tmp_path / "m", 2)
    assert new == []
    assert {one.key: one.seconds for one in again.values()} == {
        one.key: one.seconds for one in first.values()
    }
    # One value changed: the members of that value and no other.
    other = load_study(write_study(tmp_path, STUDY.replace("[2, 4]", "[2, 3]")))
    _, new = ran(other, tmp_path / "m")
    assert set(new) == {one.key for one in other.members if one.values["length"] == 3}
    # And back again.
    assert ran(plan, tmp_path / "m")[1] == []


def test_members_of_one_scene_are_solved_once(tmp_path: Path) -> None:
    text = ONE.replace("[1e5]", "[1e5, 1e5, 100000]")
    plan = load_study(write_study(tmp_path, text))
    outcomes, new = ran(plan, tmp_path / "m")
    assert len(plan.members) == 3
    assert len(outcomes) == len(new) == 1


def test_a_failed_member_keeps_its_reason(tmp_path: Path) -> None:
    plan = load_study(write_study(tmp_path, FAILING))
    outcomes, _ = ran(plan, tmp_path / "m")
    for one in plan.members:
        outcome = outcomes[one.key]
        if one.values["pull"] == 5:
            assert outcome.status == "done"
        else:
            assert outcome.status == "failed"
            assert "the loads are out of balance" in outcome.reason
            assert outcome.lasting
    # The scene is to blame: another time would end as this one did.
    assert ran(plan, tmp_path / "m")[1] == []


@pytest.mark.parametrize(
    ("error", "reason", "lasting"),
    [
        (SolveError("no balance"), "no balance", True),
        (MeshError("no grid"), "no grid", True),
        (SceneError([Problem("wrong")]), "wrong", True),
        (MemoryError(), "not enough memory; use a larger mesh.size, or solver: amg", False),
        (OSError(28, "No space left"), "OSError: [Errno 28] No space left", False),
        (ZeroDivisionError("by zero"), "ZeroDivisionError: by zero", False),
    ],
)
def test_what_fails_by_the_scene_lasts(error, reason, lasting, tmp_path: Path, monkeypatch) -> None:
    (member,) = load_study(write_study(tmp_path, ONE)).members

    def fault(*arguments, **keywords):
        raise error

    monkeypatch.setattr("cfmpm.simulation.run", fault)
    outcome = solve(member.job())
    assert (outcome.status, outcome.reason, outcome.lasting) == ("failed", reason, lasting)


@pytest.mark.parametrize("word", ["unstable", "unsolvable"])
def test_a_member_that_loses_stability_is_not_done(word, tmp_path: Path, monkeypatch) -> None:
    (member,) = load_study(write_study(tmp_path, ONE)).members
    real = simulation.run

    def unstable(*arguments, **keywords):
        found = real(*arguments, **keywords)
        found.history.attrs |= {"run_status": word, "ending": "no stable state"}
        return found

    monkeypatch.setattr(simulation, "run", unstable)
    outcome = solve(member.job())
    assert (outcome.status, outcome.reason) == ("unstable", "no stable state")
    assert outcome.lasting
    assert outcome.quantities["G"][1].shape == (1, 1)


def test_the_end_of_a_run_that_loses_stability(tmp_path: Path) -> None:
    (member,) = load_study(write_study(tmp_path, TORN)).members
    outcome = solve(member.job())
    assert outcome.status == "unstable"
    assert outcome.reason == outcome.texts["ending"]
    assert len(outcome.quantities["G"][1]) >= 1


def test_steps_before_a_failure_are_kept(tmp_path: Path, monkeypatch) -> None:
    from cfmpm.errors import SolveError
    from cfmpm.fracture import growing

    real, calls = growing.release, []

    def failing(*arguments):
        calls.append(1)
        if len(calls) == 3:
            raise SolveError("no balance")
        return real(*arguments)

    monkeypatch.setattr(growing, "release", failing)
    member = load_study(write_study(tmp_path, GROWING)).members[1]
    outcome = solve(member.job())
    assert outcome.reason == "no balance"
    assert outcome.quantities["G"][1].shape == (3, 1)
    assert outcome.texts["ending"] == "failed: no balance"


def killed(count: int) -> threading.Thread:
    """Kill a given number of worker processes after their start."""

    def kill() -> None:
        seen: set[int] = set()
        while len(seen) < count:
            for child in multiprocessing.active_children():
                if child.pid not in seen and len(seen) < count:
                    seen.add(child.pid)
                    os.kill(child.pid, signal.SIGKILL)
            time.sleep(0.01)

    thread = threading.Thread(target=kill, daemon=True)
    thread.start()
    return thread


def test_members_of_a_process_that_died_are_tried_again(tmp_path: Path) -> None:
    plan = load_study(write_study(tmp_path))
    killer = killed(1)
    outcomes, new = ran(plan, tmp_path / "m", 2)
    killer.join()
    assert len(new) == len(plan.members)
    assert all(one.status == "done" for one in outcomes.values())


def test_a_member_whose_process_dies_twice_is_marked_and_tried_another_time(
    tmp_path: Path,
) -> None:
    plan = load_study(write_study(tmp_path, ONE))
    killer = killed(2)
    outcomes, _ = ran(plan, tmp_path / "m")
    killer.join()
    (outcome,) = outcomes.values()
    assert outcome.reason == "its process was killed; not enough memory?"
    dataset = collect(plan, outcomes)
    assert dataset["status"].values.tolist() == [1]
    assert dataset["reason"].values.tolist() == [outcome.reason]
    outcomes, new = ran(plan, tmp_path / "m")
    assert len(new) == 1
    assert collect(plan, outcomes)["status"].values.tolist() == [0]


def test_processes_that_cannot_start_end_the_study_at_once(tmp_path: Path, monkeypatch) -> None:
    plan = load_study(write_study(tmp_path))
    (tmp_path / "gmsh.py").write_text("raise ImportError('no such library')")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(SolveError, match=r"can be started: its process ended with status 1$"):
        ran(plan, tmp_path / "m")


def test_one_thread_each_and_the_environment_as_it_was(monkeypatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    with running._one_thread():
        assert os.environ["OMP_NUM_THREADS"] == os.environ["MKL_NUM_THREADS"] == "1"
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert "MKL_NUM_THREADS" not in os.environ


START = """
import signal, sys
from cfmpm.study import store
store.INTERVAL = 0.0
# What runs in the background of a shell would ignore it.
signal.signal(signal.SIGINT, signal.default_int_handler)
from cfmpm.cli import app
app(["study", *sys.argv[1:]])
"""


def started(path: Path, folder: Path, workers: int) -> subprocess.Popen:
    # In a group of its own, so that what is left of it can be looked for.
    return subprocess.Popen(
        [sys.executable, "-c", START, str(path), "--output", str(folder), f"--workers={workers}"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def alive(group: int) -> bool:
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def stopped(path: Path, folder: Path, stop: signal.Signals) -> tuple[int, set[str]]:
    """Stop a study when the first member is on disk: exit status, and the members kept."""
    run = started(path, folder, 2)
    while not list((folder / MEMBERS).glob("*.npz")):
        assert run.poll() is None, run.communicate()
        time.sleep(0.01)
    if stop == signal.SIGINT:  # Ctrl-C goes to all processes of a terminal
        os.killpg(run.pid, stop)
    else:
        os.kill(run.pid, stop)
    run.communicate(timeout=120)
    assert not (folder / DATASET).exists()
    deadline = time.monotonic() + 60.0
    while alive(run.pid):  # the processes of the pool end with the one that made them
        assert time.monotonic() < deadline
        time.sleep(0.05)
    kept = {one.key for part in (folder / MEMBERS).glob("*.npz") for one in read_part(part)}
    assert 0 < len(kept) < 12
    return run.returncode, kept


@pytest.mark.slow
def test_killed_and_started_again(tmp_path: Path) -> None:
    path = write_study(tmp_path, LONG)
    status, kept = stopped(path, tmp_path / "killed", signal.SIGKILL)
    assert status == -signal.SIGKILL
    run = started(path, tmp_path / "killed", 2)
    said, _ = run.communicate()
    assert run.returncode == 0
    assert f"12 done, {len(kept)} of them known from before" in said
    started(path, tmp_path / "whole", 1).communicate()
    first, second = (without_times(tmp_path / name / DATASET) for name in ("killed", "whole"))
    assert first.identical(second)


@pytest.mark.slow
@pytest.mark.parametrize("stop", [signal.SIGTERM, signal.SIGINT])
def test_stopped(stop, tmp_path: Path) -> None:
    status, _ = stopped(write_study(tmp_path, LONG), tmp_path / "stopped", stop)
    assert status == 128 + stop
