"""Keys of a material."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import (
    Field,
    model_validator,
)

from cfmpm.scene.base import Model, refusal
from cfmpm.scene.quantities import (
    Number,
    Positive,
)


class Material(Model):
    """An isotropic material; at small strain every elastic law is that of Hooke."""

    E: Positive = Field(description="Young's modulus [MPa]")
    nu: Annotated[Number, Field(gt=-1, lt=0.5)] = Field(description="Poisson's ratio")
    g_c: Positive | None = Field(None, description="critical energy release rate [N/mm]")
    law: Literal["hencky", "ciarlet", "neo_hookean", "j2"] = Field(
        "hencky",
        description="at finite deformation: hencky is the paper's, and loses ellipticity at "
        "stretches of 2 to 3; ciarlet is a neo-Hookean law that keeps it; neo_hookean has "
        "lambda/2 (ln J)^2 instead; j2 is Hencky elasticity with a yield stress",
    )
    yield_stress: Positive | None = Field(None, description="of j2 [MPa]")
    hardening: Annotated[Number, Field(ge=0)] = Field(
        0.0, description="of j2: yield stress gained per plastic strain [MPa]"
    )

    @model_validator(mode="after")
    def _yields_where_plastic(self) -> Self:
        if self.law == "j2" and self.yield_stress is None:
            raise refusal("yield_stress", "is missing: the law j2 needs it")
        if self.law != "j2" and self.yield_stress is not None:
            raise refusal("yield_stress", f"does not fit: the law {self.law} is elastic")
        if self.law != "j2" and self.hardening:
            raise refusal("hardening", f"does not fit: the law {self.law} is elastic")
        return self
