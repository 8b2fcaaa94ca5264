"""Members on disk: written data are read back, partial files are never read."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cfmpm.study import layout, store
from cfmpm.study.member import Outcome
from cfmpm.study.store import Store, read_part, write_part

TEXT = st.text('aä"\\\n ', max_size=8)
NUMBERS = st.floats(allow_nan=False)


@st.composite
def quantities(draw):
    sizes = {dim: draw(st.integers(0, 3)) for dim in ("step", "tip")}
    found = {}
    for name in draw(st.lists(st.sampled_from("abcd"), unique=True)):
        dims = draw(st.sampled_from([("step",), ("step", "tip"), ("tip",)]))
        shape = tuple(sizes[dim] for dim in dims)
        count = int(np.prod(shape))
        values = np.array(draw(st.lists(NUMBERS, min_size=count, max_size=count)), float)
        found[name] = (dims, values.reshape(shape), {"units": draw(st.sampled_from("xy"))})
    return found


@st.composite
def outcomes(draw):
    keys = draw(st.lists(st.text("0123abcd", min_size=8, max_size=8), unique=True, max_size=4))
    found = []
    for key in keys:
        found.append(
            Outcome(
                key=key,
                status=draw(st.sampled_from(layout.STATUS)),
                reason=draw(TEXT),
                seconds=draw(st.floats(0, 1e6)),
                lasting=draw(st.booleans()),
                texts={"ending": draw(TEXT)},
                labels={"tip": draw(st.lists(TEXT, max_size=2)), "radius": [draw(NUMBERS)]},
                quantities=draw(quantities()),
            )
        )
    return found


def assert_same(one: Outcome, other: Outcome) -> None:
    for name in ("key", "reason", "seconds", "lasting", "texts", "labels", "status"):
        assert getattr(one, name) == getattr(other, name)
    assert list(one.quantities) == list(other.quantities)
    for name, (dims, values, attributes) in one.quantities.items():
        assert other.quantities[name][0] == dims
        assert other.quantities[name][2] == attributes
        assert other.quantities[name][1].dtype == values.dtype
        assert other.quantities[name][1].tobytes() == values.tobytes()


@given(outcomes())
def test_what_is_written_is_read(found) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "part.npz"
        write_part(found, path)
        read = read_part(path)
        assert len(read) == len(found)
        for one, other in zip(found, read, strict=True):
            assert_same(one, other)
        some = {one.key for one in found[::2]}
        assert {one.key for one in read_part(path, some)} == some
        assert [file.name for file in Path(folder).iterdir()] == ["part.npz"]


def some(*keys: str) -> list[Outcome]:
    numbers = {"a": (("step",), np.arange(3.0), {"units": "mm"})}
    return [Outcome(key, quantities=numbers) for key in keys]


def test_whole_numbers_stay_so(tmp_path: Path) -> None:
    flags = (("step",), np.array([0, 3], np.int8), {"flag_values": np.arange(4, dtype=np.int8)})
    write_part([Outcome("k", quantities={"flags": flags})], tmp_path / "part.npz")
    (one,) = read_part(tmp_path / "part.npz")
    assert one.quantities["flags"][1].dtype == np.int8
    assert one.quantities["flags"][2] == {"flag_values": [0, 1, 2, 3]}


def test_a_store_has_few_files(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(store, "INTERVAL", 0.0)
    monkeypatch.setattr(store, "MOST_PARTS", 5)
    keys = [f"k{i}" for i in range(23)]
    written = Store(tmp_path / "members")
    for one in some(*keys):
        written.add(one)
        assert len(list((tmp_path / "members").iterdir())) <= 5
    assert set(Store(tmp_path / "members").read(keys)) == set(keys)
    written.gather()
    assert len(list((tmp_path / "members").iterdir())) == 1
    assert set(Store(tmp_path / "members").read(keys)) == set(keys)
    assert set(Store(tmp_path / "members").read(["k3", "none"])) == {"k3"}


def test_little_is_written_within_the_interval(tmp_path: Path) -> None:
    written = Store(tmp_path / "members")
    for one in some("a", "b"):
        written.add(one)
    assert not (tmp_path / "members").exists()
    written.flush()
    assert set(Store(tmp_path / "members").read("ab")) == set("ab")


def test_what_the_machine_did_is_not_kept(tmp_path: Path) -> None:
    written = Store(tmp_path / "members")
    written.add(Outcome("a", "failed", "its process died", lasting=False))
    written.gather()
    assert not (tmp_path / "members").exists()


@pytest.mark.parametrize("damage", ["cut", "empty", "text", "format"])
def test_a_damaged_part_holds_nothing(damage, tmp_path: Path, monkeypatch) -> None:
    path = tmp_path / "members" / "part_1.npz"
    if damage == "format":
        monkeypatch.setattr(store, "FORMAT", store.FORMAT + 1)
    write_part(some("a"), path)
    monkeypatch.undo()
    if damage == "cut":
        path.write_bytes(path.read_bytes()[:-30])
    if damage == "empty":
        path.write_bytes(b"")
    if damage == "text":
        path.write_text("not a part")
    write_part(some("b"), path.with_name("part_2.npz"))
    assert set(Store(path.parent).read("ab")) == {"b"}


def test_a_part_that_another_run_takes_away_meanwhile(tmp_path: Path, monkeypatch) -> None:
    folder = tmp_path / "members"
    write_part(some("a"), folder / "part_1.npz")
    write_part(some("b"), folder / "part_2.npz")
    real = store.read_part

    def taken(path: Path, keys):
        if path.name == "part_1.npz":
            path.unlink()
        return real(path, keys)

    monkeypatch.setattr(store, "read_part", taken)
    assert set(Store(folder).read("ab")) == {"b"}


def filled(folder: Path, owner: str, keys: str) -> None:
    """A store with a part for each key, as a kill leaves it."""
    for key in keys:
        own = Store(folder, owner)
        own.add(*some(key))
        own.flush()


def test_no_store_takes_away_parts_of_another(tmp_path: Path) -> None:
    ours, theirs = Store(tmp_path, "batch_1"), Store(tmp_path, "batch_11")
    for owned, key in ((ours, "a"), (theirs, "b")):
        for one in some(key, "c"):
            owned.add(one)
            owned.flush()
    ours.gather()
    assert len(ours.parts()) == 1
    assert len(theirs.parts()) == 2
    assert set(Store(tmp_path).read("abc")) == {"a", "b", "c"}
    # Two parts of the same members have different names.
    for _ in range(2):
        theirs.add(*some("b"))
        theirs.flush()
    assert len(theirs.parts()) == 4


def test_what_a_kill_left_is_made_one_part(tmp_path: Path) -> None:
    filled(tmp_path, "part", "abc")
    (tmp_path / ".part.0123456789abcdef.npz.89abcdef.part").write_text("half")
    (tmp_path / ".batch_0.npz.89abcdef.part").write_text("of another")
    Store(tmp_path).tidy()
    names = [path.name for path in tmp_path.iterdir()]
    assert len(names) == 2
    assert ".batch_0.npz.89abcdef.part" in names
    assert set(Store(tmp_path).read("abc")) == set("abc")


@pytest.mark.parametrize("at", ["reading", "writing"])
def test_a_failure_while_parts_are_gathered_loses_none(at, tmp_path: Path, monkeypatch) -> None:
    filled(tmp_path, "part", "abc")
    real = store.read_part

    def failing(*arguments):
        raise OSError("no answer from the disk")

    monkeypatch.setattr(store, "read_part" if at == "reading" else "write_part", failing)
    with pytest.raises(OSError, match="no answer"):
        Store(tmp_path).gather()
    # The file that is made of all is read again, before any goes: here half of it is lost.
    monkeypatch.undo()
    calls = []

    def forgetful(path: Path, keys=None):
        calls.append(path)
        return real(path, keys)[: 1 if len(calls) > 3 else None]

    monkeypatch.setattr(store, "read_part", forgetful)
    Store(tmp_path).gather()
    monkeypatch.undo()
    assert set(Store(tmp_path).read("abc")) == set("abc")


def test_a_damaged_part_stays_when_others_are_made_one(tmp_path: Path) -> None:
    filled(tmp_path, "part", "ab")
    damaged = tmp_path / "part.damaged.npz"
    damaged.write_text("not a part")
    Store(tmp_path).gather()
    assert damaged.exists()
    assert len(Store(tmp_path).parts()) == 2


def test_members_that_the_machine_lost_are_not_known(tmp_path: Path) -> None:
    lost = Outcome("a", "failed", "its process was killed", lasting=False)
    write_part([lost, *some("b")], tmp_path / "batch_0.npz", losses=2)
    assert set(Store(tmp_path).read("ab")) == {"b"}
    assert {one.key for one in read_part(tmp_path / "batch_0.npz")} == {"a", "b"}
    assert store.read_losses(tmp_path / "batch_0.npz") == 2
    assert store.read_losses(tmp_path / "batch_1.npz") == 0
