"""The workflow's configuration as typed models; nothing runs on a bad one.

Snakemake reads the files by YAML 1.1, in which 1e-9 is text: use the validated models only.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from cfmpm.scene import Scene, load_scene
from cfmpm.scene.model import Length, Mesh, Positive
from cfmpm.study.model import Study

Meshes = Annotated[dict[int, Mesh], Field(min_length=1)]


class _Settings(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Section51(_Settings):
    """Section 5.1 of the paper: a stationary edge crack."""

    scene: str = Field(description="scene file, relative to the repository")
    converged: Positive = Field(description="G of the plate of finite height [N/mm]")
    domain_radius: Length = Field(description="domain of Fig. 5 and 7 [mm]; one of `radii`")
    radii: list[Length] = Field(min_length=1, description="domain radii of Fig. 6 [mm]")
    drawn: list[int] = Field(description="grids of Fig. 4, by their keys in series T3")
    swept: list[int] = Field(description="grids of Fig. 6, by their keys in series T3")
    series: dict[str, Meshes] = Field(description="T3, T6, T6_graded: grids by triangles wanted")


class Film(_Settings):
    """Which variant of a study is shown as a film."""

    variant: str
    every: int = Field(1, ge=1, description="of how many increments one is shown")


class GrowthStudy(_Settings):
    """A scene whose cracks grow, in several variants (paper sections 5.2 to 5.5)."""

    scene: str
    film: Film
    variants: dict[str, dict[str, Any]] = Field(
        min_length=1, description="values of the scene that are replaced, by dotted keys"
    )

    @model_validator(mode="after")
    def _film_is_a_variant(self) -> Self:
        if self.film.variant not in self.variants:
            raise ValueError(f"film.variant: there is no variant {self.film.variant}")
        return self


class Growth(_Settings):
    """Sections 5.2, 5.3, 5.4 and 5.5."""

    edge: GrowthStudy
    shear: GrowthStudy
    holes: GrowthStudy
    beam: GrowthStudy

    def studies(self) -> dict[str, GrowthStudy]:
        """All studies by their names."""
        return {name: getattr(self, name) for name in type(self).model_fields}


class LargeStrain(_Settings):
    """Fig. 8 of the paper: CF against elongation, by formulation, law and grid."""

    scene: str
    variants: dict[str, dict[str, Any]] = Field(
        min_length=1, description="values of the scene that are replaced, by dotted keys"
    )


class WorkPrecision(_Settings):
    """Error against run time, of cfmpm and of scikit-fem on the same grids."""

    scene: str
    converged: Positive = Field(description="G of the plate of finite height [N/mm]")
    radius: Length = Field(description="outer radius of the ring of J [mm]")
    repeats: int = Field(3, ge=1, description="runs of which the fastest counts")
    solvers: list[str] = Field(description="those that are not installed are left out")
    series: dict[str, list[Mesh]]


class Scaling(_Settings):
    """Run time against the number of material points."""

    scene: str
    solver: str = "auto"
    repeats: int = Field(2, ge=1)
    series: dict[str, list[Mesh]]


class NewtonCost(_Settings):
    """Cost of an iteration of Newton's method per material point."""

    scene: str
    solver: str = "auto"
    repeats: int = Field(3, ge=1, description="the fastest counts")
    replaced: dict[str, Any] = Field({}, description="values of the scene, by dotted keys")
    meshes: list[Mesh] = Field(min_length=1)


class SliverGrid(_Settings):
    """The plate of the paper in squares, cut into thin triangles."""

    element: Literal["T3", "T6"]
    slivers: Literal["none", "needles", "caps"]
    thinness: Positive = Field(1.0, description="height over length")


class Case(_Settings):
    """An extreme case, how it is expected to end, and what its result is compared with."""

    replaced: dict[str, Any] = Field({}, description="values of the scene, by dotted keys")
    grid: SliverGrid | None = Field(None, description="in place of one by gmsh")
    ends: Literal["solved", "unstable", "failed", "refused"] = "solved"
    compared: Literal["J", "load_reached"] = "J"
    exact: float | None = Field(None, description="known value of what is compared")
    as_case: str | None = Field(None, description="a case above: group/name")
    times: float = Field(1.0, description="factor on the value of that case")
    vanishes: bool = Field(False, description="zero is known; the other is the measure of it")
    source: str = Field("", description="where the known value is from")
    within: Positive | None = Field(None, description="relative error that is allowed")


class CaseGroup(_Settings):
    """Cases of one kind."""

    title: str
    replaced: dict[str, Any] = Field({}, description="values of the scene, by dotted keys")
    cases: dict[str, Case]


class Stability(_Settings):
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


class Settings(_Settings):
    """All blocks of configs/workflow."""

    section_5_1: Section51
    growth: Growth
    large_strain: LargeStrain
    work_precision: WorkPrecision
    scaling: Scaling
    newton_cost: NewtonCost
    stability: Stability


def read_settings(config: Mapping[str, Any]) -> Settings:
    """Check the configuration and every scene that it stands for.

    Parameters
    ----------
    config : mapping
        As Snakemake has merged it.

    Raises
    ------
    pydantic.ValidationError
        Where a block does not fit its model.
    SceneError
        Where a grid does not fit the scene.
    """
    # A study given as --configfile has found its way into it; rules/study.smk reads it by itself.
    blocks = {key: value for key, value in config.items() if key not in Study.model_fields}
    settings = Settings.model_validate(blocks)
    paper = settings.section_5_1
    for meshes in paper.series.values():
        for mesh in meshes.values():
            scene_with(paper.scene, mesh, paper.radii)
    for study in settings.growth.studies().values():
        for replaced in study.variants.values():
            load_scene(study.scene, replaced)
    for replaced in settings.large_strain.variants.values():
        load_scene(settings.large_strain.scene, replaced)
    for group in settings.stability.groups.values():
        for case in group.cases.values():
            if case.grid is None and case.ends != "refused":
                load_scene(settings.stability.scene, {**group.replaced, **case.replaced})
    for block in (settings.work_precision, settings.scaling):
        for listed in block.series.values():
            for mesh in listed:
                scene_with(block.scene, mesh)
    return settings


def scene_with(
    path: str | Path, mesh: Mesh | Mapping[str, Any], radii: list[float] | None = None, **more: Any
) -> Scene:
    """Read a scene with another grid, other radii [mm] and further values replaced."""
    if isinstance(mesh, Mesh):
        mesh = mesh.model_dump(mode="json", exclude_none=True)
    overrides = {"mesh": dict(mesh), **more}
    if radii is not None:
        overrides["fracture.radii"] = list(radii)
    return load_scene(path, overrides)
