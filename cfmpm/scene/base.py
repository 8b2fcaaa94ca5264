"""What all models of a scene share."""

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
    """What a model's validator raises; `key` names the field at fault, "" the model itself."""
    return PydanticCustomError("refused", "{reason}", {"key": key, "reason": reason})


class Model(BaseModel):
    """A frozen model that refuses unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True)


@dataclass(frozen=True)
class OneOf:
    """Annotation of a text that is one of some words, such as those of a table of `registry`.

    Where the words are known to the type checker too, `typing.Literal` says the same.
    """

    words: Iterable[str]

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.literal_schema(list(self.words))


def list_or_count(value: Any) -> str:
    return "(list)" if isinstance(value, list | tuple) else "(count)"
