"""Keys of loads and supports."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Self

from pydantic import (
    BeforeValidator,
    Field,
    model_validator,
)

from cfmpm.scene.base import Model, refusal
from cfmpm.scene.quantities import (
    Name,
    Number,
    Point,
    Vector,
)


def _box(value: Any) -> Any:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise ValueError("must be two opposite corners, such as [[0, 0], [10, 5]]")
    return value


class Components(Model):
    """Prescribed displacement; a component that is left out is free."""

    x: Number | None = Field(None, description="[mm]")
    y: Number | None = Field(None, description="[mm]")

    @model_validator(mode="after")
    def _something(self) -> Self:
        if self.x is None and self.y is None:
            raise refusal("", "needs x or y or both; a component that is left out is free")
        return self


class Load(Model):
    """One load or support: a place (edge, box or point) and what is prescribed there.

    A displacement goes with any place, a traction with an edge or a box, a force with a point; a
    body force has no place.
    """

    name: Name | None = Field(None, description="default: the edge's name, or load_1, load_2 ...")
    edge: Name | None = Field(None, description="a named edge or hole")
    box: Annotated[tuple[Point, Point], BeforeValidator(_box)] | None = Field(
        None, description="two opposite corners [mm]: the part of the boundary inside"
    )
    point: Point | None = Field(None, description="becomes a node of the grid [mm]")
    displacement: Components | None = Field(None, description="on an edge, a box or a point [mm]")
    traction: Vector | None = Field(None, description="on an edge or a box [MPa]")
    force: Vector | None = Field(None, description="on a point, per thickness [N/mm]")
    body_force: Vector | None = Field(None, description="in the whole body [N/mm^3]")

    PLACES_OF: ClassVar[dict[str, tuple[str, ...]]] = {
        "displacement": ("edge", "box", "point"),
        "traction": ("edge", "box"),
        "force": ("point",),
        "body_force": (),
    }

    @model_validator(mode="after")
    def _one_place_and_one_action(self) -> Self:
        actions = [key for key in self.PLACES_OF if getattr(self, key) is not None]
        places = [key for key in ("edge", "box", "point") if getattr(self, key) is not None]
        if len(actions) != 1:
            given = f"has {' and '.join(actions)}; give each a load of its own"
            raise refusal("", f"needs one of {', '.join(self.PLACES_OF)}" if not actions else given)
        (action,) = actions
        allowed = self.PLACES_OF[action]
        for place in places:
            if place not in allowed:
                fits = f"goes with {' or '.join(allowed)}" if allowed else "has no place"
                raise refusal(place, f"does not fit: a {action} {fits}")
        if allowed and len(places) != 1:
            given = f"has {' and '.join(places)}; one place is needed" if places else "has no place"
            raise refusal("", f"{given}: a {action} goes with {' or '.join(allowed)}")
        return self
