"""Decisions under fatigue: which tips advance, when fracture occurs, cycles per segment."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from structured import rectangle

from cfmpm.body.grid import CrackTip, Floats, build_grid
from cfmpm.ending import RunEnded
from cfmpm.fracture import fatigue, growth
from cfmpm.fracture.fatigue import Progress
from cfmpm.fracture.growth import Decision
from cfmpm.scene.growth import Fatigue, Growth

GRID = build_grid(rectangle(8, 6, crack=(3, 2, 5)), "T3")
START, END = "crack_1_start", "crack_1_end"
LENGTHS = {"crack_1": 0.3}  # as its specimen counts it: less than its line, 3 / 8
LAW = Fatigue(C=1e-3, m=2.0, threshold=0.5)
CONFIG = Growth(control="fatigue", order=1)
SLOW, FAST = {"a": 1e-3, "b": 5e-4}, {"a": 1.0, "b": 0.5}


def values(k_1: Any, k_2: Any = (0.0, 0.0), g: Any = (0.1, 0.1)) -> dict[str, Floats]:
    names = {"G": g, "cf_norm": g, "K_I": k_1, "K_II": k_2}
    return {name: np.array(value, float) for name, value in names.items()}


def decide(
    found: dict[str, Floats], last: Progress | None = None, g_c: float = 1.0, **more: Any
) -> Decision:
    before = None if last is None else Decision(1.0, {}, {}, last)
    return growth.decide(GRID, found, np.array([g_c]), CONFIG, before, law=LAW, **more)


def progress(**changes: Any) -> Progress:
    both = dict.fromkeys((START, END), 1.0)
    plain = Progress(100.0, both, dict.fromkeys(both, 0.001), {}, START, {})
    return replace(plain, **changes)


class TestDecisions:
    def test_of_two_tips_the_faster_one_leads(self) -> None:
        found = decide(values((1.0, 3.0)))
        assert set(found.running) == {END}
        assert found.load_factor == 1.0
        assert found.progress is not None
        assert found.progress.ranges == {START: 1.0, END: 3.0}
        assert found.progress.rates == pytest.approx({START: 1e-3, END: 9e-3})
        assert found.progress.leader == END

    def test_a_tip_at_its_toughness_ends_it(self) -> None:
        """No tip advances by fatigue once one has reached g_c."""
        for g, runs in ((0.999, True), (1.0, False), (7.0, False)):
            found = decide(values((1.0, 3.0), g=(g, 0.1)))
            assert bool(found.running) == runs
            assert found.progress is not None
            assert found.progress.driving == pytest.approx({START: g, END: 0.1})
            assert found.progress.leader == (END if runs else "")

    def test_on_a_border_the_range_with_which_it_came_goes_on(self) -> None:
        """There is no K at an interface of two materials: the last range is kept."""
        last = progress(ranges={START: 1.0, END: 2.0})
        found = decide(values((1.0, np.nan), (0.0, np.nan)), last, unresolved={END})
        assert found.progress is not None
        assert found.progress.ranges == {START: 1.0, END: 2.0}
        assert set(found.running) == {END}
        new = decide(values((1.0, np.nan), (0.0, np.nan)), unresolved={END})
        assert new.progress is not None
        assert new.progress.ranges[END] == 0.0

    def test_a_closed_tip_does_not_grow_though_it_is_sheared(self) -> None:
        found = decide(values((1.0, -5.0), (0.0, 4.0)))
        assert found.progress is not None
        assert found.progress.ranges[END] == 0.0
        assert found.progress.rates[END] == 0.0
        assert set(found.running) == {START}

    def test_a_tip_that_opens_by_shear_counts_its_shear_alone(self) -> None:
        found = decide(values((1.0, -3.0), (0.0, 4.0)))
        assert found.progress is not None
        assert found.progress.ranges[END] == pytest.approx(4.0)

    def test_cycles_are_those_of_the_segment_that_led(self) -> None:
        """A segment of 0.2 mm, from a rate of 1e-3 to one of 4e-3: mean of 1 / rate 625."""
        found = decide(values((2.0, 1.0)), progress(), grown={START: 0.2})
        assert found.progress is not None
        assert found.progress.cycles == pytest.approx(100.0 + 0.2 * 625.0)
        assert found.progress.pending == pytest.approx({START: 0.0, END: 1e-3 * 125.0})


class TestFracture:
    """The length at which a tip reaches g_c is interpolated linearly between two steps."""

    def end_of(self, now: Progress, last: Progress | None, **grown: float) -> RunEnded:
        decision = Decision(1.0, {}, {}, now)
        before = None if last is None else Decision(1.0, {}, {}, last)
        with pytest.raises(RunEnded) as ended:
            growth.check_end(
                CONFIG, decision, GRID.tips, 5, last=before, grown=grown, lengths=LENGTHS
            )
        return ended.value

    def test_a_quarter_of_the_way_back(self) -> None:
        """G / g_c rises from 0.7 to 1.1 in 40 cycles and 0.125 mm; a quarter is beyond fracture."""
        now = progress(cycles=140.0, driving={START: 1.1, END: 0.8})
        last = progress(driving={START: 0.7, END: 0.1})
        end = self.end_of(now, last, **{START: 0.125, END: 0.5})
        assert end.ending.status == "fractured"
        assert end.ending.values == pytest.approx(
            {"cycles_to_fracture": 130.0, "critical_crack_length": 0.3 - 0.125 / 4}
        )
        assert end.ending.text.startswith(f"fractured: {START} reaches g_c at a crack length of")

    def test_the_tip_that_is_furthest_beyond_it_breaks(self) -> None:
        """A tip without g_c does not count."""
        last = progress(driving={START: 0.5, END: 0.5})
        for start in (1.2, np.nan):
            now = progress(cycles=200.0, driving={START: start, END: 1.5})
            end = self.end_of(now, last)
            assert END in end.ending.text
            assert end.ending.values["cycles_to_fracture"] == pytest.approx(150.0)

    def test_without_one_the_tips_have_arrested(self) -> None:
        for driving in (0.999, np.nan):
            now = progress(driving={START: driving, END: 0.5})
            assert self.end_of(now, progress()).ending.status == "arrested"


def tip(name: str) -> CrackTip:
    return next(tip for tip in GRID.tips if tip.name == name)


def test_the_segments_that_are_due_are_those_of_the_grid_at_each_tip() -> None:
    """A tip ahead of Paris' law (negative pending advance) does not release a segment."""
    last = progress(pending={START: -3.0 * tip(START).h})
    found = decide(values((1.0, 1.0)), last, grown={})
    assert set(found.running) == {END}


class TestCount:
    """The number of cycles of a step is that of the leading tip's segment."""

    def at(self, **changes: Any) -> Progress:
        return replace(Progress(10.0, {}, SLOW, {}, "a", {}), **changes)

    def test_what_the_leader_owed_has_been_paid_before(self) -> None:
        cycles, pending = fatigue.count(self.at(pending={"a": 0.05}), {"a": 0.2}, SLOW)
        assert cycles == pytest.approx(10.0 + 0.15 / 1e-3)
        assert pending == pytest.approx({"a": 0.0, "b": 0.15 / 1e-3 * 5e-4})

    def test_a_segment_shorter_than_what_was_owed_takes_no_cycles_back(self) -> None:
        cycles, pending = fatigue.count(self.at(pending={"a": 0.3}), {"a": 0.2}, SLOW)
        assert cycles == 10.0
        assert pending == pytest.approx({"a": 0.1, "b": 0.0})

    def test_where_the_leader_was_run_into_the_first_that_ran_tells(self) -> None:
        cycles, _ = fatigue.count(self.at(), {"b": 0.2}, SLOW)
        assert cycles == pytest.approx(10.0 + 0.2 / 5e-4)

    def test_the_leader_tells_whatever_else_ran(self) -> None:
        cycles, pending = fatigue.count(self.at(), {"b": 0.2, "a": 0.2}, SLOW)
        assert cycles == pytest.approx(10.0 + 0.2 / 1e-3)
        assert pending == pytest.approx({"a": 0.0, "b": -0.1})

    def test_a_tip_that_arrests_had_half_its_rate(self) -> None:
        cycles, pending = fatigue.count(self.at(), {"a": 0.2}, {"a": 0.0, "b": 0.0})
        assert cycles == pytest.approx(10.0 + 0.2 / 5e-4)
        assert pending == pytest.approx({"a": 0.0, "b": 0.1})


class TestDue:
    @pytest.mark.parametrize(("pending", "both"), [(-0.01, False), (0.0, True), (0.01, True)])
    def test_half_a_segment_is_near_enough(self, pending: float, both: bool) -> None:
        """When the leading tip has its segment of 2 mm, the other has 1 mm and its remainder."""
        leader, names = fatigue.select_tips({"b": pending}, FAST, {"a": 2.0, "b": 2.0})
        assert leader == "a"
        assert names == (["a", "b"] if both else ["a"])

    def test_what_is_overdue_is_due_at_once(self) -> None:
        """The other tips do not advance further by this."""
        leader, names = fatigue.select_tips({"a": 4.0, "b": 1.1}, FAST, {"a": 2.0, "b": 2.0})
        assert (leader, names) == ("a", ["a", "b"])
