"""Any input gives a scene or a SceneError."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scene_texts import GOOD, attempt, changed

from cfmpm.errors import SceneError
from cfmpm.scene import config_hash, effective_config, expand, scene_from_dict

numbers = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.integers(),
    st.booleans(),
    st.sampled_from(["1e-9", "nan", "x", None]),
)
words = st.sampled_from(
    [
        "name",
        "family",
        "kind",
        "width",
        "height",
        "crack_length",
        "traction",
        "force",
        "material",
        "E",
        "nu",
        "mesh",
        "size",
        "loads",
        "edge",
        "single_edge",
        "centre_crack",
        "auto",
        "radii",
        "fracture",
        "geometry",
        "outline",
        "at",
        "through",
        "top",
        "holes",
        "circle",
        "centre",
        "radius",
        "cracks",
        "points",
        "box",
        "displacement",
        "x",
        "y",
        "mesh_file",
        "file",
    ]
)
anything = st.recursive(
    st.one_of(numbers, words, st.text(max_size=5)),
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.dictionaries(words | st.text(max_size=3), inner, max_size=5)
    ),
    max_leaves=20,
)
points = st.tuples(*[st.floats(-2, 12) | st.integers(-1, 11) | numbers] * 2)
corners = st.lists(
    points | st.fixed_dictionaries({"at": points}, optional={"through": points, "edge": words}),
    max_size=5,
)
circles = st.fixed_dictionaries({"centre": points, "radius": st.floats(0, 9) | numbers})
geometries = st.fixed_dictionaries(
    {"outline": st.just([[0, 0], [10, 0], [10, 10], [0, 10]]) | corners},
    optional={
        "holes": st.lists(
            st.fixed_dictionaries({"circle": circles})
            | st.fixed_dictionaries({"polygon": corners}),
            max_size=3,
        ),
        "cracks": st.lists(
            st.fixed_dictionaries({"points": st.lists(points, max_size=4)}), max_size=3
        ),
    },
)
loads = st.lists(
    st.fixed_dictionaries(
        {},
        optional={
            "edge": words,
            "point": points,
            "box": st.tuples(points, points),
            "traction": points,
            "force": points,
            "displacement": st.fixed_dictionaries({}, optional={"x": numbers, "y": numbers}),
        },
    ),
    max_size=3,
)


def only_scene_errors(data: Any) -> None:
    scene, problems = attempt(lambda: scene_from_dict(data))
    if scene is None:
        assert problems
        assert len({(p.key, p.reason) for p in problems}) == len(problems)
        text = " ".join(map(str, problems))
        assert not any(word in text for word in ("Input should", "pydantic", "http"))
        return
    for same in (scene, expand(scene)):
        again = scene_from_dict(effective_config(same))
        assert again == same
        assert config_hash(again) == config_hash(same)


@given(anything)
def test_nothing_but_scene_errors(data: Any) -> None:
    only_scene_errors(data)


@given(anything, st.sampled_from(["family", "material", "mesh", "loads", "fracture", "geometry"]))
def test_nothing_but_scene_errors_near_a_good_scene(part: Any, key: str) -> None:
    only_scene_errors(changed(**{key: part}))


@given(geometries, loads)
def test_nothing_but_scene_errors_from_geometry(geometry: Any, load: Any) -> None:
    only_scene_errors(changed(family=None, geometry=geometry, loads=load))


@given(geometries)
def test_nothing_but_scene_errors_from_a_loaded_geometry(geometry: Any) -> None:
    only_scene_errors(changed(family=None, geometry=geometry, loads=[{"body_force": [0, 1]}]))


@given(numbers)
def test_a_number_is_finite_and_no_boolean(value: Any) -> None:
    data = changed(material={"E": 1, "nu": 0.3, "g_c": value})
    try:
        number = float(value) if not isinstance(value, bool | None) else math.nan
    except (ValueError, OverflowError):
        number = math.nan
    if value is None or 0 < number <= 1e30:
        assert scene_from_dict(data).material.g_c == (None if value is None else number)
    else:
        with pytest.raises(SceneError) as caught:
            scene_from_dict(data)
        assert [p.key for p in caught.value.problems] == ["material.g_c"]


@given(st.text(max_size=40) | words, st.one_of(numbers, words))
def test_overrides_raise_nothing_but_scene_errors(key: str, value: Any) -> None:
    _, problems = attempt(lambda: scene_from_dict(GOOD, overrides={key: value}))
    # Without a body or loads, the scene as a whole is at fault, not one key of it.
    assert {p.file for p in problems if p.key not in ("", "loads")} <= {f"override {key}"}
