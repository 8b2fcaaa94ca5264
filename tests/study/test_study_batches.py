"""Batches of members as jobs of a workflow: results and refused input."""

from __future__ import annotations

from pathlib import Path

import pytest
import xarray as xr
from study_texts import STUDY, write_study

from cfmpm.errors import SceneError, SolveError
from cfmpm.output.run_folder import held
from cfmpm.study import batches as module
from cfmpm.study.batches import batch, batches, write_batch
from cfmpm.study.member import Outcome, solve
from cfmpm.study.reading import load_study
from cfmpm.study.store import Store, read_losses, read_part, write_part

KILLED = "its process was killed; not enough memory?"


def run_badly(members, outcomes, store, workers) -> None:
    """As `run_members`, but the first member is lost."""
    members = [one for one in members if one.key not in outcomes]
    for number, one in enumerate(members):
        lost = Outcome(one.key, "failed", KILLED, lasting=False)
        outcomes[one.key] = solve(one.job()) if number else lost
        store.add(outcomes[one.key])
    store.gather()


def test_batches_hold_every_member_once(tmp_path: Path) -> None:
    plan = load_study(write_study(tmp_path, STUDY.replace("[2, 4]", "[2, 3, 4]") + "batch: 4\n"))
    assert batches(plan) == [batch(plan, 0), batch(plan, 1)] == [range(4), range(4, 6)]
    with pytest.raises(IndexError):
        batch(plan, 2)


def test_the_last_attempt_writes_what_the_machine_lost(tmp_path: Path, monkeypatch) -> None:
    path = write_study(tmp_path, STUDY + "batch: 4\n")
    plan = load_study(path)
    assert batches(plan) == [range(4)]
    part = tmp_path / "results" / "members" / "batch_0.npz"
    monkeypatch.setattr(module, "run_members", run_badly)
    with pytest.raises(SolveError, match=f"1 of 4 members failed, the first: {KILLED[:20]}"):
        write_batch(path, range(4), 1, part, last=False)
    assert not part.exists()
    first = plan.members[0].key
    write_batch(path, range(4), 1, part, last=True)
    assert {one.key: one.lasting for one in read_part(part)} == {
        one.key: one.key != first for one in plan.members
    }
    assert read_losses(part) == 1
    dataset = tmp_path / "results" / "study.nc"
    module.write_study(path, [part], dataset)
    with xr.open_dataset(dataset) as found:
        assert found["status"].values.tolist() == [[1, 0], [0, 0]]
        assert str(found["reason"].values[0, 0]) == KILLED
    monkeypatch.undo()
    write_batch(path, range(4), 1, part, last=False)
    assert all(one.lasting for one in read_part(part))
    assert read_losses(part) == 1
    assert [one.name for one in part.parent.iterdir()] == [part.name]


def test_what_a_killed_batch_of_another_study_left_stays_known(tmp_path: Path) -> None:
    path = write_study(tmp_path, STUDY.replace("[2, 4]", "[2]"))
    part = tmp_path / "members" / "batch_0.npz"
    left = Store(part.parent, "batch_0")
    left.add(Outcome("of another"))
    left.flush()
    write_batch(path, range(2), 1, part, last=False)
    assert set(Store(part.parent).read(["of another"])) == {"of another"}
    assert [one.name for one in part.parent.iterdir()] == [part.name]


def test_no_dataset_of_members_that_no_batch_has(tmp_path: Path) -> None:
    path = write_study(tmp_path)
    part = tmp_path / "members" / "batch_0.npz"
    write_part([Outcome(one.key) for one in load_study(path).members[:3]], part)
    with pytest.raises(SolveError, match="1 of 4 members are in no batch"):
        module.write_study(path, [part], tmp_path / "study.nc")
    write_part([Outcome(one.key) for one in load_study(path).members], part)
    with held(tmp_path), pytest.raises(SceneError, match="another run is writing here"):
        module.write_study(path, [part], tmp_path / "study.nc")
    module.write_study(path, [part], tmp_path / "study.nc")
