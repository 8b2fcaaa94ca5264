"""What all models of a scene share."""

from __future__ import annotations

from typing import Any

from pydantic import (
    BaseModel,
    ConfigDict,
)
from pydantic_core import PydanticCustomError


def refusal(key: str, reason: str) -> PydanticCustomError:
    """What a model's validator raises; `key` names the field at fault, "" the model itself."""
    return PydanticCustomError("refused", "{reason}", {"key": key, "reason": reason})


class Model(BaseModel):
    """A frozen model that refuses unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True)


def list_or_count(value: Any) -> str:
    return "(list)" if isinstance(value, list | tuple) else "(count)"
