"""The configuration of Fig. 8."""

from __future__ import annotations

from typing import Self

from pydantic import Field, model_validator

from workflows.configuration import study_file
from workflows.configuration.block import Block, require

# Variants that figures and claims speak of by name, and the numbers of load steps.
PULLED = (
    *("hencky_T3_4", "hencky_T6_4", "hencky_T6_0.5", "hencky_following", "hencky_domains"),
    *("hencky_uniform", "hencky_uniform_dead", "hencky_dead", "ciarlet_dead"),
    *("neo_hookean_T3_4", "neo_hookean_T6_0.5", "neo_hookean_following", "ciarlet_T6_0.5"),
)
STEPS = (1, 2, 4, 10)


class LargeStrain(Block):
    """Fig. 8 of the paper: CF against elongation, by formulation, law and grid."""

    study: str = Field(description="study file with a parameter variant")
    as_printed: str = Field(description="study file with parameters load and steps")

    @property
    def scene(self) -> str:
        """The scene file that the study starts from."""
        return study_file.scene_of(self.study)

    @model_validator(mode="after")
    def _what_is_shown_is_there(self) -> Self:
        require("variants", PULLED, study_file.labels(self.study, "variant"))
        counted = study_file.parameter(self.as_printed, "steps").values
        require("steps", STEPS, counted)
        return self
