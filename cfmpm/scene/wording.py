"""Messages for pydantic's validation errors: one reason for each wrong key."""

from __future__ import annotations

import json
import re
import typing
from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from cfmpm.errors import did_you_mean
from cfmpm.scene.base import Model, models_in
from cfmpm.scene.document import Key, parse_key
from cfmpm.scene.model import Scene

REASONS = {
    "greater_than": "must be greater than {gt:g}",
    "greater_than_equal": "must be at least {ge:g}",
    "less_than": "must be less than {lt:g}",
    "less_than_equal": "must be at most {le:g}",
    "too_short": "needs at least {min_length}, has {actual_length}",
    "too_long": "takes at most {max_length}, has {actual_length}",
    "string_too_short": "must not be empty",
    "string_too_long": "must have at most {max_length} characters",
    "string_pattern_mismatch": "must be letters, digits, _ and -, and start with a letter",
    "string_type": "must be text; put it in quotes",
    "string_unicode": "must be text that can be written in UTF-8",
    "bool_type": "must be true or false",
    "bool_parsing": "must be true or false",
    "list_type": "must be a list",
    "model_type": "must be a mapping",
    "model_attributes_type": "must be a mapping",
    "recursion_loop": "contains itself",
}
# Types of error whose message already contains the value.
WITHOUT_VALUE = {"too_short", "too_long", "string_too_short", "refused", "recursion_loop"}


def refusals(error: ValidationError, data: Any, model: type[Model] = Scene) -> dict[Key, str]:
    """Return the first error for each wrong key.

    Parameters
    ----------
    error : ValidationError
        Raised by `model` for `data`.
    data : object
        Nested dictionaries and lists.
    model : type of Model

    Returns
    -------
    dict of Key to str
        Reason by key.
    """
    found: dict[Key, str] = {}
    for detail in error.errors(include_url=False):
        key = _key(detail["loc"], data)
        for inner, reason in _reasons(detail, key, model):
            found.setdefault(inner, reason)
    return found


def _reasons(detail: ErrorDetails, key: Key, model: type[Model]) -> Iterator[tuple[Key, str]]:
    kind, ctx, value = detail["type"], detail.get("ctx", {}), detail["input"]
    name = str(detail["loc"][-1]) if detail["loc"] else ""
    if kind == "missing":
        meaning = _model_at(detail["loc"][:-1], model).model_fields[name].description
        yield (*key, name), f"is missing: {meaning}" if meaning else "is missing"
    elif kind == "extra_forbidden":
        fields = _model_at(detail["loc"][:-1], model).model_fields
        if name.isdecimal() and value is None:  # {E: 210,5} is read as a key 5 without a value
            yield key, f"unknown key {name}; write decimals with a point, as in 1.{name}"
        else:
            yield key, "unknown key" + did_you_mean(name, fields)
    elif kind == "invalid_key":
        yield key, f"keys must be words, not {shown(detail['loc'][-1])}"
    elif kind == "refused":
        inner = parse_key(ctx["key"]) if ctx["key"] else ()
        yield (*key, *inner), ctx["reason"]
    elif kind == "union_tag_not_found":
        yield (*key, "kind"), f"is missing; known: {', '.join(KINDS)}"
    elif kind == "union_tag_invalid":
        yield (*key, "kind"), f"unknown kind {shown(ctx['tag'])}" + did_you_mean(ctx["tag"], KINDS)
    elif kind == "literal_error":
        known = re.findall(r"'([^']*)'", ctx["expected"])
        yield key, f"unknown value {shown(value)}" + did_you_mean(value, known)
    else:
        yield key, _plain_reason(kind, detail, value)


def _plain_reason(kind: str, detail: ErrorDetails, value: Any) -> str:
    ctx = detail.get("ctx", {})
    if kind == "value_error":
        reason = str(ctx["error"])
    else:
        reason = REASONS.get(kind, detail["msg"]).format(**ctx)
    if isinstance(value, str) and re.fullmatch(r"\s*[-+]?\d+,\d+([eE][-+]?\d+)?\s*", value):
        return f"{reason}, with a decimal point; got {shown(value)}"
    return reason if kind in WITHOUT_VALUE else f"{reason}; got {shown(value)}"


def shown(value: Any) -> str:
    """Return a value as text for a message, similar to the file, at most 60 characters."""
    if value is None:
        return "nothing"
    if isinstance(value, Mapping):
        return "a mapping"
    if isinstance(value, list | tuple):
        flat = len(value) <= 3 and not any(isinstance(v, Mapping | list | tuple) for v in value)
        return f"[{', '.join(map(shown, value))}]" if flat else f"a list of {len(value)}"
    try:
        text = (
            json.dumps(value, ensure_ascii=False) if isinstance(value, str | bool) else str(value)
        )
    except ValueError:
        return "a number of thousands of digits"
    text = " ".join(text.split())
    return text if len(text) <= 60 else f"{text[:57]}..."


def _kind(model: type[Model]) -> str:
    field = model.model_fields.get("kind")
    return str(typing.get_args(field.annotation)[0]) if field else ""


KINDS = [_kind(model) for model in models_in(Scene.model_fields["family"].annotation)]


def _model_at(loc: tuple[str | int, ...], model: type[Model]) -> type[Model]:
    """Return the model that raised the error at `loc`."""
    models: list[type[Model]] = [model]
    for part in loc:
        field = models[0].model_fields.get(str(part)) if len(models) == 1 else None
        if field is not None:
            models = models_in(field.annotation)
        else:  # an index, or the name of one model of a union
            models = [model for model in models if _kind(model) == part] or models
    return models[0]


def _key(loc: tuple[str | int, ...], data: Any) -> Key:
    """Return the key in the data from the location of an error, without the tags of unions."""
    key: list[str | int] = []
    for part in loc:
        if isinstance(data, Mapping) and isinstance(part, str) and part in data:
            pass
        elif not (isinstance(data, list | tuple) and isinstance(part, int) and part < len(data)):
            continue
        data = data[part]
        key.append(part)
    return tuple(key)
