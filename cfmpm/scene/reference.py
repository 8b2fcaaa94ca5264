"""Make the reference of scene files from their schema: ``python -m cfmpm.scene.reference``."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator
from typing import Any

from cfmpm.scene.quantities import LARGEST_LENGTH
from cfmpm.scene.schema import schema

_INTRODUCTION = """\
# Scene files

A scene is a YAML file. This page is generated from the models that read it: do not edit it, run
`python -m cfmpm.scene.reference > docs/scene.md`.

Lengths are in mm, stresses in MPa, forces in N per mm of thickness. A *name* starts with a letter,
followed by letters, digits, `_` and `-`. A *point* is a pair of coordinates in brackets, such as
`[0, 10]`; a *vector* is a pair of components. A key that is not listed is an error. On the command
line, `--set mesh.size=5` replaces the value of a key; `cfmpm check` describes the scene without
running it.
"""


def reference_text() -> str:
    """Return the text of docs/scene.md."""
    whole = schema()
    models = {"Scene": whole, **whole["$defs"]}
    names = dict.fromkeys(_reached("Scene", models))
    return "\n".join([_INTRODUCTION, *(_section(name, models[name]) for name in names)])


def _reached(name: str, models: dict[str, Any]) -> Iterator[str]:
    """Yield the name of a model and of the models of its keys, in the order of the page."""
    yield name
    for other in _references(models[name]["properties"]):
        yield from _reached(other, models)


def _references(part: Any) -> Iterator[str]:
    """Yield the names of the models to which a part of the schema refers."""
    if isinstance(part, dict):
        if "$ref" in part:
            yield part["$ref"].rpartition("/")[2]
        for key, value in part.items():
            if key not in ("discriminator", "default"):
                yield from _references(value)
    elif isinstance(part, list):
        for one in part:
            yield from _references(one)


def _section(name: str, model: dict[str, Any]) -> str:
    required = model.get("required", [])
    rows = [
        f"| `{key}` | {_kind(part)} | {_default(part, needed=key in required)} "
        f"| {_escaped(part.get('description', ''))} |"
        for key, part in model["properties"].items()
    ]
    table = ["| key | value | default | meaning |", "|---|---|---|---|", *rows]
    return "\n".join([f"## {_title(name)}\n", _escaped(model["description"]) + "\n", *table, ""])


def _title(name: str) -> str:
    """Split the name of a model into words: SingleEdge becomes Single edge."""
    return re.sub(r"(?<!^)(?=[A-Z])", " ", name).capitalize()


def _kind(part: dict[str, Any]) -> str:
    """Describe the allowed values of a key."""
    for several in ("anyOf", "oneOf"):
        if several in part:
            kinds = [_kind(one) for one in part[several] if one.get("type") != "null"]
            return " or ".join(dict.fromkeys(kinds))
    if "$ref" in part:
        title = _title(part["$ref"].rpartition("/")[2])
        return f"[{title}](#{title.lower().replace(' ', '-')})"
    if "const" in part:
        return f"`{part['const']}`"
    if "enum" in part:
        return ", ".join(f"`{word}`" for word in part["enum"])
    if part["type"] == "array":
        return _list(part)
    if part["type"] == "string":
        return "name" if "pattern" in part else "text"
    words = {"number": "number", "integer": "whole number", "boolean": "`true`, `false`"}
    return words[part["type"]] + _range(part)


def _list(part: dict[str, Any]) -> str:
    if "prefixItems" not in part:
        least = part.get("minItems", 0)
        kind = _kind(part["items"])
        kind = re.sub(r"\b(name|number|point)\b", r"\1s", kind)
        return f"list of {kind}" + (f", at least {least}" if least else "")
    first = part["prefixItems"][0]
    if first["type"] == "array":
        return "two points"
    return "point" if "minimum" in first else "vector"


def _range(part: dict[str, Any]) -> str:
    """Describe the bounds of a number, without those that only catch typing errors."""
    low = {">": part.get("exclusiveMinimum"), "≥": part.get("minimum")}
    high = {"<": part.get("exclusiveMaximum"), "≤": part.get("maximum")}
    bounds = [
        f"{sign} {value:g}"
        for sign, value in [*low.items(), *high.items()]
        if value is not None and abs(value) < LARGEST_LENGTH
    ]
    return f" {', '.join(bounds)}" if bounds else ""


def _default(part: dict[str, Any], *, needed: bool) -> str:
    if needed:
        return "required"
    default = part.get("default")
    if default is None or default == "":
        return ""
    if isinstance(default, dict):
        return "its defaults"
    return f"`{default if isinstance(default, str) else json.dumps(default)}`"


def _escaped(text: str) -> str:
    return " ".join(text.replace("|", "\\|").split())


if __name__ == "__main__":
    sys.stdout.write(reference_text())
