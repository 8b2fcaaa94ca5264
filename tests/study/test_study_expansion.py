"""Members of a study: number, order, values."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from cfmpm.study import expansion
from cfmpm.study.model import Study

NUMBERS = st.lists(st.integers(-1000, 1000), min_size=1, max_size=4, unique=True)


def study(**sections) -> Study:
    return Study.model_validate({"name": "any", "base": "scene.yaml", **sections})


def listed(columns: dict[str, list]) -> dict:
    return {name: {"key": f"a.{name}", "values": column} for name, column in columns.items()}


@given(st.dictionaries(st.sampled_from("abcd"), NUMBERS, min_size=1))
def test_product_is_that_of_sets_with_the_last_running_fastest(columns) -> None:
    axes = expansion.axes(study(product=listed(columns)))
    assert [axis.name for axis in axes] == list(columns)
    found = list(expansion.places(axes))
    assert len(found) == expansion.count(axes) == math.prod(map(len, columns.values()))
    # Nested loops, written out as one.
    for number, index in enumerate(found):
        rest = number
        for k, name in reversed(list(enumerate(columns))):
            rest, i = divmod(rest, len(columns[name]))
            assert index[k] == i
            assert axes[k].values[name][i] == columns[name][i]


@given(st.integers(1, 5), st.integers(1, 4), NUMBERS)
def test_zip_goes_side_by_side_along_one_axis(length, width, crossed) -> None:
    columns = {f"z{k}": [(k, i) for i in range(length)] for k in range(width)}
    axes = expansion.axes(study(product=listed({"p": crossed}), zip=listed(columns)))
    assert [axis.name for axis in axes] == ["p", "sample"]
    assert expansion.count(axes) == len(crossed) * length
    for _, i in expansion.places(axes):
        assert all(axes[1].values[name][i] == (k, i) for k, name in enumerate(columns))


@given(NUMBERS, st.data())
def test_a_part_of_the_members_is_that_part(column, data) -> None:
    axes = expansion.axes(study(product=listed({"a": column, "b": [1, 2, 3]})))
    count = expansion.count(axes)
    first = data.draw(st.integers(0, count))
    last = data.draw(st.integers(first, count))
    part = list(expansion.places(axes, range(first, last)))
    assert part == list(expansion.places(axes))[first:last]


@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6), st.integers(1, 50))
def test_linspace(first, last, count) -> None:
    (axis,) = expansion.axes(study(zip={"a": {"key": "k", "linspace": [first, last, count]}}))
    values = axis.values["a"]
    assert len(values) == count
    assert values[0] == first
    if count > 1:
        assert values[-1] == last
        assert np.diff(values) == pytest.approx((last - first) / (count - 1), abs=1e-9)


@given(st.floats(1e-6, 1e6), st.floats(1e-6, 1e6), st.integers(2, 50))
def test_geomspace(first, last, count) -> None:
    (axis,) = expansion.axes(study(zip={"a": {"key": "k", "geomspace": [first, last, count]}}))
    values = np.array(axis.values["a"])
    assert (values[0], values[-1]) == (first, last)
    assert values[1:] / values[:-1] == pytest.approx((last / first) ** (1 / (count - 1)))


@given(st.integers(1, 60), st.integers(0, 2**32), st.integers(1, 3))
def test_latin_hypercube_has_one_draw_of_each_probability(samples, seed, width) -> None:
    kinds = [("norm", {"loc": 5, "scale": 2}), ("lognorm", {"s": 0.3}), ("uniform", {})][:width]
    uncertain = {
        name: {"key": f"k.{name}", "distribution": name, "arguments": arguments}
        for name, arguments in kinds
    }
    cube = {"samples": samples, "seed": seed, "parameters": uncertain}
    (axis,) = expansion.axes(study(latin_hypercube=cube))
    assert axis.name == "sample"
    for name, arguments in kinds:
        probability = getattr(stats, name)(**arguments).cdf(axis.values[name])
        assert sorted(np.floor(probability * samples - 1e-9 * (probability * samples))) == list(
            range(samples)
        )
    assert expansion.axes(study(latin_hypercube=cube)) == (axis,)


def test_another_seed_gives_other_draws() -> None:
    def draws(seed: int) -> list[float]:
        cube = {
            "samples": 5,
            "seed": seed,
            "parameters": {"a": {"key": "k", "distribution": "norm"}},
        }
        return expansion.axes(study(latin_hypercube=cube))[0].values["a"]

    assert draws(0) == draws(0) != draws(1)


def test_values_have_names_or_are_their_own() -> None:
    def labels(values) -> list:
        return expansion.axes(study(zip={"a": {"key": "k", "values": values}}))[0].labels["a"]

    assert labels([1, 2.5]) == [1, 2.5]
    assert labels(["T3", "T6"]) == ["T3", "T6"]
    assert labels([1, "auto", True, [3]]) == ["1", "auto", "true", "[3]"]
    assert labels({"coarse": {"size": 3}, "fine": 1}) == ["coarse", "fine"]
