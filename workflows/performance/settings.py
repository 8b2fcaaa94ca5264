"""The configuration of the measurements of speed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from cfmpm.scene.mesh import Mesh
from cfmpm.scene.quantities import Length, Positive
from workflows.configuration.block import Block

# Values of a scene by dotted keys, each with all that it takes.
Axes = Annotated[dict[str, Annotated[list[Any], Field(min_length=1)]], Field(min_length=1)]


def each_value(axes: Mapping[str, Sequence[Any]]) -> Iterator[dict[str, Any]]:
    """Combinations in which every value of every axis occurs; the others are then the first."""
    first = {key: values[0] for key, values in axes.items()}
    yield first
    for key, values in axes.items():
        for value in values[1:]:
            yield first | {key: value}


class StationaryProblem(Block):
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


class PathProblem(Block):
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


class WorkPrecision(Block):
    """Error against run time, of cfmpm and of scikit-fem on the same grids."""

    repeats: int = Field(3, ge=1, description="runs of which the fastest counts")
    stationary: dict[str, StationaryProblem]
    paths: dict[str, PathProblem]

    @model_validator(mode="after")
    def _problems_have_different_names(self) -> Self:
        for name in self.stationary.keys() & self.paths.keys():
            raise ValueError(f"paths: there is a stationary problem {name} too")
        return self


class Scaling(Block):
    """Run time against the number of material points."""

    scene: str
    solver: str = "auto"
    repeats: int = Field(2, ge=1)
    threads: list[Annotated[int, Field(ge=1)]] = Field(min_length=1)
    series: dict[str, list[Mesh]]


class NewtonCost(Block):
    """Cost of an iteration of Newton's method per material point."""

    scene: str
    solver: str = "auto"
    repeats: int = Field(3, ge=1, description="the fastest counts")
    replaced: dict[str, Any] = Field({}, description="values of the scene, by dotted keys")
    meshes: list[Mesh] = Field(min_length=1)


class StudyOverhead(Block):
    """What a study costs besides its members."""

    scene: str
    replaced: dict[str, Any] = Field({}, description="values of the scene, by dotted keys")
    lengths: int = Field(ge=2, description="how many crack lengths")
    stiffnesses: int = Field(ge=2, description="how many Young's moduli")
    workers: list[Annotated[int, Field(ge=1)]] = Field(min_length=1)
