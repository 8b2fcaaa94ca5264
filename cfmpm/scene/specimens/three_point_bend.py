"""Beam on two supports, bent."""

from __future__ import annotations

from typing import ClassVar, Literal, Self

from pydantic import Field, model_validator

from cfmpm.scene.base import refusal
from cfmpm.scene.body import Circle, Crack, Geometry, Hole
from cfmpm.scene.components import Components
from cfmpm.scene.loads import Load
from cfmpm.scene.quantities import Coordinate, Length, Number
from cfmpm.scene.specimens.specimen import Specimen, rectangle


class ThreePointBend(Specimen):
    """Beam on two supports, force at the middle of the top; crack from the bottom.

    Force and supports act at points; K_I is then 0.7 % below the form of ASTM E399 at a/W = 0.5 and
    span / height = 4, and 4 % below it for short cracks. With `loads` in place of `force`, the
    supports are among the loads too.
    """

    load_key: ClassVar[str] = "force"

    kind: Literal["three_point_bend"]
    length: Length = Field(description="[mm]")
    height: Length = Field(description="[mm]")
    span: Length = Field(description="distance of the supports [mm]")
    crack_length: Length = Field(description="[mm]")
    crack_offset: Coordinate = Field(
        0.0, description="of the crack from midspan, positive right [mm]"
    )
    holes: list[Circle] = Field([])
    force: Number | None = Field(None, description="downward per thickness [N/mm]")

    @model_validator(mode="after")
    def _inside(self) -> Self:
        if self.span > self.length:
            raise refusal("span", f"must be at most the length, {self.length:g}")
        if self.crack_length >= self.height:
            raise refusal("crack_length", f"must be less than the height, {self.height:g}")
        if abs(self.crack_offset) >= self.length / 2:
            raise refusal("crack_offset", f"must be less than half the length, {self.length / 2:g}")
        return self

    def geometry(self) -> Geometry:
        x = self.length / 2 + self.crack_offset
        return Geometry(
            outline=rectangle(self.length, self.height),
            holes=[Hole(circle=circle) for circle in self.holes],
            cracks=[Crack(points=[(x, 0), (x, self.crack_length)])],
        )

    def loads(self) -> list[Load]:
        if self.force is None:
            return []
        middle = self.length / 2
        left, right = (middle - self.span / 2, 0), (middle + self.span / 2, 0)
        return [
            Load(name="support_left", point=left, displacement=Components(x=0, y=0)),
            Load(name="support_right", point=right, displacement=Components(y=0)),
            Load(name="force", point=(middle, self.height), force=(0, -self.force)),
        ]
