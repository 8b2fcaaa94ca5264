"""Members on disk: what is written is read again, and nothing half is ever seen."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cfmpm.study import store
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
        # The attributes of a name are the same in all members.
        found[name] = (dims, values.reshape(shape), {"units": name})
    return found


@st.composite
def outcomes(draw):
    keys = draw(st.lists(st.text("0123abcd", min_size=8, max_size=8), unique=True, max_size=4))
    # As in a study: what a name means is the same in all members.
    dims: dict[str, tuple] = {}
    found = []
    for key in keys:
        own = {
            name: one
            for name, one in draw(quantities()).items()
            if dims.setdefault(name, one[0]) == one[0]
        }
        found.append(
            Outcome(
                key=key,
                reason=draw(TEXT),
                seconds=draw(st.floats(0, 1e6)),
                texts={"ending": draw(TEXT)},
                labels={"tip": draw(st.lists(TEXT, max_size=2)), "radius": [draw(NUMBERS)]},
                quantities=own,
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
    written.discard()
    assert Store(tmp_path / "members").read("ab") == {}


def test_what_the_machine_did_is_not_kept(tmp_path: Path) -> None:
    written = Store(tmp_path / "members")
    written.add(Outcome("a", reason="its process died", lasting=False))
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
