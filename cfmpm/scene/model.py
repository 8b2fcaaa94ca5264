"""The description of one scene as typed, frozen models.

Units throughout: mm, N, MPa, N/mm; forces are per mm of thickness. A scene is read from YAML by
:mod:`cfmpm.scene.reading`; its geometry is checked by :mod:`cfmpm.scene.geometry`.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator


def _number(value: Any) -> Any:
    """Refuse booleans and non-finite numbers, which pydantic would take for floats."""
    if isinstance(value, bool):
        raise ValueError("must be a number, not true or false")
    if isinstance(value, str | int | float):
        try:
            number = float(value)
        except ValueError:
            raise ValueError("must be a number") from None
        if not math.isfinite(number):
            raise ValueError("must be a finite number")
        return number
    raise ValueError("must be a number")


Number = Annotated[float, BeforeValidator(_number)]
Positive = Annotated[Number, Field(gt=0)]
Vector = tuple[Number, Number]
Point = tuple[Number, Number]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]*$", max_length=64)]


class Model(BaseModel):
    """A frozen model that refuses unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Material(Model):
    """A linear elastic, isotropic material."""

    E: Positive = Field(description="Young's modulus [MPa]")
    nu: Annotated[Number, Field(gt=-1, lt=0.5)] = Field(description="Poisson's ratio")
    g_c: Positive | None = Field(None, description="critical energy release rate [N/mm]")


class Vertex(Model):
    """A corner of a closed line, and the edge that leaves it."""

    at: Point = Field(description="coordinates [mm]")
    edge: Name | None = Field(None, description="name of the edge that leaves this corner")
    through: Point | None = Field(
        None, description="a point on the edge [mm], which makes the edge a circular arc"
    )


def _vertex(value: Any) -> Any:
    return {"at": value} if isinstance(value, list | tuple) else value


Corner = Annotated[Vertex, BeforeValidator(_vertex)]


class Circle(Model):
    """A circle."""

    centre: Point = Field(description="coordinates [mm]")
    radius: Positive = Field(description="radius [mm]")


class Hole(Model):
    """A hole; its whole boundary is one named edge."""

    name: Name | None = Field(None, description="name of the hole's edge; default hole_1, hole_2 ...")
    circle: Circle | None = None
    polygon: list[Corner] | None = Field(None, description="corners of a closed line")


class Region(Model):
    """A part of the body with a material of its own."""

    name: Name = Field(description="name; with a mesh file, the name of a physical surface")
    material: Material
    circle: Circle | None = None
    polygon: list[Corner] | None = Field(None, description="corners of a closed line")


class Crack(Model):
    """A crack; each end inside the body is a tip, each end on an edge or a hole is a mouth."""

    name: Name | None = Field(None, description="default crack_1, crack_2 ...")
    points: list[Point] = Field(min_length=2, description="corners of the crack line [mm]")


class Geometry(Model):
    """A plane body: outline, holes, cracks, regions."""

    outline: list[Corner] = Field(min_length=2, description="corners of the outline, either sense")
    holes: list[Hole] = []
    cracks: list[Crack] = []
    regions: list[Region] = []


class MeshFile(Model):
    """A gmsh mesh of three-node triangles in place of a geometry."""

    file: str = Field(description="path of the .msh file, relative to the scene file")
    cracks: list[Name] = Field([], description="physical curves to be opened as cracks")
    regions: list[Region] = Field([], description="materials of physical surfaces")


class SingleEdge(Model):
    """Rectangle with an edge crack from the left side; edges bottom, right, top, left."""

    kind: Literal["single_edge"]
    width: Positive
    height: Positive
    crack_length: Positive
    crack_height: Positive | None = Field(None, description="default: half the height")
    traction: Number | None = Field(None, description="tension on top and bottom [MPa]")


class CentreCrack(Model):
    """Rectangle with a central crack of two tips; edges bottom, right, top, left."""

    kind: Literal["centre_crack"]
    width: Positive
    height: Positive
    crack_length: Positive = Field(description="from tip to tip [mm]")
    crack_angle: Annotated[Number, Field(ge=-90, le=90)] = Field(
        0.0, description="from the x axis, anticlockwise [deg]"
    )
    traction: Number | None = Field(None, description="tension on top and bottom [MPa]")


class CompactTension(Model):
    """Compact tension specimen (ASTM E399 proportions); pin holes pin_top and pin_bottom."""

    kind: Literal["compact_tension"]
    width: Positive = Field(description="W, from the load line to the back face [mm]")
    crack_length: Positive = Field(description="a, from the load line [mm]")
    force: Number | None = Field(None, description="pull on the pins per thickness [N/mm]")


class ThreePointBend(Model):
    """Beam on two supports, force at the middle of the top; crack from the bottom."""

    kind: Literal["three_point_bend"]
    length: Positive
    height: Positive
    span: Positive = Field(description="distance of the supports [mm]")
    crack_length: Positive
    crack_offset: Number = Field(0.0, description="of the crack from midspan, positive right [mm]")
    holes: list[Circle] = []
    force: Number | None = Field(None, description="downward per thickness [N/mm]")


class PlateWithHoles(Model):
    """Rectangle with circular holes and cracks; edges bottom, right, top, left, hole_1 ..."""

    kind: Literal["plate_with_holes"]
    width: Positive
    height: Positive
    holes: list[Circle] = Field(min_length=1)
    cracks: list[Crack] = []
    traction: Number | None = Field(None, description="tension on top and bottom [MPa]")


Family = Annotated[
    SingleEdge | CentreCrack | CompactTension | ThreePointBend | PlateWithHoles,
    Field(discriminator="kind"),
]


class Components(Model):
    """Prescribed displacement; a component that is left out is free."""

    x: Number | None = Field(None, description="[mm]")
    y: Number | None = Field(None, description="[mm]")


class Load(Model):
    """One load or support: a place (edge, box or point) and what is prescribed there."""

    name: Name | None = Field(None, description="default: the edge's name, or load_1, load_2 ...")
    edge: Name | None = Field(None, description="a named edge or hole")
    box: tuple[Point, Point] | None = Field(
        None, description="two opposite corners [mm]: the part of the boundary inside"
    )
    point: Point | None = Field(None, description="becomes a node of the grid [mm]")
    displacement: Components | None = Field(None, description="on an edge, a box or a point [mm]")
    traction: Vector | None = Field(None, description="on an edge or a box [MPa]")
    force: Vector | None = Field(None, description="on a point, per thickness [N/mm]")
    body_force: Vector | None = Field(None, description="in the whole body [N/mm^3]")


class Grading(Model):
    """Element size min(size, tip_size + growth r) at distance r from the nearest crack tip."""

    tip_size: Positive = Field(description="element size at a crack tip [mm]")
    growth: Positive = Field(0.3, description="element size per distance from the tip")


class Mesh(Model):
    """The background grid."""

    element: Literal["T3", "T6"] = Field("T6", description="T3: 1 point, T6: 3 points a triangle")
    size: Positive | None = Field(None, description="element size [mm]; default from the body")
    grading: Grading | Literal["auto", "uniform"] = Field(
        "auto", description="towards crack tips: auto, uniform, or two numbers"
    )


class Fracture(Model):
    """What is evaluated at the crack tips."""

    radii: Annotated[int, Field(ge=1, le=20)] | list[Positive] = Field(
        1, description="domain radii [mm], or how many are to be chosen; the spread needs two"
    )


class Output(Model):
    """What is written besides the history."""

    fields: bool = Field(False, description="displacement, stress and CF vectors on the grid")


class Scene(Model):
    """One scene: a body with its cracks, material, loads and grid.

    Exactly one of `geometry`, `family` and `mesh_file` gives the body. A family also gives the
    loads, when its load parameter is set and `loads` is empty.
    """

    name: Name
    description: str = ""
    geometry: Geometry | None = None
    family: Family | None = None
    mesh_file: MeshFile | None = None
    material: Material = Field(description="of the body, where no region says otherwise")
    plane: Literal["strain", "stress"] = "strain"
    loads: list[Load] = []
    mesh: Mesh = Mesh()
    solver: Literal["auto", "cholmod", "superlu", "amg"] = "auto"
    fracture: Fracture = Fracture()
    output: Output = Output()

    @model_validator(mode="after")
    def _one_body(self) -> Self:
        given = [k for k in ("geometry", "family", "mesh_file") if getattr(self, k) is not None]
        if len(given) != 1:
            raise ValueError(
                "exactly one of geometry, family, mesh_file is needed; given: "
                + (", ".join(given) or "none")
            )
        return self
