"""Make the JSON schema of scene files: ``python -m cfmpm.scene.schema > schema.json``."""

from __future__ import annotations

import json
import sys
from typing import Any

from cfmpm.scene.base import Model
from cfmpm.scene.model import Scene

_BOUNDS = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}


def schema(model: type[Model] = Scene) -> dict[str, Any]:
    """Return the JSON schema of the files that a model describes, as nested dictionaries."""
    dialect = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    whole: dict[str, Any] = _with_bounds(dialect | model.model_json_schema())
    return whole


def _with_bounds(part: Any) -> Any:
    """Write the bounds of numbers as JSON schema keywords, equally for all versions of pydantic.

    Since version 2.12 pydantic writes the bounds of a number with a validator as its own keywords
    (gt, ge, lt, le), which editors do not know.
    """
    if isinstance(part, list):
        return [_with_bounds(one) for one in part]
    if not isinstance(part, dict):
        return part
    bounds = {
        word: float(part[key])
        for own, word in _BOUNDS.items()
        for key in (own, word)
        if isinstance(part.get(key), int | float)
    }
    rest = {key: value for key, value in part.items() if _BOUNDS.get(key, key) not in bounds}
    return {key: _with_bounds(value) for key, value in rest.items()} | bounds


def schema_text(model: type[Model] = Scene) -> str:
    """Return the text of configs/schema.json."""
    return json.dumps(schema(model), indent=2, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    sys.stdout.write(schema_text())
