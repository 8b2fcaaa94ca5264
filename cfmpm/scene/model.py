"""The description of one scene as typed, frozen models.

Units throughout: mm, N, MPa, N/mm; forces are per mm of thickness. A scene is read from YAML by
:mod:`cfmpm.scene.reading`; conditions on several fields are checked by :mod:`cfmpm.scene.rules`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, Self, Union

from pydantic import (
    AfterValidator,
    Discriminator,
    Field,
    Tag,
    model_validator,
)

from cfmpm.registry.solvers import SOLVERS
from cfmpm.registry.specimens import SPECIMENS
from cfmpm.registry.table import load
from cfmpm.scene.base import Model, OneOf, list_or_count, refusal
from cfmpm.scene.body import (
    Geometry,
    MeshFile,
)
from cfmpm.scene.growth import Fatigue, Fracture, Growth
from cfmpm.scene.loads import Load
from cfmpm.scene.material import Material
from cfmpm.scene.mesh import Mesh
from cfmpm.scene.quantities import (
    Count,
    CountBesideList,
    Length,
    Name,
    Number,
)
from cfmpm.scene.specimens.specimen import Specimen

if TYPE_CHECKING:
    Family = Specimen
else:
    Family = Annotated[
        Union[tuple(load(entry.place) for entry in SPECIMENS.values())],  # noqa: UP007
        Field(discriminator="kind"),
    ]


def _one_after_the_other(factors: list[float]) -> list[float]:
    if any(a == b for a, b in zip([0.0, *factors], factors, strict=False)):
        raise ValueError("each must differ from the one before it, the first from zero")
    return factors


class Updated(Model):
    """How the updated Lagrangian formulation resets its grid."""

    grid: Literal["fixed", "following"] = Field(
        "fixed",
        description="fixed: the grid returns to its initial position after every load step, as in "
        "the paper; following: boundary, crack faces and tips of the grid move with the material, "
        "and the interior is smoothed where triangles are distorted (needs mesh.element: T3)",
    )
    integration: Literal["points", "domains"] = Field(
        "points",
        description="points: at the material points with their volumes, as in the paper; domains: "
        "over the exact parts of the domains of the points in the triangles of the grid (needs "
        "mesh.element: T3 and a law other than j2)",
    )
    ghost: Annotated[Number, Field(ge=0)] = Field(
        0.0,
        description="stabilisation of triangles that hold little material: this factor times E h^2 "
        "times the squared jump of the normal gradient across their sides; 0.1 is enough; needs "
        "mesh.element: T3",
    )
    smooth_below: Annotated[Number, Field(ge=0, le=1)] = Field(
        0.2,
        description="a following grid is smoothed where the quality of a triangle is below this "
        "(1: equilateral, 0: flat); 1 smooths after every step, 0 never",
    )
    margin: Length | None = Field(
        None,
        description="width of the margin of a fixed grid, into which the body can move [mm]; "
        "default from the prescribed displacement",
    )


class Output(Model):
    """Files written in addition to the history."""

    fields: bool = Field(
        False,
        description="write displacement, stress and configurational force on the grid at the end: "
        "fields.nc",
    )
    every: Annotated[Count, Field(ge=1)] | None = Field(
        None,
        description="write the same fields at the first step, then at every n-th step, and at the "
        "last: fields_0001.nc ..., with their table, fields_index.nc",
    )


class Scene(Model):
    """One scene: a body with its cracks, material, loads and grid.

    Exactly one of `geometry`, `family` and `mesh_file` gives the body. A family also gives the
    loads, when its load parameter is set and `loads` is empty.
    """

    name: Name = Field(description="name of the scene, and of its folder in results")
    description: str = Field("", description="one line of text for the summary")
    geometry: Geometry | None = Field(None, description="the body by outline, holes and cracks")
    family: Family | None = Field(None, description="the body as a specimen with parameters")
    mesh_file: MeshFile | None = Field(None, description="the body as a mesh of gmsh")
    material: Material = Field(description="material of the body outside of regions")
    plane: Literal["strain", "stress"] = Field("strain", description="plane strain or stress")
    kinematics: Literal["auto", "small", "finite"] = Field(
        "auto",
        description="small: one linear solve; finite: finite deformation, solved in load steps; "
        "auto: small, unless finite deformation would change the energy or J by more than 1 % "
        "(finite_effect, finite_effect_J); under plane stress or growth auto keeps small strain "
        "and warns",
    )
    formulation: Literal["total", "updated"] = Field(
        "total",
        description="total: the grid is the reference configuration; updated: the grid is reset "
        "after every load step, as in the paper",
    )
    updated: Updated = Field(Updated(), description="options of formulation: updated")
    loads: list[Load] = Field([], description="loads and supports; empty where a family has them")
    load_steps: Annotated[
        Annotated[CountBesideList, Field(ge=1, le=100_000), Tag("(count)")]
        | Annotated[
            list[Number],
            Field(min_length=1, max_length=100_000),
            AfterValidator(_one_after_the_other),
            Tag("(list)"),
        ],
        Discriminator(list_or_count),
    ] = Field(
        1,
        description="number of equal load steps, or the load factors in their order; each is "
        "recorded. Intermediate steps are added as needed",
    )
    mesh: Mesh = Field(Mesh(), description="the background grid")
    solver: Annotated[str, OneOf(("auto", *SOLVERS))] = Field(
        "auto",
        description="linear solver; auto: the fastest installed one; superlu and amg always are",
    )
    fracture: Fracture = Field(Fracture(), description="what is evaluated at crack tips")
    growth: Growth | None = Field(None, description="crack growth; without it cracks do not grow")
    fatigue: Fatigue | None = Field(None, description="Paris' law, for growth.control: fatigue")
    output: Output = Field(Output(), description="files written in addition to the history")

    @model_validator(mode="after")
    def _one_body(self) -> Self:
        given = [k for k in ("geometry", "family", "mesh_file") if getattr(self, k) is not None]
        if len(given) != 1:
            have = "has " + " and ".join(given) if given else "has no body"
            raise refusal("", f"{have}: exactly one of geometry, family, mesh_file is needed")
        return self

    @model_validator(mode="after")
    def _loaded_once(self) -> Self:
        if self.family is None:
            if not self.loads:
                raise refusal("loads", "no load: nothing is prescribed")
        elif self.loads and self.family.load is not None:
            key = self.family.load_key
            raise refusal(f"family.{key}", "is a load already; leave it out or leave out `loads`")
        elif not self.loads and self.family.load is None:
            key = self.family.load_key
            raise refusal("loads", f"no load: give family.{key}, or a list of loads")
        return self
