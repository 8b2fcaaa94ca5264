"""Plate with an edge crack."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, model_validator

from cfmpm.scene.base import refusal
from cfmpm.scene.body import Crack, Geometry
from cfmpm.scene.loads import Load
from cfmpm.scene.quantities import Length, Number
from cfmpm.scene.specimens.specimen import Specimen, rectangle, tension


class SingleEdge(Specimen):
    """Rectangle with an edge crack from the left side; edges bottom, right, top, left."""

    kind: Literal["single_edge"]
    width: Length = Field(description="[mm]")
    height: Length = Field(description="[mm]")
    crack_length: Length = Field(description="[mm]")
    crack_height: Length | None = Field(None, description="[mm]; default: half the height")
    traction: Number | None = Field(None, description="tension on top and bottom [MPa]")

    @model_validator(mode="after")
    def _crack_inside(self) -> Self:
        if self.crack_length >= self.width:
            raise refusal("crack_length", f"must be less than the width, {self.width:g}")
        if self.crack_height is not None and self.crack_height >= self.height:
            raise refusal("crack_height", f"must be less than the height, {self.height:g}")
        return self

    def geometry(self) -> Geometry:
        y = self.height / 2 if self.crack_height is None else self.crack_height
        crack = Crack(points=[(0, y), (self.crack_length, y)])
        return Geometry(outline=rectangle(self.width, self.height), cracks=[crack])

    def loads(self) -> list[Load]:
        return tension(self.traction)
