"""Base class, validation error and annotations for all models of a scene."""

from __future__ import annotations

import typing
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import (
    BaseModel,
    ConfigDict,
    Discriminator,
)
from pydantic_core import PydanticCustomError, core_schema


def refusal(key: str, reason: str) -> PydanticCustomError:
    """Make the error that a validator of a model raises.

    Parameters
    ----------
    key : str
        Dotted key of the wrong field, relative to the model; "" for the model as a whole.
    reason : str
        Message for the user, without the key.

    Returns
    -------
    PydanticCustomError
        `cfmpm.scene.wording` turns it into one line of a `SceneError`.
    """
    return PydanticCustomError("refused", "{reason}", {"key": key, "reason": reason})


class Model(BaseModel):
    """Immutable model; an unknown key is a validation error."""

    model_config = ConfigDict(extra="forbid", frozen=True)


@dataclass(frozen=True)
class OneOf:
    """Annotation of a string that must be one of `words`, such as the words of a registry.

    Use `typing.Literal` for words that are fixed and that the type checker must know.

    Attributes
    ----------
    words : iterable of str
        The allowed words.
    """

    words: Iterable[str]

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.literal_schema(list(self.words))


def list_or_count(value: Any) -> str:
    """Return the tag of a field that is a list or a count: "(list)" or "(count)"."""
    return "(list)" if isinstance(value, list | tuple) else "(count)"


def takes_list_or_count(key: Sequence[str | int], model: type[Model]) -> bool:
    """Whether the field at a key, such as ("fracture", "radii"), takes a list or a count."""
    models, found = [model], False
    for part in key:
        if isinstance(part, int):
            found = False  # an entry of a list
            continue
        fields = [one.model_fields[part] for one in models if part in one.model_fields]
        found = any(
            isinstance(mark, Discriminator) and mark.discriminator is list_or_count
            for field in fields
            for mark in field.metadata
        )
        models = [inner for field in fields for inner in models_in(field.annotation)]
    return found


def models_in(annotation: Any) -> list[type[Model]]:
    """Return the models in the annotation of a field, such as those of a union or of a list."""
    if isinstance(annotation, type) and issubclass(annotation, Model):
        return [annotation]
    return [model for part in typing.get_args(annotation) for model in models_in(part)]
