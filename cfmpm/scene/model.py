"""The description of one scene as typed, immutable models.

Units throughout: mm, N, MPa, N/mm; forces are per mm of thickness. :mod:`cfmpm.scene.reading` reads
a scene from YAML; :mod:`cfmpm.scene.rules` checks conditions on several fields.
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
    Flag,
    Length,
    Name,
    Number,
    Text,
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
    """Options of the updated Lagrangian formulation, which resets its grid."""

    grid: Literal["fixed", "following"] = Field(
        "fixed",
        description="fixed: the grid is reset to its initial position after every load step, as in "
        "the paper; following: boundary, crack faces and tips of the grid move with the material, "
        "and interior nodes are smoothed where triangles are distorted (needs mesh.element: T3)",
    )
    integration: Literal["points", "domains"] = Field(
        "points",
        description="points: at the material points with their volumes, as in the paper; domains: "
        "over the exact intersections of the domains of the material points with the triangles "
        "(needs mesh.element: T3 and an elastic law)",
    )
    ghost: Annotated[Number, Field(ge=0)] = Field(
        0.0,
        description="stabilisation of triangles that contain little material: this factor times "
        "E h^2 times the squared jump of the normal displacement gradient across their sides; 0.1 "
        "is enough; needs mesh.element: T3",
    )
    smooth_below: Annotated[Number, Field(ge=0, le=1)] = Field(
        0.2,
        description="triangle quality below which a following grid is smoothed (1: equilateral, "
        "0: degenerate); 1 smooths after every step, 0 never",
    )
    margin: Length | None = Field(
        None,
        description="width of the margin of a fixed grid around the body, into which the body can "
        "move [mm]; default: from the prescribed displacement",
    )


class Output(Model):
    """Files written in addition to the history."""

    fields: Flag = Field(
        False,
        description="write displacement, stress and configurational force at the last step to "
        "fields.nc",
    )
    every: Annotated[Count, Field(ge=1)] | None = Field(
        None,
        description="write the same fields at the first, every n-th and the last step to "
        "fields_0001.nc ..., and a table of these files to fields_index.nc",
    )


class Scene(Model):
    """One scene: a body with its cracks, material, loads and grid.

    Exactly one of `geometry`, `family` and `mesh_file` defines the body. A family also defines the
    loads if its load parameter is given and `loads` is empty.
    """

    name: Name = Field(description="name of the scene and of its folder of results")
    description: Text = Field("", description="one line of text for the summary")
    geometry: Geometry | None = Field(
        None, description="the body, by its outline, holes, cracks and regions"
    )
    family: Family | None = Field(None, description="the body, as a specimen with parameters")
    mesh_file: MeshFile | None = Field(None, description="the body, as a gmsh mesh")
    material: Material = Field(description="material of the body outside the regions")
    plane: Literal["strain", "stress"] = Field("strain", description="plane strain or stress")
    kinematics: Literal["auto", "small", "finite"] = Field(
        "auto",
        description="small: small strain, one linear solve; finite: finite deformation, solved in "
        "load steps; auto: small strain, unless finite deformation would change the energy or J by "
        "more than 1 % (finite_effect, finite_effect_J); under plane stress or with growth, auto "
        "keeps small strain and warns",
    )
    formulation: Literal["total", "updated"] = Field(
        "total",
        description="total: the grid is the reference configuration; updated: the grid is reset "
        "after every load step and every segment release, as in the paper",
    )
    updated: Updated = Field(Updated(), description="options of formulation: updated")
    loads: list[Load] = Field(
        [], description="loads and supports; empty if the family defines them"
    )
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
        description="number of equal load steps, or list of load factors in their order; each is "
        "recorded. Intermediate steps are added as needed",
    )
    mesh: Mesh = Field(Mesh(), description="the background grid")
    solver: Annotated[str, OneOf(("auto", *SOLVERS))] = Field(
        "auto",
        description="linear solver; auto: the fastest one installed; superlu and amg are always "
        "installed",
    )
    fracture: Fracture = Field(Fracture(), description="evaluation at crack tips")
    growth: Growth | None = Field(
        None, description="crack growth; without this key cracks are stationary"
    )
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
            raise refusal(f"family.{key}", "is a load already; omit it or omit `loads`")
        elif not self.loads and self.family.load is None:
            key = self.family.load_key
            raise refusal("loads", f"no load: give family.{key}, or a list of loads")
        return self
