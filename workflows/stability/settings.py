"""The configuration of the stability study."""

from __future__ import annotations

from typing import Any, Literal, Self

from pydantic import Field, model_validator

from cfmpm.scene.quantities import Positive
from workflows.configuration.block import Block


class SliverGrid(Block):
    """The plate of the paper in squares, cut into thin triangles."""

    element: Literal["T3", "T6"]
    slivers: Literal["none", "needles", "caps"]
    thinness: Positive = Field(1.0, description="height over length")


class Case(Block):
    """An extreme case, how it is expected to end, and what its result is compared with."""

    replaced: dict[str, Any] = Field({}, description="values of the scene, by dotted keys")
    grid: SliverGrid | None = Field(None, description="in place of one by gmsh")
    ends: Literal["solved", "unstable", "failed", "refused"] = "solved"
    compared: Literal["J", "load_reached", "elongation", "K_I", "K_II", "aside"] = "J"
    along: Literal["edge_crack_rate", "edge_crack_cycles", "double_cantilever_rate"] | None = Field(
        None, description="closed form, with which all steps of a growing crack are compared"
    )
    exact: float | None = Field(None, description="known value of what is compared")
    as_case: str | None = Field(None, description="a case above: group/name")
    times: float = Field(1.0, description="factor on the value of that case")
    vanishes: bool = Field(False, description="zero is known; the other is the measure of it")
    source: str = Field("", description="where the known value is from")
    within: Positive | None = Field(None, description="relative error that is allowed")


class CaseGroup(Block):
    """Cases of one kind."""

    title: str
    replaced: dict[str, Any] = Field({}, description="values of the scene, by dotted keys")
    cases: dict[str, Case]


class Stability(Block):
    """The stability study."""

    scene: str
    groups: dict[str, CaseGroup]

    @model_validator(mode="after")
    def _compared_with_cases_above(self) -> Self:
        above: set[str] = set()
        for group, of_group in self.groups.items():
            for name, case in of_group.cases.items():
                if case.as_case is not None and case.as_case not in above:
                    raise ValueError(f"{group}/{name}: no case {case.as_case} above it")
                above.add(f"{group}/{name}")
        return self
