"""Components of a prescribed displacement."""

from __future__ import annotations

from typing import Self

from pydantic import Field, model_validator

from cfmpm.scene.base import Model, refusal
from cfmpm.scene.quantities import Number


class Components(Model):
    """Prescribed displacement; an omitted component is free."""

    x: Number | None = Field(None, description="[mm]")
    y: Number | None = Field(None, description="[mm]")

    @model_validator(mode="after")
    def _something(self) -> Self:
        if self.x is None and self.y is None:
            raise refusal("", "needs x or y or both; an omitted component is free")
        return self
