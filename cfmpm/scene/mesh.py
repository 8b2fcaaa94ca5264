"""Keys of the background grid."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import (
    BeforeValidator,
    Discriminator,
    Field,
    Tag,
    model_validator,
)

from cfmpm.registry.elements import ELEMENTS
from cfmpm.scene.base import Model, OneOf, refusal
from cfmpm.scene.quantities import (
    LARGEST_LENGTH,
    Length,
    Positive,
)


class Grading(Model):
    """Element size min(size, tip_size + growth r) at distance r from the nearest crack tip."""

    tip_size: Length = Field(description="element size at a crack tip [mm]")
    growth: Positive = Field(0.3, description="increase of element size per distance from the tip")


def _numbers_or_word(value: Any) -> str:
    return "(numbers)" if isinstance(value, Mapping | Grading) else "(word)"


def _word(value: Any) -> Any:
    if value not in ("auto", "uniform"):
        raise ValueError("must be auto, uniform, or a mapping with tip_size and growth")
    return value


class Mesh(Model):
    """The background grid."""

    element: Annotated[str, OneOf(ELEMENTS)] = Field(
        "T6",
        description=", ".join(f"{word}: {entry.description}" for word, entry in ELEMENTS.items())
        + " a triangle",
    )
    size: Length | None = Field(
        None,
        description="element size [mm]; default: a twentieth of the square root of the body's area",
    )
    grading: Annotated[
        Annotated[Grading, Tag("(numbers)")]
        | Annotated[Literal["auto", "uniform"], BeforeValidator(_word), Tag("(word)")],
        Discriminator(_numbers_or_word),
    ] = Field(
        "auto",
        description="element size near crack tips: uniform: no grading; tip_size and growth; or "
        "auto: tip_size = size / 300 and growth = 0.4 at a stationary tip, size / 10 and 0.3 at a "
        "growing tip, and smaller at a short crack and at a tip close to the boundary or another "
        "crack",
    )
    hole_size: Length | None = Field(
        None,
        description="element size at holes [mm], such as a third of the ligament between the hole "
        "and an approaching crack; it increases with the distance from the hole as it does from a "
        "tip",
    )

    @model_validator(mode="after")
    def _finer_at_tips_and_holes(self) -> Self:
        size = self.size or LARGEST_LENGTH
        if isinstance(self.grading, Grading) and self.grading.tip_size > size:
            raise refusal("grading.tip_size", f"must be at most mesh.size, {size:g}")
        if self.hole_size is not None and self.hole_size > size:
            raise refusal("hole_size", f"must be at most mesh.size, {size:g}")
        return self
