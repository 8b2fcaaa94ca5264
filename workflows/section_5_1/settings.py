"""The configuration of section 5.1."""

from __future__ import annotations

from typing import Self

from pydantic import Field, model_validator

from cfmpm.scene.quantities import Length, Positive
from workflows.configuration import study_file
from workflows.configuration.block import Block, require

# What figures and claims speak of by name, and how figures call it.
SERIES = {
    "T3": "T3, one point a triangle",
    "T6": "T6, three points a triangle",
    "T6_graded": "best: T6 graded to the tip",
}


class Section51(Block):
    """Section 5.1 of the paper: a stationary edge crack."""

    study: str = Field(
        description="study file with a parameter grid; its values are named by a series and the "
        "number of triangles in the paper"
    )
    converged: Positive = Field(description="G of the plate of finite height [N/mm]")
    domain_radius: Length = Field(description="domain of Fig. 5 and 7 [mm]; one of the study's")
    drawn: list[str] = Field(min_length=1, description="grids of Fig. 4, by names of the study")
    swept: list[int] = Field(
        min_length=2, max_length=2, description="grids of Fig. 6, T3, by triangles"
    )

    @property
    def scene(self) -> str:
        """The scene file that the study starts from."""
        return study_file.scene_of(self.study)

    def kept(self) -> list[str]:
        """The grids of the pictures, by their names in the study."""
        return sorted({*self.drawn, *(f"T3_{wanted}" for wanted in self.swept)})

    def triangles(self) -> dict[str, list[int]]:
        """The grids of each series by the number of triangles in the paper."""
        found: dict[str, list[int]] = {}
        for label in study_file.labels(self.study, "grid"):
            series, _, wanted = label.rpartition("_")
            found.setdefault(series, []).append(int(wanted))
        return found

    @model_validator(mode="after")
    def _what_is_shown_is_there(self) -> Self:
        grids = self.triangles()
        require("series", SERIES, grids)
        require("T6", grids["T3"], grids["T6"])
        require("T3", self.swept, grids["T3"])
        require("grids", self.drawn, study_file.labels(self.study, "grid"))
        radii = study_file.read_study(self.study).replace.get("fracture.radii", [])
        require("radii", [self.domain_radius], radii)
        return self
