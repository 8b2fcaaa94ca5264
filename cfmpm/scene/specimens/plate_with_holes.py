"""Plate with holes and cracks."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from cfmpm.scene.body import Circle, Crack, Geometry, Hole
from cfmpm.scene.loads import Load
from cfmpm.scene.quantities import Length, Number
from cfmpm.scene.specimens.specimen import Specimen, rectangle, tension


class PlateWithHoles(Specimen):
    """Rectangle with circular holes and cracks; edges bottom, right, top, left, hole_1 ..."""

    kind: Literal["plate_with_holes"]
    width: Length = Field(description="[mm]")
    height: Length = Field(description="[mm]")
    holes: list[Circle] = Field(min_length=1)
    cracks: list[Crack] = Field([])
    traction: Number | None = Field(None, description="tension on top and bottom [MPa]")

    def geometry(self) -> Geometry:
        return Geometry(
            outline=rectangle(self.width, self.height),
            holes=[Hole(circle=circle) for circle in self.holes],
            cracks=self.cracks,
        )

    def loads(self) -> list[Load]:
        return tension(self.traction)
