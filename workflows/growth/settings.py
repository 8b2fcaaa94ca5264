"""The configuration of sections 5.2 to 5.5: cracks that grow."""

from __future__ import annotations

from typing import Any, Self

from pydantic import Field, model_validator

from workflows.configuration import study_file
from workflows.configuration.block import Block, require

# Variants that figures and claims speak of by name, by study.
GROWN = {
    "edge": (
        *("as_printed_790", "as_printed_2584", "best", "reset_790", "reset_2584"),
        *("t6", "crack_control"),
    ),
    "shear": (
        *("as_printed", "best", "reset", "reset_5", "cf_first_1.38", "cf_second_2.76"),
        *("hoop_second_1.38", "t6_second_2.76"),
    ),
    "holes": (
        *("as_printed", "best", "reset", "reset_tenth", "cf", "stiff", "crack_control"),
        "rollers",
    ),
    "beam": (
        *("as_printed_15_5", "as_printed_10_6", "as_printed_10_4"),
        *("best_15_5", "best_10_6", "best_10_4"),
    ),
}
# The same on many grids: what the values of a parameter are called.
SCATTERED = {
    "edge": {"how": ("as_printed", "twice", "domains")},
    "shear": {"how": ("as_printed", "twentieth", "domains")},
    "holes": {"how": ("as_printed", "twentieth", "twice", "domains")},
    "beam": {
        "case": ("15_5", "10_6", "10_4"),
        "how": ("R_12.7", "R_19.05", "twentieth", "domains"),
    },
}


class Film(Block):
    """Which variant of a study is shown as a film."""

    variant: str
    every: int = Field(1, ge=1, description="of how many increments one is shown")


class GrowthStudy(Block):
    """A scene whose cracks grow, in several variants (paper sections 5.2 to 5.5)."""

    study: str = Field(description="study file with a parameter variant")
    scatter: str = Field(description="study file with parameters how and grid")
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
        return self.replaced(self.film.variant)

    def replaced(self, variant: str) -> dict[str, Any]:
        """What a variant replaces in the scene, by dotted keys."""
        return study_file.replaced(self.study, "variant", variant)

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
            for parameter, needed in SCATTERED[name].items():
                there = study_file.labels(study.scatter, parameter)
                require(f"{name}.scatter.{parameter}", needed, there)
        sizes = self.near_miss_sizes()
        if not sizes:
            raise ValueError("beam.variants: figures and claims need first_ with an element size")
        require("beam.variants", [f"second_{size}" for size in sizes], self.beam.variants)
        return self
