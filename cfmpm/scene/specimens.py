"""Keys of the families of specimens."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

from pydantic import (
    Field,
    model_validator,
)

from cfmpm.scene.base import Model, refusal
from cfmpm.scene.body import (
    Circle,
    Crack,
)
from cfmpm.scene.quantities import (
    Coordinate,
    Length,
    Number,
)


class Specimen(Model):
    """What the families share: the parameter that stands for the loads."""

    load_key: ClassVar[str] = "traction"

    @property
    def load(self) -> float | None:
        """The load parameter [MPa, or N/mm for a force]."""
        value: float | None = getattr(self, self.load_key)
        return value


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


class CentreCrack(Specimen):
    """Rectangle with a central crack of two tips; edges bottom, right, top, left."""

    kind: Literal["centre_crack"]
    width: Length = Field(description="[mm]")
    height: Length = Field(description="[mm]")
    crack_length: Length = Field(description="from tip to tip [mm]")
    crack_angle: Annotated[Number, Field(ge=-90, le=90)] = Field(
        0.0, description="from the x axis, anticlockwise [deg]"
    )
    traction: Number | None = Field(None, description="tension on top and bottom [MPa]")


class CompactTension(Specimen):
    """Compact tension specimen (ASTM E399 proportions); pin holes pin_top and pin_bottom."""

    load_key: ClassVar[str] = "force"

    kind: Literal["compact_tension"]
    width: Length = Field(description="W, from the load line to the back face [mm]")
    crack_length: Length = Field(description="a, from the load line [mm]")
    force: Number | None = Field(None, description="pull on the pins per thickness [N/mm]")

    @model_validator(mode="after")
    def _crack_inside(self) -> Self:
        if self.crack_length >= self.width:
            raise refusal("crack_length", f"must be less than the width, {self.width:g}")
        return self


class ThreePointBend(Specimen):
    """Beam on two supports, force at the middle of the top; crack from the bottom.

    With `loads` in place of `force`, the supports are among the loads too.
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


class PlateWithHoles(Specimen):
    """Rectangle with circular holes and cracks; edges bottom, right, top, left, hole_1 ..."""

    kind: Literal["plate_with_holes"]
    width: Length = Field(description="[mm]")
    height: Length = Field(description="[mm]")
    holes: list[Circle] = Field(min_length=1)
    cracks: list[Crack] = Field([])
    traction: Number | None = Field(None, description="tension on top and bottom [MPa]")


Family = Annotated[
    SingleEdge | CentreCrack | CompactTension | ThreePointBend | PlateWithHoles,
    Field(discriminator="kind"),
]
