"""The description of one scene as typed, frozen models.

Units throughout: mm, N, MPa, N/mm; forces are per mm of thickness. A scene is read from YAML by
:mod:`cfmpm.scene.reading`; what goes beyond its fields is checked by :mod:`cfmpm.scene.rules`.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    model_validator,
)
from pydantic_core import PydanticCustomError

from cfmpm.scene.quantities import (
    LARGEST_LENGTH,
    Coordinate,
    Count,
    Length,
    Name,
    Number,
    Point,
    Positive,
    Vector,
)


def _box(value: Any) -> Any:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise ValueError("must be two opposite corners, such as [[0, 0], [10, 5]]")
    return value


def _vertex(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return {"at": value}
    if isinstance(value, Mapping | Vertex):
        return value
    raise ValueError("must be two numbers in brackets, or a mapping with at")


def _refusal(key: str, reason: str) -> PydanticCustomError:
    """What a model's validator raises; `key` names the field at fault, "" the model itself."""
    return PydanticCustomError("refused", "{reason}", {"key": key, "reason": reason})


class Model(BaseModel):
    """A frozen model that refuses unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Material(Model):
    """An isotropic material; at small strain every elastic law is that of Hooke."""

    E: Positive = Field(description="Young's modulus [MPa]")
    nu: Annotated[Number, Field(gt=-1, lt=0.5)] = Field(description="Poisson's ratio")
    g_c: Positive | None = Field(None, description="critical energy release rate [N/mm]")
    law: Literal["hencky", "ciarlet", "neo_hookean", "j2"] = Field(
        "hencky",
        description="at finite deformation: hencky is the paper's, and loses ellipticity at "
        "stretches of 2 to 3; ciarlet is a neo-Hookean law that keeps it; neo_hookean has "
        "lambda/2 (ln J)^2 instead; j2 is Hencky elasticity with a yield stress",
    )
    yield_stress: Positive | None = Field(None, description="of j2 [MPa]")
    hardening: Annotated[Number, Field(ge=0)] = Field(
        0.0, description="of j2: yield stress gained per plastic strain [MPa]"
    )

    @model_validator(mode="after")
    def _yields_where_plastic(self) -> Self:
        if self.law == "j2" and self.yield_stress is None:
            raise _refusal("yield_stress", "is missing: the law j2 needs it")
        if self.law != "j2" and self.yield_stress is not None:
            raise _refusal("yield_stress", f"does not fit: the law {self.law} is elastic")
        if self.law != "j2" and self.hardening:
            raise _refusal("hardening", f"does not fit: the law {self.law} is elastic")
        return self


class Vertex(Model):
    """A corner of a closed line, and the edge that leaves it."""

    at: Point = Field(description="coordinates [mm]")
    edge: Name | None = Field(None, description="name of the edge that leaves this corner")
    through: Point | None = Field(
        None, description="a point on the edge [mm], which makes the edge a circular arc"
    )


Corner = Annotated[
    Vertex,
    BeforeValidator(_vertex, json_schema_input_type=Vertex | tuple[Coordinate, Coordinate]),
]


class Circle(Model):
    """A circle."""

    centre: Point = Field(description="coordinates [mm]")
    radius: Length = Field(description="radius [mm]")


class Hole(Model):
    """A hole, either a circle or a polygon; its whole boundary is one named edge."""

    name: Name | None = Field(
        None, description="name of the hole's edge; default hole_1, hole_2 ..."
    )
    circle: Circle | None = None
    polygon: list[Corner] | None = Field(None, description="corners of a closed line")

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        if (self.circle is None) == (self.polygon is None):
            raise _refusal("", "needs a circle or a polygon, and not both")
        return self


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
    """A plane body: outline, holes, cracks, regions.

    Sides of the outline that follow each other may share a name: together they are one edge.
    """

    outline: list[Corner] = Field(min_length=2, description="corners of the outline, either sense")
    holes: list[Hole] = Field([], description="circles or polygons without material")
    cracks: list[Crack] = Field([], description="lines, each with one or two tips")
    regions: list[Region] = Field([], description="parts of other materials")


class MeshFile(Model):
    """A gmsh mesh of three-node triangles in place of a geometry."""

    file: str = Field(min_length=1, description="path of the .msh file")
    folder: str = Field(
        ".", description="where a relative path starts: itself relative to the scene file"
    )
    sha256: str | None = Field(
        None, description="of what is in the file: filled in as the scene is read"
    )
    cracks: list[Name] = Field([], description="physical curves to be opened as cracks")
    regions: list[Region] = Field([], description="materials of physical surfaces")

    def digest(self) -> str:
        """SHA-256 of what is in the file now."""
        return hashlib.sha256(Path(self.path).read_bytes()).hexdigest()

    @property
    def path(self) -> str:
        """Where the file is, once the scene has been read."""
        return os.path.join(self.folder, self.file)


class Specimen(Model):
    """What the families share: the parameter that stands for the loads."""

    load_key: ClassVar[str] = "traction"

    @property
    def load(self) -> float | None:
        """The load parameter [MPa, or N/mm for a force]."""
        value: float | None = getattr(self, self.load_key)
        return value


class SingleEdge(Specimen):
    """Rectangle with an edge crack from the left side; edges bottom, right, top, left."""

    kind: Literal["single_edge"]
    width: Length = Field(description="[mm]")
    height: Length = Field(description="[mm]")
    crack_length: Length = Field(description="[mm]")
    crack_height: Length | None = Field(None, description="[mm]; default: half the height")
    traction: Number | None = Field(None, description="tension on top and bottom [MPa]")

    @model_validator(mode="after")
    def _crack_inside(self) -> Self:
        if self.crack_length >= self.width:
            raise _refusal("crack_length", f"must be less than the width, {self.width:g}")
        if self.crack_height is not None and self.crack_height >= self.height:
            raise _refusal("crack_height", f"must be less than the height, {self.height:g}")
        return self


class CentreCrack(Specimen):
    """Rectangle with a central crack of two tips; edges bottom, right, top, left."""

    kind: Literal["centre_crack"]
    width: Length = Field(description="[mm]")
    height: Length = Field(description="[mm]")
    crack_length: Length = Field(description="from tip to tip [mm]")
    crack_angle: Annotated[Number, Field(ge=-90, le=90)] = Field(
        0.0, description="from the x axis, anticlockwise [deg]"
    )
    traction: Number | None = Field(None, description="tension on top and bottom [MPa]")


class CompactTension(Specimen):
    """Compact tension specimen (ASTM E399 proportions); pin holes pin_top and pin_bottom."""

    load_key: ClassVar[str] = "force"

    kind: Literal["compact_tension"]
    width: Length = Field(description="W, from the load line to the back face [mm]")
    crack_length: Length = Field(description="a, from the load line [mm]")
    force: Number | None = Field(None, description="pull on the pins per thickness [N/mm]")

    @model_validator(mode="after")
    def _crack_inside(self) -> Self:
        if self.crack_length >= self.width:
            raise _refusal("crack_length", f"must be less than the width, {self.width:g}")
        return self


class ThreePointBend(Specimen):
    """Beam on two supports, force at the middle of the top; crack from the bottom.

    With `loads` in place of `force`, the supports are among the loads too.
    """

    load_key: ClassVar[str] = "force"

    kind: Literal["three_point_bend"]
    length: Length = Field(description="[mm]")
    height: Length = Field(description="[mm]")
    span: Length = Field(description="distance of the supports [mm]")
    crack_length: Length = Field(description="[mm]")
    crack_offset: Coordinate = Field(
        0.0, description="of the crack from midspan, positive right [mm]"
    )
    holes: list[Circle] = []
    force: Number | None = Field(None, description="downward per thickness [N/mm]")

    @model_validator(mode="after")
    def _inside(self) -> Self:
        if self.span > self.length:
            raise _refusal("span", f"must be at most the length, {self.length:g}")
        if self.crack_length >= self.height:
            raise _refusal("crack_length", f"must be less than the height, {self.height:g}")
        if abs(self.crack_offset) >= self.length / 2:
            raise _refusal(
                "crack_offset", f"must be less than half the length, {self.length / 2:g}"
            )
        return self


class PlateWithHoles(Specimen):
    """Rectangle with circular holes and cracks; edges bottom, right, top, left, hole_1 ..."""

    kind: Literal["plate_with_holes"]
    width: Length = Field(description="[mm]")
    height: Length = Field(description="[mm]")
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

    @model_validator(mode="after")
    def _something(self) -> Self:
        if self.x is None and self.y is None:
            raise _refusal("", "needs x or y or both; a component that is left out is free")
        return self


class Load(Model):
    """One load or support: a place (edge, box or point) and what is prescribed there.

    A displacement goes with any place, a traction with an edge or a box, a force with a point; a
    body force has no place.
    """

    name: Name | None = Field(None, description="default: the edge's name, or load_1, load_2 ...")
    edge: Name | None = Field(None, description="a named edge or hole")
    box: Annotated[tuple[Point, Point], BeforeValidator(_box)] | None = Field(
        None, description="two opposite corners [mm]: the part of the boundary inside"
    )
    point: Point | None = Field(None, description="becomes a node of the grid [mm]")
    displacement: Components | None = Field(None, description="on an edge, a box or a point [mm]")
    traction: Vector | None = Field(None, description="on an edge or a box [MPa]")
    force: Vector | None = Field(None, description="on a point, per thickness [N/mm]")
    body_force: Vector | None = Field(None, description="in the whole body [N/mm^3]")

    PLACES_OF: ClassVar[dict[str, tuple[str, ...]]] = {
        "displacement": ("edge", "box", "point"),
        "traction": ("edge", "box"),
        "force": ("point",),
        "body_force": (),
    }

    @model_validator(mode="after")
    def _one_place_and_one_action(self) -> Self:
        actions = [key for key in self.PLACES_OF if getattr(self, key) is not None]
        places = [key for key in ("edge", "box", "point") if getattr(self, key) is not None]
        if len(actions) != 1:
            given = f"has {' and '.join(actions)}; give each a load of its own"
            raise _refusal(
                "", f"needs one of {', '.join(self.PLACES_OF)}" if not actions else given
            )
        (action,) = actions
        allowed = self.PLACES_OF[action]
        for place in places:
            if place not in allowed:
                fits = f"goes with {' or '.join(allowed)}" if allowed else "has no place"
                raise _refusal(place, f"does not fit: a {action} {fits}")
        if allowed and len(places) != 1:
            given = f"has {' and '.join(places)}; one place is needed" if places else "has no place"
            raise _refusal("", f"{given}: a {action} goes with {' or '.join(allowed)}")
        return self


class Grading(Model):
    """Element size min(size, tip_size + growth r) at distance r from the nearest crack tip."""

    tip_size: Length = Field(description="element size at a crack tip [mm]")
    growth: Positive = Field(0.3, description="element size per distance from the tip")


def _numbers_or_word(value: Any) -> str:
    return "(numbers)" if isinstance(value, Mapping | Grading) else "(word)"


def _word(value: Any) -> Any:
    if value not in ("auto", "uniform"):
        raise ValueError("must be auto, uniform, or a mapping with tip_size and growth")
    return value


class Mesh(Model):
    """The background grid."""

    element: Literal["T3", "T6"] = Field("T6", description="T3: 1 point, T6: 3 points a triangle")
    size: Length | None = Field(
        None, description="element size [mm]; default: a twentieth of the root of the body's area"
    )
    grading: Annotated[
        Annotated[Grading, Tag("(numbers)")]
        | Annotated[Literal["auto", "uniform"], BeforeValidator(_word), Tag("(word)")],
        Discriminator(_numbers_or_word),
    ] = Field(
        "auto",
        description="towards crack tips: uniform, two numbers, or auto: size / 300 at a tip at "
        "rest, with growth 0.4, size / 10 at one that runs, with 0.3; less where there is no room",
    )
    hole_size: Length | None = Field(
        None,
        description="element size at holes [mm]: a third of the ligament through which a crack is "
        "to pass; it grows away from them as from the tips",
    )

    @model_validator(mode="after")
    def _finer_at_tips_and_holes(self) -> Self:
        size = self.size or LARGEST_LENGTH
        if isinstance(self.grading, Grading) and self.grading.tip_size > size:
            raise _refusal("grading.tip_size", f"must be at most mesh.size, {size:g}")
        if self.hole_size is not None and self.hole_size > size:
            raise _refusal("hole_size", f"must be at most mesh.size, {size:g}")
        return self


def _list_or_count(value: Any) -> str:
    return "(list)" if isinstance(value, list | tuple) else "(count)"


def _one_after_the_other(factors: list[float]) -> list[float]:
    if any(a == b for a, b in zip([0.0, *factors], factors, strict=False)):
        raise ValueError("each must differ from the one before it, the first from zero")
    return factors


class Fracture(Model):
    """What is evaluated at the crack tips."""

    radii: Annotated[
        Annotated[Count, Field(ge=1, le=20), Tag("(count)")]
        | Annotated[list[Length], Field(min_length=1, max_length=20), Tag("(list)")],
        Discriminator(_list_or_count),
    ] = Field(
        1, description="domain radii [mm], or how many are to be chosen; the spread needs two"
    )
    refine: Length | None = Field(
        None,
        description="largest element at a tip that runs [mm]: before each release larger ones "
        "around it are halved, up to 0.3 of the distance further away; left out: a tenth of "
        "mesh.size or a twentieth of the crack with mesh.grading: auto, else none are",
    )

    @model_validator(mode="after")
    def _different(self) -> Self:
        if isinstance(self.radii, list) and len(set(self.radii)) < len(self.radii):
            raise _refusal("radii", "must differ from each other")
        return self


class Growth(Model):
    """How the cracks grow."""

    control: Literal["load", "crack", "fatigue"] = Field(
        "load",
        description="load: at the load of the scene, until no tip runs; crack: at the load that "
        "makes the criterion just met, increment by increment; fatigue: by cycles of load up to "
        "that of the scene, until the criterion is met",
    )
    criterion: Literal["energy_release_rate", "cf_norm"] = Field(
        "energy_release_rate", description="what is compared with g_c; cf_norm is the paper's"
    )
    direction: Literal["max_hoop", "max_energy", "cf"] = Field(
        "max_hoop", description="where a crack turns to; cf is the paper's"
    )
    order: Literal[1, 2] = Field(
        1,
        description="1: segments along the tangent of the path, as the paper; 2: along its secant, "
        "extrapolated from the last two tangents: better on smooth curves, restless on paths that "
        "run straight or pass close by a hole",
    )
    tips: Literal["all", "largest"] = Field(
        "all",
        description="which of the tips that meet the criterion run in an increment: all of them, "
        "each as the one solve before it tells, or the largest alone",
    )
    transfer: Literal["domains", "paper"] = Field(
        "domains",
        description="how material points follow the moving grid: by the exact parts of their "
        "domains, or, as the paper does, by point and unchanged volume",
    )
    increments: Annotated[Count, Field(ge=1, le=100_000)] = Field(
        500, description="after how many increments to end at the latest"
    )


class Fatigue(Model):
    """Paris' law, for cycles of load between load_ratio and one times the loads of the scene."""

    C: Positive = Field(
        description="of da/dN = C dK^m [mm/cycle / (MPa mm^0.5)^m]; from m/cycle and MPa m^0.5: "
        "times 1000 / 1000^(m/2)"
    )
    m: Positive = Field(description="exponent of dK = (1 - load_ratio) sqrt(K_I^2 + K_II^2)")
    threshold: Annotated[Number, Field(ge=0)] = Field(
        0.0, description="dK at and below which a tip does not advance [MPa mm^0.5]"
    )
    load_ratio: Annotated[Number, Field(ge=0, lt=1)] = Field(
        0.0, description="least load over greatest"
    )


class Updated(Model):
    """How the updated Lagrangian formulation resets its grid."""

    grid: Literal["fixed", "following"] = Field(
        "fixed",
        description="fixed: back to where it was after every load step, as the paper does; "
        "following, which needs mesh.element: T3: boundary, crack faces and tips stay with the "
        "material, and the inside is smoothed where its triangles become bad",
    )
    integration: Literal["points", "domains"] = Field(
        "points",
        description="points: each material point where it is, with its volume, as the paper does; "
        "domains, which needs mesh.element: T3 and no law: j2: by the exact parts of its domain in "
        "the triangles of the grid",
    )
    ghost: Annotated[Number, Field(ge=0)] = Field(
        0.0,
        description="stabilisation of triangles that hold little material: this times E h^2 times "
        "the squared jump of the normal gradient across their sides; 0.1 is enough; needs "
        "mesh.element: T3",
    )
    smooth_below: Annotated[Number, Field(ge=0, le=1)] = Field(
        0.2,
        description="quality of a triangle of a following grid below which it is smoothed: 1 is "
        "equilateral, 0 flat; 1 smooths after every step, 0 never",
    )
    margin: Length | None = Field(
        None,
        description="of a fixed grid around the body, into which it may move [mm]; default from "
        "the prescribed displacement",
    )


class Output(Model):
    """What is written besides the history."""

    fields: bool = Field(
        False, description="displacement, stress and CF vectors on the grid at the end: fields.nc"
    )
    every: Annotated[Count, Field(ge=1)] | None = Field(
        None,
        description="the same at the first step of a growing crack, every so many steps on, and "
        "the last: fields_0001.nc ..., with a table of them, fields_index.nc",
    )


class Scene(Model):
    """One scene: a body with its cracks, material, loads and grid.

    Exactly one of `geometry`, `family` and `mesh_file` gives the body. A family also gives the
    loads, when its load parameter is set and `loads` is empty.
    """

    name: Name = Field(description="of the scene, and of its folder in results")
    description: str = Field("", description="a line for people")
    geometry: Geometry | None = Field(None, description="the body by its lines")
    family: Family | None = Field(None, description="the body as a specimen with parameters")
    mesh_file: MeshFile | None = Field(None, description="the body as a mesh of gmsh")
    material: Material = Field(description="of the body, where no region says otherwise")
    plane: Literal["strain", "stress"] = Field("strain", description="plane strain or stress")
    kinematics: Literal["auto", "small", "finite"] = Field(
        "auto",
        description="small: one linear solve; finite: finite deformation, solved in load steps; "
        "auto: small, unless finite would change the energy by more than 1 % (finite_effect); "
        "plane stress and growth stay small, with a warning",
    )
    formulation: Literal["total", "updated"] = Field(
        "total",
        description="total: all is in the reference configuration; updated: the grid is reset "
        "after every load step, as the paper does",
    )
    updated: Updated = Field(Updated(), description="how, with formulation: updated")
    loads: list[Load] = Field([], description="loads and supports; empty where a family has them")
    load_steps: Annotated[
        Annotated[Count, Field(ge=1, le=100_000), Tag("(count)")]
        | Annotated[
            list[Number],
            Field(min_length=1, max_length=100_000),
            AfterValidator(_one_after_the_other),
            Tag("(list)"),
        ],
        Discriminator(_list_or_count),
    ] = Field(
        1,
        description="how many equal parts the loads are applied in, or the factors on them, one "
        "after the other; each is recorded. Steps in between are taken as needed",
    )
    mesh: Mesh = Field(Mesh(), description="the background grid")
    solver: Literal["auto", "cholmod", "rslab", "superlu", "amg"] = Field(
        "auto", description="auto: the fastest that is installed; superlu or amg always are"
    )
    fracture: Fracture = Field(Fracture(), description="what is evaluated at crack tips")
    growth: Growth | None = Field(None, description="left out: the cracks do not grow")
    fatigue: Fatigue | None = Field(None, description="goes with growth.control: fatigue")
    output: Output = Field(Output(), description="what is written besides the history")

    @model_validator(mode="after")
    def _one_body(self) -> Self:
        given = [k for k in ("geometry", "family", "mesh_file") if getattr(self, k) is not None]
        if len(given) != 1:
            have = "has " + " and ".join(given) if given else "has no body"
            raise _refusal("", f"{have}: exactly one of geometry, family, mesh_file is needed")
        return self

    @model_validator(mode="after")
    def _loaded_once(self) -> Self:
        if self.family is None:
            if not self.loads:
                raise _refusal("loads", "no load: nothing is prescribed")
        elif self.loads and self.family.load is not None:
            key = self.family.load_key
            raise _refusal(f"family.{key}", "is a load already; leave it out or leave out `loads`")
        elif not self.loads and self.family.load is None:
            key = self.family.load_key
            raise _refusal("loads", f"no load: give family.{key}, or a list of loads")
        return self
