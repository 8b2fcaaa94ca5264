"""Keys of the evaluation at crack tips, of crack growth and of fatigue."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import (
    BeforeValidator,
    Discriminator,
    Field,
    Tag,
    model_validator,
)

from cfmpm.registry.criteria import DEFAULT_DIRECTION, DIRECTIONS, DRIVING_FORCES
from cfmpm.scene.base import Model, OneOf, list_or_count, refusal
from cfmpm.scene.quantities import (
    Count,
    CountBesideList,
    Length,
    Number,
    Positive,
    is_whole,
)


class Fracture(Model):
    """Evaluation of configurational force, J, K and T at the crack tips."""

    radii: Annotated[
        Annotated[CountBesideList, Field(ge=1, le=20), Tag("(count)")]
        | Annotated[list[Length], Field(min_length=1, max_length=20), Tag("(list)")],
        Discriminator(list_or_count),
    ] = Field(
        1,
        description="domain radii [mm], or their number; the spread over the radii needs at least "
        "two",
    )
    refine: Length | None = Field(
        None,
        description="largest element size at a growing tip [mm]: before each segment release, "
        "larger elements around the tip are bisected; the limit increases by 0.3 times the "
        "distance from the tip. Default with mesh.grading: auto: a tenth of mesh.size or a "
        "twentieth of the crack length; otherwise no refinement",
    )

    @model_validator(mode="after")
    def _different(self) -> Self:
        if isinstance(self.radii, list) and len(set(self.radii)) < len(self.radii):
            raise refusal("radii", "must differ from each other")
        return self


def _order(value: Any) -> Any:
    if not is_whole(value) or value not in (1, 2):
        raise ValueError("must be 1 or 2")
    return value


class Growth(Model):
    """Control, criterion and direction of crack growth."""

    control: Literal["load", "crack", "fatigue"] = Field(
        "load",
        description="load: growth at the load of the scene until no tip meets the criterion; "
        "crack: the load of each increment is the one at which the criterion is just met; fatigue: "
        "growth under cyclic load, with the load of the scene as its maximum, until a tip meets "
        "the criterion",
    )
    criterion: Annotated[str, OneOf(DRIVING_FORCES)] = Field(
        "energy_release_rate",
        description="driving force that is compared with g_c; cf_norm is that of the paper",
    )
    direction: Annotated[str, OneOf(DIRECTIONS)] = Field(
        DEFAULT_DIRECTION, description="direction of crack growth; cf is that of the paper"
    )
    order: Annotated[Literal[1, 2], BeforeValidator(_order)] = Field(
        1,
        description="1: segments along the tangent of the crack path, as in the paper; 2: along "
        "its secant, extrapolated from the last two tangents; more accurate on smooth curves, but "
        "it oscillates on straight paths and near holes",
    )
    tips: Literal["all", "largest"] = Field(
        "all",
        description="tips that grow in an increment: all tips that meet the criterion in the solve "
        "before it, or only the tip with the largest driving force",
    )
    transfer: Literal["domains", "paper"] = Field(
        "domains",
        description="integration where nodes have moved: domains: over the exact intersections of "
        "the domains of the material points with the triangles; paper: at the material points "
        "with unchanged volume, as in the paper",
    )
    increments: Annotated[Count, Field(ge=1, le=100_000)] = Field(
        500, description="largest number of increments"
    )


class Fatigue(Model):
    """Paris' law, for cycles between load_ratio times the loads of the scene and these loads."""

    C: Positive = Field(
        description="factor of da/dN = C dK^m [mm/cycle / (MPa mm^0.5)^m]; to convert from m/cycle "
        "and MPa m^0.5 multiply by 1000 / 1000^(m/2)"
    )
    m: Positive = Field(description="exponent of dK = (1 - load_ratio) sqrt(K_I^2 + K_II^2)")
    threshold: Annotated[Number, Field(ge=0)] = Field(
        0.0, description="dK at and below which a tip does not advance [MPa mm^0.5]"
    )
    load_ratio: Annotated[Number, Field(ge=0, lt=1)] = Field(
        0.0, description="smallest load of a cycle divided by the largest"
    )
