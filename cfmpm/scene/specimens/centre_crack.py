"""Plate with a central crack."""

from __future__ import annotations

import cmath
import math
from typing import Annotated, Literal

from pydantic import Field

from cfmpm.scene.body import Crack, Geometry
from cfmpm.scene.loads import Load
from cfmpm.scene.quantities import Length, Number
from cfmpm.scene.specimens.specimen import Specimen, rectangle, tension


class CentreCrack(Specimen):
    """Rectangle with a central crack with two tips; edges bottom, right, top, left."""

    kind: Literal["centre_crack"]
    width: Length = Field(description="[mm]")
    height: Length = Field(description="[mm]")
    crack_length: Length = Field(description="from tip to tip [mm]")
    crack_angle: Annotated[Number, Field(ge=-90, le=90)] = Field(
        0.0, description="angle from the x axis, positive anticlockwise [deg]"
    )
    traction: Number | None = Field(None, description="tension on top and bottom [MPa]")

    def geometry(self) -> Geometry:
        centre = complex(self.width, self.height) / 2
        arm = cmath.rect(self.crack_length / 2, math.radians(self.crack_angle))
        if abs(self.crack_angle) == 90:
            arm = complex(0, arm.imag)  # round-off: the cosine of 90 degrees is not exactly zero
        ends = [(z.real, z.imag) for z in (centre - arm, centre + arm)]
        return Geometry(outline=rectangle(self.width, self.height), cracks=[Crack(points=ends)])

    def loads(self) -> list[Load]:
        return tension(self.traction)
