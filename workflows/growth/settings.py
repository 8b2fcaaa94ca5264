"""The configuration of sections 5.2 to 5.5: cracks that grow."""

from __future__ import annotations

from typing import Any, Self

from pydantic import Field, model_validator

from workflows.configuration import study_file
from workflows.configuration.block import Block, require

# Variants that figures and claims speak of by name, by study.
GROWN = {
    "edge": (
        *("cf_790", "cf_2584", "hoop_790", "hoop_2584", "paper_790", "paper_2584"),
        *("t6", "crack_control"),
    ),
    "shear": ("cf", "paper", "cf_second", "hoop_second_1.38", "t6_second_2.76", "t6_second_1.95"),
    "holes": ("cf", "paper", "hoop", "stiff", "crack_control", "rollers"),
    "beam": ("cf_15_5", "cf_10_4", "cf_10_6", "hoop_15_5", "hoop_10_4", "hoop_10_6"),
}


class Film(Block):
    """Which variant of a study is shown as a film."""

    variant: str
    every: int = Field(1, ge=1, description="of how many increments one is shown")


class GrowthStudy(Block):
    """A scene whose cracks grow, in several variants (paper sections 5.2 to 5.5)."""

    study: str = Field(description="study file with a parameter variant")
    film: Film

    @property
    def scene(self) -> str:
        """The scene file that the study starts from."""
        return study_file.scene_of(self.study)

    @property
    def variants(self) -> list[str]:
        """The names of the variants."""
        return study_file.labels(self.study, "variant")

    def filmed(self) -> dict[str, Any]:
        """What the variant of the film replaces in the scene, by dotted keys."""
        return study_file.replaced(self.study, "variant", self.film.variant)

    @model_validator(mode="after")
    def _film_is_a_variant(self) -> Self:
        if self.film.variant not in self.variants:
            raise ValueError(f"film.variant: there is no variant {self.film.variant}")
        return self


class Growth(Block):
    """Sections 5.2, 5.3, 5.4 and 5.5."""

    edge: GrowthStudy
    shear: GrowthStudy
    holes: GrowthStudy
    beam: GrowthStudy

    def studies(self) -> dict[str, GrowthStudy]:
        """All studies by their names."""
        return {name: getattr(self, name) for name in type(self).model_fields}

    def near_miss_sizes(self) -> list[int]:
        """Element sizes of the near-miss of the beam's bottom hole, coarse to fine [mm]."""
        names = [name for name in self.beam.variants if name.startswith("first_")]
        return sorted((int(name.removeprefix("first_")) for name in names), reverse=True)

    @model_validator(mode="after")
    def _what_is_shown_is_there(self) -> Self:
        for name, study in self.studies().items():
            require(f"{name}.variants", GROWN[name], study.variants)
        sizes = self.near_miss_sizes()
        if not sizes:
            raise ValueError("beam.variants: figures and claims need first_ with an element size")
        require("beam.variants", [f"second_{size}" for size in sizes], self.beam.variants)
        return self
