"""Keys of a material."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import (
    Field,
    create_model,
    model_validator,
)

from cfmpm.registry.laws import LAWS, Constant
from cfmpm.scene.base import Model, refusal
from cfmpm.scene.quantities import (
    Number,
    Positive,
)


class MaterialKeys(Model):
    """Keys of all materials; the laws of `registry.laws` add the keys of their constants."""

    E: Positive = Field(description="Young's modulus [MPa]")
    nu: Annotated[Number, Field(gt=-1, lt=0.5)] = Field(description="Poisson's ratio")
    g_c: Positive | None = Field(None, description="critical energy release rate [N/mm]")
    law: str = "hencky"

    @model_validator(mode="after")
    def _has_the_constants_of_its_law(self) -> Self:
        law = LAWS[self.law]
        own = {constant.name for constant in law.constants}
        for constant in _CONSTANTS.values():
            value = getattr(self, constant.name)
            if constant.name in own and value is None:
                raise refusal(constant.name, f"is missing: the law {self.law} needs it")
            if constant.name not in own and value != constant.default:
                reason = f"the law {self.law} has none"
                if not law.plastic and _of_flow(constant.name):
                    reason = f"the law {self.law} is elastic"
                raise refusal(constant.name, f"does not fit: {reason}")
        return self


def _constants() -> dict[str, Constant]:
    """Return the constants of all laws by name; laws that share a name must agree on its limits."""
    found: dict[str, Constant] = {}
    for law in LAWS.values():
        for constant in law.constants:
            known = found.setdefault(constant.name, constant)
            if known != replace(constant, description=known.description):
                raise ValueError(f"two laws differ in what their constant {constant.name} may be")
            if known is not constant:
                said = f"{known.description}; {constant.description}"
                found[constant.name] = replace(known, description=said)
    return found


def _of_flow(name: str) -> bool:
    """Whether the constant of this name belongs to plastic laws only."""
    return all(
        law.plastic or name not in {constant.name for constant in law.constants}
        for law in LAWS.values()
    )


def _field(constant: Constant) -> Any:
    """Return the type and the field of a constant, for `pydantic.create_model`."""
    limits = {"gt": constant.above, "ge": constant.least, "lt": constant.below, "le": constant.most}
    given: dict[str, Any] = {key: value for key, value in limits.items() if value is not None}
    kind: Any = Annotated[Number, Field(**given)] if given else Number
    if constant.default is None:
        kind = kind | None
    return kind, Field(constant.default, description=constant.description)


_CONSTANTS = _constants()

if TYPE_CHECKING:

    class Material(MaterialKeys):
        """A material with one of the registered laws."""

else:
    Material = create_model(
        "Material",
        __base__=MaterialKeys,
        __module__=__name__,
        __doc__="An isotropic material; at small strain every elastic law is Hooke's law.",
        law=(
            Literal[tuple(LAWS)],
            Field(
                "hencky",
                description="law at finite deformation, with the volumetric energy lambda U(J): "
                + "; ".join(f"{word}: {law.description}" for word, law in LAWS.items()),
            ),
        ),
        **{name: _field(constant) for name, constant in _CONSTANTS.items()},
    )
