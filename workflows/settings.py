"""The workflow's configuration as typed models; nothing runs on a bad one.

Snakemake reads the files by YAML 1.1, in which 1e-9 is text: use the validated models only.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from cfmpm.scene import Scene, load_scene
from cfmpm.scene.mesh import Mesh
from cfmpm.scene.quantities import Length, Positive
from cfmpm.study.model import Study

Meshes = Annotated[dict[int, Mesh], Field(min_length=1)]

# What figures and claims speak of by name.
SERIES = ("T3", "T6", "T6_graded")
GROWN = {
    "edge": (
        *("cf_790", "cf_2584", "hoop_790", "hoop_2584", "paper_790", "paper_2584"),
        *("t6", "crack_control"),
    ),
    "shear": ("cf", "paper", "cf_second", "hoop_second_1.38", "t6_second_2.76", "t6_second_1.95"),
    "holes": ("cf", "paper", "hoop", "stiff", "crack_control", "rollers"),
    "beam": ("cf_15_5", "cf_10_4", "cf_10_6", "hoop_15_5", "hoop_10_4", "hoop_10_6"),
}
PULLED = (
    *("hencky_T3_4", "hencky_T6_4", "hencky_T6_0.5", "hencky_following", "hencky_paper"),
    *("neo_hookean_T3_4", "neo_hookean_T6_0.5", "neo_hookean_following"),
    *("ciarlet_T6_0.5", "ciarlet_paper", "hencky_dead"),
)


class _Settings(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


def _require(where: str, needed: Iterable[Any], there: Iterable[Any]) -> None:
    """Refuse what lacks something that figures and claims show."""
    missing = sorted(set(needed) - set(there))
    if missing:
        raise ValueError(f"{where}: figures and claims need {', '.join(map(str, missing))}")


class Section51(_Settings):
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
        _require("series", SERIES, self.series)
        _require("series.T6", self.series["T3"], self.series["T6"])
        _require("series.T3", [*self.drawn, *self.swept], self.series["T3"])
        _require("radii", [self.domain_radius], self.radii)
        return self


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

    def near_miss_sizes(self) -> list[int]:
        """Element sizes of the near-miss of the beam's bottom hole, coarse to fine [mm]."""
        names = [name for name in self.beam.variants if name.startswith("first_")]
        return sorted((int(name.removeprefix("first_")) for name in names), reverse=True)

    @model_validator(mode="after")
    def _what_is_shown_is_there(self) -> Self:
        for name, study in self.studies().items():
            _require(f"{name}.variants", GROWN[name], study.variants)
        sizes = self.near_miss_sizes()
        if not sizes:
            raise ValueError("beam.variants: figures and claims need first_ with an element size")
        _require("beam.variants", [f"second_{size}" for size in sizes], self.beam.variants)
        return self


class LargeStrain(_Settings):
    """Fig. 8 of the paper: CF against elongation, by formulation, law and grid."""

    scene: str
    variants: dict[str, dict[str, Any]] = Field(
        min_length=1, description="values of the scene that are replaced, by dotted keys"
    )

    @model_validator(mode="after")
    def _what_is_shown_is_there(self) -> Self:
        _require("variants", PULLED, self.variants)
        return self


# Values of a scene by dotted keys, each with all that it takes.
Axes = Annotated[dict[str, Annotated[list[Any], Field(min_length=1)]], Field(min_length=1)]


def combinations(axes: Mapping[str, Sequence[Any]]) -> Iterator[dict[str, Any]]:
    """All combinations of the values of axes, the last key fastest."""
    for values in itertools.product(*axes.values()):
        yield dict(zip(axes, values, strict=True))


def each_value(axes: Mapping[str, Sequence[Any]]) -> Iterator[dict[str, Any]]:
    """Combinations in which every value of every axis occurs; the others are then the first."""
    first = {key: values[0] for key, values in axes.items()}
    yield first
    for key, values in axes.items():
        for value in values[1:]:
            yield first | {key: value}


class StationaryProblem(_Settings):
    """A scene whose answer is known."""

    scene: str
    replaced: dict[str, Any] = Field({}, description="values of the scene, by dotted keys")
    exact: dict[Literal["G", "K_I", "K_II"], Positive] = Field(min_length=1)
    solvers: list[str] = Field(description="of `solved`; those not installed are left out")
    solved: dict[str, Axes] = Field(
        description="grids for all solvers and, at small strain, for scikit-fem"
    )
    axes: list[Axes] = Field(description="grids for cfmpm alone, by the solver that it chooses")
    radii: list[Length] = Field(min_length=1, description="domain radii that are compared [mm]")

    def all_axes(self) -> list[Axes]:
        """Those of all solvers and those of cfmpm alone, in the scene as it is run."""
        replaced = {key: [value] for key, value in self.replaced.items()}
        return [replaced | one for one in (*self.solved.values(), *self.axes)]


class PathProblem(_Settings):
    """A scene whose crack grows along a path that is known."""

    scene: str
    replaced: dict[str, Any] = Field({}, description="values of the scene, by dotted keys")
    reference: str = Field(description="file of points of the path in workflows/reference")
    tip: str | None = Field(None, description="whose path; by default that of the first tip")
    release: str | None = Field(
        None, description="file of x and G along the path in workflows/reference, if known"
    )
    axes: list[Axes] = Field(
        description="grids and ways to grow; ways are compared on the grids that have run in all"
    )

    def all_axes(self) -> list[Axes]:
        """In the scene as it is run."""
        replaced = {key: [value] for key, value in self.replaced.items()}
        return [replaced | one for one in self.axes]


class WorkPrecision(_Settings):
    """Error against run time, of cfmpm and of scikit-fem on the same grids."""

    repeats: int = Field(3, ge=1, description="runs of which the fastest counts")
    stationary: dict[str, StationaryProblem]
    paths: dict[str, PathProblem]

    @model_validator(mode="after")
    def _problems_have_different_names(self) -> Self:
        for name in self.stationary.keys() & self.paths.keys():
            raise ValueError(f"paths: there is a stationary problem {name} too")
        return self


class Scaling(_Settings):
    """Run time against the number of material points."""

    scene: str
    solver: str = "auto"
    repeats: int = Field(2, ge=1)
    threads: list[Annotated[int, Field(ge=1)]] = Field(min_length=1)
    series: dict[str, list[Mesh]]


class NewtonCost(_Settings):
    """Cost of an iteration of Newton's method per material point."""

    scene: str
    solver: str = "auto"
    repeats: int = Field(3, ge=1, description="the fastest counts")
    replaced: dict[str, Any] = Field({}, description="values of the scene, by dotted keys")
    meshes: list[Mesh] = Field(min_length=1)


class StudyOverhead(_Settings):
    """What a study costs besides its members."""

    scene: str
    replaced: dict[str, Any] = Field({}, description="values of the scene, by dotted keys")
    lengths: int = Field(ge=2, description="how many crack lengths")
    stiffnesses: int = Field(ge=2, description="how many Young's moduli")
    workers: list[Annotated[int, Field(ge=1)]] = Field(min_length=1)


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
    compared: Literal["J", "load_reached", "elongation"] = "J"
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
    study_overhead: StudyOverhead
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
    # A study given as --configfile has found its way into it, and has been checked by itself.
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
    for listed in settings.scaling.series.values():
        for mesh in listed:
            scene_with(settings.scaling.scene, mesh)
    work = settings.work_precision
    for problem in (*work.stationary.values(), *work.paths.values()):
        for axes in problem.all_axes():
            # All combinations would take seconds: the job reads them, before it runs any.
            for replaced in each_value(axes):
                load_scene(problem.scene, replaced)
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
