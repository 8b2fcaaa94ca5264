"""The JSON schema of scene files, for editors: ``python -m cfmpm.scene.schema > schema.json``."""

from __future__ import annotations

import json
import sys
from typing import Any

from cfmpm.scene.model import Scene


def schema() -> dict[str, Any]:
    """The JSON schema of a scene file."""
    dialect = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    return dialect | Scene.model_json_schema()


def schema_text() -> str:
    """The schema as it stands in configs/schema.json."""
    return json.dumps(schema(), indent=2, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    sys.stdout.write(schema_text())
