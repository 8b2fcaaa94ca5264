"""Compact tension specimen."""

from __future__ import annotations

import math
from typing import ClassVar, Literal, Self

from pydantic import Field, model_validator

from cfmpm.scene.base import refusal
from cfmpm.scene.body import Circle, Crack, Geometry, Hole
from cfmpm.scene.loads import Load
from cfmpm.scene.quantities import Length, Number
from cfmpm.scene.shapes import XY
from cfmpm.scene.specimens.specimen import Specimen, rectangle

# Pin holes, and the sign of the vertical load on each.
PINS = {"pin_top": 1, "pin_bottom": -1}
# Loaded arc of a pin hole, centred on the direction of the load [rad].
PRESSED = math.radians(60)


class CompactTension(Specimen):
    """Compact tension specimen (proportions of ASTM E399); pin holes pin_top and pin_bottom.

    Each pin acts by a uniform traction on an arc of 60 degrees of its hole. `crack_length` of the
    history is measured from the load line, too.
    """

    load_key: ClassVar[str] = "force"

    kind: Literal["compact_tension"]
    width: Length = Field(description="W, from the load line to the back face [mm]")
    crack_length: Length = Field(description="a, from the load line [mm]")
    force: Number | None = Field(
        None, description="tensile force on each pin per mm of thickness [N/mm]"
    )

    @model_validator(mode="after")
    def _crack_inside(self) -> Self:
        if self.crack_length >= self.width:
            raise refusal("crack_length", f"must be less than the width, {self.width:g}")
        return self

    def geometry(self) -> Geometry:
        load_line, middle = 0.25 * self.width, 0.6 * self.width
        return Geometry(
            outline=rectangle(1.25 * self.width, 2 * middle),
            holes=[
                Hole(
                    name=name,
                    circle=Circle(centre=self._centre(side), radius=self._diameter / 2),
                )
                for name, side in PINS.items()
            ],
            cracks=[
                Crack(
                    points=[(0, middle), (load_line + self.crack_length, middle)],
                    uncounted=load_line,
                )
            ],
        )

    def loads(self) -> list[Load]:
        if self.force is None:
            return []
        radius = self._diameter / 2
        wide, high = radius * math.sin(PRESSED / 2), radius * math.cos(PRESSED / 2)
        pull = self.force / (PRESSED * radius)
        loads = []
        for name, side in PINS.items():
            x, y = self._centre(side)
            box = ((x - wide, y + side * high), (x + wide, y + side * 1.1 * radius))
            loads.append(Load(name=name, box=box, traction=(0, side * pull)))
        return loads

    def _centre(self, side: int) -> XY:
        """Return the centre of the upper (1) or the lower (-1) pin hole [mm]."""
        return 0.25 * self.width, (0.6 + side * 0.275) * self.width

    @property
    def _diameter(self) -> float:
        """Diameter of the pin holes [mm]."""
        return 0.25 * self.width
