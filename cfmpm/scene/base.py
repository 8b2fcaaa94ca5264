"""Base class, errors and annotations of all models of a scene."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from pydantic import (
    BaseModel,
    ConfigDict,
)
from pydantic_core import PydanticCustomError, core_schema


def refusal(key: str, reason: str) -> PydanticCustomError:
    """The error that a model's validator raises; `key` is the wrong field, "" the model itself."""
    return PydanticCustomError("refused", "{reason}", {"key": key, "reason": reason})


class Model(BaseModel):
    """A frozen model that refuses unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True)


@dataclass(frozen=True)
class OneOf:
    """Annotation of a string that must be one of some words, such as those of a registry.

    For words that the type checker must know too use `typing.Literal`.
    """

    words: Iterable[str]

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.literal_schema(list(self.words))


def list_or_count(value: Any) -> str:
    return "(list)" if isinstance(value, list | tuple) else "(count)"
