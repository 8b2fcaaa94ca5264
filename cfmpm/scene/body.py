"""Keys of a body: outline, holes, cracks, regions, or a mesh file."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from typing import Annotated, Any, Self

from pydantic import (
    BeforeValidator,
    Field,
    model_validator,
)

from cfmpm.input_file import open_file
from cfmpm.scene.base import Model, refusal
from cfmpm.scene.material import Material
from cfmpm.scene.quantities import (
    LARGEST_LENGTH,
    Coordinate,
    GroupName,
    Length,
    Name,
    Number,
    Point,
    Text,
)


def _vertex(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return {"at": value}
    if isinstance(value, Mapping | Vertex):
        return value
    raise ValueError("must be two numbers in brackets, or a mapping with at")


class Vertex(Model):
    """A corner of a closed line, and the edge from this corner to the next."""

    at: Point = Field(description="coordinates [mm]")
    edge: Name | None = Field(None, description="name of the edge from this corner to the next")
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
            raise refusal("", "needs a circle or a polygon, and not both")
        return self


class Region(Model):
    """A part of the body with another material."""

    name: GroupName = Field(description="name; with a mesh file, the name of a physical surface")
    material: Material
    circle: Circle | None = None
    polygon: list[Corner] | None = Field(None, description="corners of a closed line")


class Crack(Model):
    """A crack; each end inside the body is a tip, each end on an edge or a hole is a mouth."""

    name: Name | None = Field(None, description="name of the crack; default crack_1, crack_2 ...")
    points: list[Point] = Field(min_length=2, description="corners of the crack line [mm]")
    uncounted: Annotated[Number, Field(ge=0, le=LARGEST_LENGTH)] = Field(
        0.0,
        description="length of the line from its first point on that crack_length leaves out [mm], "
        "such as that from the edge to the load line of a compact tension specimen",
    )


class Geometry(Model):
    """A plane body: outline, holes, cracks, regions.

    Consecutive sides of the outline may share a name; together they are one edge.
    """

    outline: list[Corner] = Field(
        min_length=2, description="corners of the outline, clockwise or anticlockwise"
    )
    holes: list[Hole] = Field([], description="circles or polygons without material")
    cracks: list[Crack] = Field([], description="lines, each with one or two tips")
    regions: list[Region] = Field([], description="parts of other materials")


class MeshFile(Model):
    """A gmsh mesh of triangles in place of a geometry.

    Format 1, 2 or 4, as text or binary. Physical groups are taken by their names, which may be any
    text; one without a name is called curve_3 or surface_3 by its number. What no physical curve
    names of the boundary is the edge boundary. The keys size, grading and hole_size of mesh have
    no place beside it. A crack that is open in the file (lips of coincident nodes, as gmsh's
    plugin Crack makes them) ends where its lips meet.
    """

    file: Text = Field(min_length=1, description="path of the .msh file")
    folder: Text = Field(
        ".", description="folder of a relative path; itself relative to the scene file"
    )
    sha256: Text | None = Field(
        None, description="SHA-256 of the file; filled in when the scene is read"
    )
    cracks: list[GroupName] = Field(
        [], description="physical curves that are cracks, closed in the file or open"
    )
    regions: list[Region] = Field([], description="materials of physical surfaces")

    def digest(self) -> str:
        """SHA-256 of the current contents of the file."""
        with open_file(self.path) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()

    @property
    def path(self) -> str:
        """Where the file is, once the scene has been read."""
        return os.path.join(self.folder, self.file)
