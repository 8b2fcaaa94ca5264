"""The JSON schema of scene files, for editors: ``python -m cfmpm.scene.schema > schema.json``."""

from __future__ import annotations

import json
import sys
from typing import Any

from cfmpm.scene.base import Model
from cfmpm.scene.model import Scene


def schema(model: type[Model] = Scene) -> dict[str, Any]:
    """The JSON schema of the files that a model describes."""
    dialect = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    return dialect | model.model_json_schema()


def schema_text(model: type[Model] = Scene) -> str:
    """The schema as it stands in configs/schema.json."""
    return json.dumps(schema(model), indent=2, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    sys.stdout.write(schema_text())
