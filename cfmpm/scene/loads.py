"""Keys of loads and supports."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import (
    BeforeValidator,
    Field,
    create_model,
    model_validator,
)

from cfmpm.registry.loads import BOX, EDGE, LOADS, POINT
from cfmpm.registry.table import load
from cfmpm.scene.base import Model, refusal
from cfmpm.scene.components import Components
from cfmpm.scene.quantities import (
    GroupName,
    Name,
    Point,
    Vector,
)


def _box(value: Any) -> Any:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise ValueError("must be two opposite corners, such as [[0, 0], [10, 5]]")
    return value


class LoadKeys(Model):
    """Keys of all loads: a name, a place, and one kind of load of `registry.loads`."""

    name: Name | None = Field(
        None, description="name of the load; default: the edge's name, or load_1, load_2 ..."
    )
    edge: GroupName | None = Field(
        None, description="a named edge or hole; with a mesh file, the name of a physical curve"
    )
    box: Annotated[tuple[Point, Point], BeforeValidator(_box)] | None = Field(
        None,
        description="two opposite corners of a box [mm]: the part of the boundary inside it; crack "
        "faces in it are neither loaded nor held",
    )
    point: Point | None = Field(
        None, description="coordinates of a point [mm]; the grid gets a node there"
    )

    @property
    def kind(self) -> str:
        """Kind of load, a word of `registry.loads`."""
        return next(word for word in LOADS if getattr(self, word) is not None)

    @property
    def value(self) -> Any:
        """Prescribed value, of the type that belongs to the kind."""
        return getattr(self, self.kind)

    @model_validator(mode="after")
    def _one_place_and_one_kind(self) -> Self:
        kinds = [word for word in LOADS if getattr(self, word) is not None]
        places = [key for key in (EDGE, BOX, POINT) if getattr(self, key) is not None]
        if len(kinds) != 1:
            given = f"has {' and '.join(kinds)}; give each a load of its own"
            raise refusal("", f"needs one of {', '.join(LOADS)}" if not kinds else given)
        (kind,) = kinds
        allowed = LOADS[kind].places
        for place in places:
            if place not in allowed:
                fits = f"goes with {' or '.join(allowed)}" if allowed else "has no place"
                raise refusal(place, f"does not fit: a {kind} {fits}")
        if allowed and len(places) != 1:
            given = f"has {' and '.join(places)}; one place is needed" if places else "has no place"
            raise refusal("", f"{given}: a {kind} goes with {' or '.join(allowed)}")
        return self


if TYPE_CHECKING:

    class Load(LoadKeys):
        """A load, with the kinds that the package defines."""

        displacement: Components | None = None
        traction: Vector | None = None
        force: Vector | None = None
        body_force: Vector | None = None

else:
    Load = create_model(
        "Load",
        __base__=LoadKeys,
        __module__=__name__,
        __doc__="""One load or support: a place (edge, box or point) and a prescribed quantity.

    A displacement acts on an edge, a box or a point, a traction on an edge or a box, a force on a
    point, and a body force on the whole body.
    """,
        **{
            word: (load(kind.value) | None, Field(None, description=kind.description))
            for word, kind in LOADS.items()
        },
    )
