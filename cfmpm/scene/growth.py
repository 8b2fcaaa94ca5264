"""Keys of what is evaluated at the tips, of crack growth and of fatigue."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import (
    Discriminator,
    Field,
    Tag,
    model_validator,
)

from cfmpm.registry.criteria import DIRECTIONS, DRIVING_FORCES
from cfmpm.scene.base import Model, OneOf, list_or_count, refusal
from cfmpm.scene.quantities import (
    Count,
    Length,
    Number,
    Positive,
)


class Fracture(Model):
    """What is evaluated at the crack tips."""

    radii: Annotated[
        Annotated[Count, Field(ge=1, le=20), Tag("(count)")]
        | Annotated[list[Length], Field(min_length=1, max_length=20), Tag("(list)")],
        Discriminator(list_or_count),
    ] = Field(
        1, description="domain radii [mm], or how many are to be chosen; the spread needs two"
    )
    refine: Length | None = Field(
        None,
        description="largest element at a growing tip [mm]: before each release larger ones "
        "around it are halved, up to 0.3 of the distance further away; left out: a tenth of "
        "mesh.size or a twentieth of the crack with mesh.grading: auto, else none are",
    )

    @model_validator(mode="after")
    def _different(self) -> Self:
        if isinstance(self.radii, list) and len(set(self.radii)) < len(self.radii):
            raise refusal("radii", "must differ from each other")
        return self


class Growth(Model):
    """How the cracks grow."""

    control: Literal["load", "crack", "fatigue"] = Field(
        "load",
        description="load: at the load of the scene, until no tip runs; crack: at the load that "
        "makes the criterion just met, increment by increment; fatigue: by cycles of load up to "
        "that of the scene, until the criterion is met",
    )
    criterion: Annotated[str, OneOf(DRIVING_FORCES)] = Field(
        "energy_release_rate", description="what is compared with g_c; cf_norm is the paper's"
    )
    direction: Annotated[str, OneOf(DIRECTIONS)] = Field(
        "max_hoop", description="where a crack turns to; cf is the paper's"
    )
    order: Literal[1, 2] = Field(
        1,
        description="1: segments along the tangent of the path, as the paper; 2: along its secant, "
        "extrapolated from the last two tangents: better on smooth curves, restless on paths that "
        "run straight or pass close by a hole",
    )
    tips: Literal["all", "largest"] = Field(
        "all",
        description="which of the tips that meet the criterion run in an increment: all of them, "
        "each as the one solve before it tells, or the largest alone",
    )
    transfer: Literal["domains", "paper"] = Field(
        "domains",
        description="how material points follow the moving grid: by the exact parts of their "
        "domains, or, as the paper does, by point and unchanged volume",
    )
    increments: Annotated[Count, Field(ge=1, le=100_000)] = Field(
        500, description="after how many increments to end at the latest"
    )


class Fatigue(Model):
    """Paris' law, for cycles of load between load_ratio and one times the loads of the scene."""

    C: Positive = Field(
        description="of da/dN = C dK^m [mm/cycle / (MPa mm^0.5)^m]; from m/cycle and MPa m^0.5: "
        "times 1000 / 1000^(m/2)"
    )
    m: Positive = Field(description="exponent of dK = (1 - load_ratio) sqrt(K_I^2 + K_II^2)")
    threshold: Annotated[Number, Field(ge=0)] = Field(
        0.0, description="dK at and below which a tip does not advance [MPa mm^0.5]"
    )
    load_ratio: Annotated[Number, Field(ge=0, lt=1)] = Field(
        0.0, description="least load over greatest"
    )
