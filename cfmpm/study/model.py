"""The description of one study as typed, frozen models.

A study is read from YAML by :mod:`cfmpm.study.reading` and expanded into its members by
:mod:`cfmpm.study.expansion`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from cfmpm.scene.base import Model
from cfmpm.scene.document import parse_key
from cfmpm.scene.model import Scene
from cfmpm.scene.quantities import Count, Name, Number, Text

# All are checked before the first is solved. Each takes 0.05 ms and 4 kB, and 0.6 ms if its body
# differs from that of all others.
MOST_MEMBERS = 100_000
KEY = "key of the scene, such as mesh.size or loads[0].traction[1]"


def _base(value: Any) -> Any:
    if not isinstance(value, str | Mapping) or not value:
        raise ValueError("must be the path of a scene file, or a scene")
    return value


def _values(value: Any) -> Any:
    if not isinstance(value, list | tuple | Mapping) or not value:
        raise ValueError("must be a list of values, or a mapping from names to values")
    return value


def _dotted(value: Any) -> Any:
    if not isinstance(value, str):
        raise ValueError("must be the key of a scene, such as mesh.size or loads[0].traction")
    try:
        parse_key(value)
    except LookupError as error:
        raise ValueError(str(error.args[0])) from None
    return value


def _replaced(value: Any) -> Any:
    # A block that is named has been read (cfmpm.study.blocks).
    if not isinstance(value, Mapping):
        raise ValueError("must be a mapping from keys of the scene to values, or file.yaml:block")
    return value


def _place(value: Any) -> Any:
    if isinstance(value, str):
        where, _, function = value.rpartition(":")
        if where and function.isidentifier():
            return value
    raise ValueError("must be file.py:function or package.module:function")


def _range(value: Any) -> Any:
    if not isinstance(value, list | tuple) or len(value) != 3:
        raise ValueError("must be first value, last value and how many, such as [0, 10, 5]")
    return value


def _refusal(key: str, reason: str) -> PydanticCustomError:
    return PydanticCustomError("refused", "{reason}", {"key": key, "reason": reason})


DottedKey = Annotated[str, BeforeValidator(_dotted)]
Replaced = Annotated[
    dict[DottedKey, Any],
    BeforeValidator(_replaced, json_schema_input_type=dict[str, Any] | str),
]
HowMany = Annotated[Count, Field(ge=1, le=MOST_MEMBERS)]
Range = Annotated[tuple[Number, Number, HowMany], BeforeValidator(_range)]


class Parameter(Model):
    """A key of the scene and the values it takes, or several keys that change together."""

    key: DottedKey | None = Field(None, description=KEY)
    values: Annotated[
        Any, BeforeValidator(_values, json_schema_input_type=list[Any] | dict[str, Any] | None)
    ] = Field(None, description="the values: a list, or a mapping from names to values")
    linspace: Range | None = Field(
        None, description="first value, last value, number of values with equal differences"
    )
    geomspace: Range | None = Field(
        None, description="first value, last value, number of values with equal ratios"
    )
    variants: Annotated[dict[str, Replaced] | None, Field(min_length=1)] = Field(
        None,
        description="in place of a key and its values: by the name of each variant, the values "
        "that it replaces, by dotted keys, or the place of such values: file.yaml:block",
    )

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        kinds = ("values", "linspace", "geomspace", "variants")
        if sum(getattr(self, kind) is not None for kind in kinds) != 1:
            raise _refusal("", f"needs one of {', '.join(kinds)}")
        if (self.key is None) != (self.variants is not None):
            told = f"is missing: {KEY}" if self.key is None else "variants have keys of their own"
            raise _refusal("key", told)
        if self.geomspace is not None and self.geomspace[0] * self.geomspace[1] <= 0:
            raise _refusal("geomspace", "equal ratios need two values of the same sign, not zero")
        return self

    def sets(self) -> list[str]:
        """The dotted keys that it sets, each once."""
        if self.variants is None:
            return [str(self.key)]
        return list(dict.fromkeys(key for one in self.variants.values() for key in one))

    def replaced(self, value: Any) -> dict[str, Any]:
        """What one of its values puts into the scene, by dotted keys."""
        if self.variants is not None:
            return dict(value)
        if self.values is None and float(value).is_integer():
            value = int(value)  # the key may be a count
        return {str(self.key): value}


class Uncertain(Model):
    """A key of the scene and the distribution its values are drawn from."""

    key: DottedKey = Field(description="key of the scene, such as material.g_c")
    distribution: Text = Field(
        description="a continuous distribution of scipy.stats, such as norm, lognorm or uniform"
    )
    arguments: dict[str, Number] = Field(
        {}, description="of the distribution: loc, scale and its shape parameters"
    )

    def sets(self) -> list[str]:
        """The dotted key that it sets."""
        return [self.key]

    def replaced(self, value: Any) -> dict[str, Any]:
        """What a draw puts into the scene, by its dotted key."""
        return {self.key: value}


class LatinHypercube(Model):
    """Draws of uncertain parameters that fill their space evenly."""

    samples: HowMany = Field(description="number of samples")
    seed: Annotated[Count, Field(ge=0, le=2**63)] = Field(
        0, description="seed of the random numbers; the same seed gives the same samples"
    )
    parameters: dict[Name, Uncertain] = Field(min_length=1, description="parameters by name")


class Study(Model):
    """A parameter study: a scene, and the values that some of its keys take.

    The parameters of `product` are combined with each other, each a dimension of the dataset. Those
    of `zip`, or else those of `latin_hypercube`, go side by side along one dimension, ``sample``.
    """

    name: Name
    description: Text = ""
    base: Annotated[Any, BeforeValidator(_base, json_schema_input_type=str | Scene)] = Field(
        description="the scene: a path relative to the study file, or written out"
    )
    replace: Replaced = Field(
        {},
        description="values that replace those of the scene in all members, by dotted key, or the "
        "place of such values: file.yaml:block",
    )
    product: dict[Name, Parameter] = Field(
        {}, description="parameters of which all combinations are solved"
    )
    zip: dict[Name, Parameter] = Field(
        {}, description="parameters varied together, with equal numbers of values"
    )
    latin_hypercube: LatinHypercube | None = Field(
        None, description="uncertain parameters, sampled at random"
    )
    measure: Annotated[str, BeforeValidator(_place)] | None = Field(
        None,
        description="further quantities of each member, by a function from its result to an "
        "xarray.Dataset: file.py:function, relative to the study file, or package.module:function",
    )
    repeats: HowMany = Field(
        1, description="runs of each member, of which the fastest counts for its times"
    )
    batch: HowMany = Field(
        50, description="members per job of the workflow; `cfmpm study` ignores it"
    )

    @model_validator(mode="after")
    def _members(self) -> Self:
        if self.zip and self.latin_hypercube is not None:
            raise _refusal("zip", "goes along `sample`, as latin_hypercube does: leave one out")
        if not (self.product or self.zip or self.latin_hypercube):
            raise _refusal("product", "no parameters: give product, zip or latin_hypercube")
        return self

    def parameters(self) -> Iterator[tuple[str, str, Parameter | Uncertain]]:
        """Section, name and parameter, as they stand in the study file."""
        for name, parameter in self.product.items():
            yield "product", name, parameter
        for name, parameter in self.zip.items():
            yield "zip", name, parameter
        if self.latin_hypercube is not None:
            for name, uncertain in self.latin_hypercube.parameters.items():
                yield "latin_hypercube.parameters", name, uncertain
