"""Every key of a scene and of a study accepts only values of its type, as in the schema."""

from __future__ import annotations

import datetime
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from cfmpm.scene.base import Model
from cfmpm.scene.document import dotted
from cfmpm.scene.model import Scene
from cfmpm.scene.schema import schema
from cfmpm.scene.wording import refusals
from cfmpm.study.model import Study

# A key on the way to a value, which may begin with its specimen (single_edge:width), or the index
# of a list with the length that it has.
Step = str | tuple[int, int]
Way = tuple[Step, ...]

# What a reader of YAML makes of what is written, by kind.
WRITTEN: dict[str, st.SearchStrategy[Any]] = {
    "boolean": st.booleans(),
    "integer": st.integers(-3, 300),
    "whole number with a point": st.integers(-3, 300).map(float),
    "number": st.floats(allow_nan=False, allow_infinity=False).filter(lambda x: x % 1),
    "number in quotes": st.integers(0, 300).map(str) | st.sampled_from(["2.0", "210e3", "1e-9"]),
    "string": st.sampled_from(["yes", "no", "on", "off", "true", "False", "x", ""]),
    "null": st.none(),
    "bytes": st.binary(max_size=3),
    "date": st.just(datetime.date(2024, 1, 13)),
    "mapping": st.just({}),
}
# What keys take besides their own kind: 2 is a number, and YAML 1.1 reads 210e3 as text.
TAKES = {
    "boolean": {"boolean"},
    "integer": {"integer"},
    "number": {"integer", "whole number with a point", "number", "number in quotes"},
    "string": {"string", "number in quotes"},
    "null": {"null"},
    "object": {"mapping"},
    "array": set(),
}
# Words that end the reasons of limits; a value of the right kind may be out of them.
OF_KIND = ("must be a number", "whole number", "must be text", "true or false; got")


def leaves(part: dict[str, Any], names: dict[str, Any], way: Way) -> Iterator[tuple[Way, Way]]:
    """Every key with a single value: its place, and the types that it accepts."""
    options = [
        names[one["$ref"].rpartition("/")[2]] if "$ref" in one else one
        for one in part.get("anyOf", part.get("oneOf", [part]))
    ]
    kinds = tuple(str(one["type"]) for one in options if "type" in one)
    if {"boolean", "integer", "number", "string"} & set(kinds):
        yield way, kinds
    for one in options:
        if one.get("type") == "array":
            items = one.get("prefixItems", [one.get("items", {})])
            for i, item in enumerate(items):
                yield from leaves(item, names, (*way, (i, len(items))))
        for inner in one.get("patternProperties", {}).values():
            yield from leaves(inner, names, (*way, "any"))
        for key, inner in one.get("properties", {}).items():
            kind = one["properties"].get("kind", {}).get("const")
            if (way, key) == ((), "base"):  # which is read as a scene later
                continue
            yield from leaves(inner, names, (*way, key if kind is None else f"{kind}:{key}"))


def found(model: type[Model]) -> dict[Way, Way]:
    """The keys of a model with the types that each accepts."""
    whole = schema(model)
    return dict(leaves({**whole, "type": "object"}, whole.get("$defs", {}), ()))


KEYS = {Scene: found(Scene), Study: found(Study)}
CASES = [(model, way) for model, keys in KEYS.items() for way in keys]


def as_written(way: Way) -> str:
    """Return the dotted key of a place."""
    return dotted(tuple(k[0] if isinstance(k, tuple) else k.rpartition(":")[2] for k in way))


def as_text(part: type[Model] | Way) -> str:
    """Name of a test case."""
    return as_written(part) if isinstance(part, tuple) else part.__name__


def with_value(way: Way, value: Any) -> Any:
    """Data with the value at a place and no other keys."""
    if not way:
        return value
    head, inner = way[0], with_value(way[1:], value)
    if isinstance(head, tuple):
        return [inner if i == head[0] else 0 for i in range(head[1])]
    kind, colon, key = head.partition(":")
    return {"kind": kind, key: inner} if colon else {head: inner}


def reasons(model: type[Model], way: Way, value: Any) -> dict[str, str]:
    """Problems at the place of the value and below it."""
    data = with_value(way, value)
    at = as_written(way)
    try:
        model.model_validate(data)
    except ValidationError as error:
        wrong = {dotted(key): why for key, why in refusals(error, data, model).items()}
        return {key: why for key, why in wrong.items() if key.startswith(at)}
    return {}


def test_all_kinds_are_among_the_keys() -> None:
    for kind in ("boolean", "integer", "number", "string"):
        assert [way for keys in KEYS.values() for way, kinds in keys.items() if kind in kinds]
    of_scene, of_study = ({as_written(way) for way in keys} for keys in KEYS.values())
    assert {"output.fields", "growth.order", "load_steps", "loads[0].box[1][0]"} <= of_scene
    assert {"repeats", "latin_hypercube.seed", "zip.any.geomspace[2]"} <= of_study


@pytest.mark.parametrize(("model", "way"), CASES, ids=as_text)
@given(data=st.data())
@settings(max_examples=10)
def test_a_value_of_another_kind_is_refused(model: type[Model], way: Way, data: Any) -> None:
    taken = set().union(*(TAKES[str(kind)] for kind in KEYS[model][way]))
    for kind, written in WRITTEN.items():
        if kind not in taken:
            value = data.draw(written)
            wrong = reasons(model, way, value)
            assert len(wrong) >= 1, (kind, value)
            assert all("\n" not in why and "Input should" not in why for why in wrong.values())


@pytest.mark.parametrize(("model", "way"), CASES, ids=as_text)
@given(data=st.data())
@settings(max_examples=10)
def test_a_value_of_the_kind_is_not_refused_for_it(model: type[Model], way: Way, data: Any) -> None:
    for kind in set().union(*(TAKES[str(kind)] for kind in KEYS[model][way])):
        value = data.draw(WRITTEN[kind])
        for why in reasons(model, way, value).values():
            assert not any(words in why for words in OF_KIND), (kind, value, why)
