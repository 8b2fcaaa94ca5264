"""The configuration of section 5.1."""

from __future__ import annotations

from typing import Annotated, Self

from cfmpm.scene.mesh import Mesh
from cfmpm.scene.quantities import Length, Positive
from pydantic import Field, model_validator

from workflows.configuration.block import Block, require

Meshes = Annotated[dict[int, Mesh], Field(min_length=1)]

# What figures and claims speak of by name.
SERIES = ("T3", "T6", "T6_graded")


class Section51(Block):
    """Section 5.1 of the paper: a stationary edge crack."""

    scene: str = Field(description="scene file, relative to the repository")
    converged: Positive = Field(description="G of the plate of finite height [N/mm]")
    domain_radius: Length = Field(description="domain of Fig. 5 and 7 [mm]; one of `radii`")
    radii: list[Length] = Field(min_length=1, description="domain radii of Fig. 6 [mm]")
    drawn: list[int] = Field(min_length=1, description="grids of Fig. 4, by their keys in T3")
    swept: list[int] = Field(
        min_length=2, max_length=2, description="grids of Fig. 6, by their keys in T3"
    )
    series: dict[str, Meshes] = Field(description="T3, T6, T6_graded: grids by triangles wanted")

    @model_validator(mode="after")
    def _what_is_shown_is_there(self) -> Self:
        require("series", SERIES, self.series)
        require("series.T6", self.series["T3"], self.series["T6"])
        require("series.T3", [*self.drawn, *self.swept], self.series["T3"])
        require("radii", [self.domain_radius], self.radii)
        return self
