from __future__ import annotations

import math

import numpy as np
import pytest

from cfmpm.fracture.ties import (
    BEHIND,
    LARGEST,
    UNKNOWN,
    Tie,
    first_tips,
    grid_error,
    growing_tips,
)

SIZES = {"a": 1.0, "b": 1.0, "c": 1.0}
ERROR = dict.fromkeys("abc", 0.01)


def ratios(a: float, b: float, c: float = 0.5) -> dict[str, float]:
    return {"a": a, "b": b, "c": c}


def test_error_of_the_grid_is_the_range_of_j_and_g():
    values = {
        "J_radius": np.array([[0.98, 1.0], [2.0, 2.0], [1.0, np.nan], [0.0, 0.0]]),
        "G_radius": np.array([[1.0, 1.0], [2.1, 2.1], [1.0, np.nan], [0.0, 0.0]]),
    }
    np.testing.assert_allclose(grid_error(values), [0.02, 0.1 / 2.1, UNKNOWN, UNKNOWN])
    values["J_radius"][0] = 0.0  # no error of the grid: J or G is wrong
    assert grid_error(values)[0] == LARGEST


def test_error_of_a_history_has_its_steps():
    one = np.array([[[1.0], [1.0]], [[2.0], [1.0]]])
    values = {"J_radius": one, "G_radius": 0.98 * one}
    np.testing.assert_allclose(grid_error(values), 0.02 * np.ones((2, 2)))


def test_tips_come_first_within_the_errors_of_both():
    assert first_tips(ratios(1.0, 0.985, 0.9), ERROR) == ["a", "b"]
    assert first_tips(ratios(1.0, 0.975, 0.9), ERROR) == ["a"]
    assert first_tips(ratios(0.0, 0.0, 0.0), ERROR) == []


def test_a_tie_begins_and_ends():
    first, names, ties = growing_tips(ratios(1.0, 0.99), ERROR, SIZES)
    assert first == names == ["a", "b"]
    assert ties[0].compared == 1
    first, names, ties = growing_tips(ratios(1.0, 0.9), ERROR, SIZES, ties, {"a": 0.8, "b": 0.8})
    assert first == names == ["a"]
    assert ties == ()


def test_one_bad_grid_does_not_end_a_tie_but_a_difference_that_stays_does():
    """The error of the grid alternates; 5 % once in six steps does not end the tie."""
    ties: tuple[Tie, ...] = ()
    released: dict[str, float] = {}
    for other in (0.99, 1.01, 0.99, 1.01, 0.99, 0.95):
        first, _, ties = growing_tips(ratios(1.0, other), ERROR, SIZES, ties, released)
        assert first == ["a", "b"]
        released = {"a": 0.7, "b": 0.7}
    steps = 0
    while len(first) == 2:
        first, _, ties = growing_tips(ratios(1.0, 0.95), ERROR, SIZES, ties, released)
        steps += 1
    assert first == ["a"]
    assert steps <= 6


def test_unequal_segments_are_made_up_before_ratios_are_compared():
    """A longer crack has a larger driving force."""
    before = growing_tips(ratios(1.0, 0.99), ERROR, SIZES)[2]
    first, names, ties = growing_tips(ratios(1.0, 0.8), ERROR, SIZES, before, {"a": 1.0, "b": 0.6})
    assert first == names == ["a", "b"]
    assert ties[0].compared == 1
    wanted = ties[0].wanted(names, {"a": 0.7, "b": 0.9})
    for lengths in wanted:
        assert lengths["b"] - lengths["a"] == pytest.approx(0.4)
    assert lengths_mean(wanted[0]) == pytest.approx(0.8)
    first, names, _ = growing_tips(ratios(1.0, 0.8), ERROR, SIZES, before, {"a": 1.0, "b": 0.3})
    assert first == ["a", "b"]
    assert names == ["b"]
    late = Tie({"a": 1.0, "b": 0.3})
    assert late.late(SIZES) == ["b"]
    assert late.wanted(["b"], {"b": 0.9}) == [{"b": pytest.approx(0.7)}]
    assert Tie({"a": 1.0, "b": 1.0 - 0.9 * BEHIND}).late(SIZES) == []


def lengths_mean(lengths: dict[str, float]) -> float:
    return math.fsum(lengths.values()) / len(lengths)


def test_ties_without_the_first_tip_are_kept():
    pair = Tie({"a": 1.0, "b": 1.0}, {"a": 0.0, "b": 0.0}, {"a": 0.01, "b": 0.01}, 1)
    first, names, ties = growing_tips(ratios(0.5, 0.5, 1.0), ERROR, SIZES, [pair])
    assert first == names == ["c"]
    assert [set(tie.grown) for tie in ties] == [{"a", "b"}]


def test_a_tie_ends_with_the_arrival_or_the_closure_of_a_tip():
    pair = [Tie({"a": 1.0, "b": 0.2})]
    here = {"a": 1.0, "c": 0.5}
    assert growing_tips(here, ERROR, SIZES, pair)[0::2] == (["a"], ())
    assert growing_tips(ratios(1.0, 0.0), ERROR, SIZES, pair)[0::2] == (["a"], ())
