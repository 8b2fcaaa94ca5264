"""Three-point bending beam."""

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
    """Beam on two supports with a force at the middle of the top edge; crack from the bottom edge.

    Force and supports act at points. K_I is therefore below the formula of ASTM E399, by 0.7 % at
    a/W = 0.5 and span / height = 4, and by 4 % for short cracks. If `loads` replaces `force`, it
    must also contain the supports.
    """

    load_key: ClassVar[str] = "force"

    kind: Literal["three_point_bend"]
    length: Length = Field(description="[mm]")
    height: Length = Field(description="[mm]")
    span: Length = Field(description="distance between the supports [mm]")
    crack_length: Length = Field(description="[mm]")
    crack_offset: Coordinate = Field(
        0.0, description="distance of the crack from midspan, positive to the right [mm]"
    )
    holes: list[Circle] = Field([])
    force: Number | None = Field(None, description="downward force per mm of thickness [N/mm]")

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
