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
    """A corner of a closed line, and the side from this corner to the next."""

    at: Point = Field(description="coordinates [mm]")
    edge: Name | None = Field(
        None, description="edge to which the side from this corner to the next belongs"
    )
    through: Point | None = Field(
        None,
        description="a third point of the side [mm]; with it the side is a circular arc, without "
        "it a straight line",
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
            raise refusal("", "needs either a circle or a polygon")
        return self


class Region(Model):
    """A part of the body with another material."""

    name: GroupName = Field(description="name; with a mesh file, the name of a physical surface")
    material: Material
    circle: Circle | None = None
    polygon: list[Corner] | None = Field(None, description="corners of a closed line")


class Crack(Model):
    """A crack; an end inside the body is a crack tip, an end on an edge or a hole a crack mouth.

    Cracks that cross or touch each other, or cut the body in two, are refused.
    """

    name: Name | None = Field(None, description="name of the crack; default crack_1, crack_2 ...")
    points: list[Point] = Field(min_length=2, description="corners of the crack line [mm]")
    uncounted: Annotated[Number, Field(ge=0, le=LARGEST_LENGTH)] = Field(
        0.0,
        description="length from the first point that crack_length does not count [mm], such as "
        "the distance from the edge to the load line of a compact tension specimen",
    )


class Geometry(Model):
    """A plane body: outline, holes, cracks, regions.

    Consecutive sides of the outline with the same name are one edge.
    """

    outline: list[Corner] = Field(
        min_length=2, description="corners of the outline, clockwise or anticlockwise"
    )
    holes: list[Hole] = Field([], description="circles or polygons without material")
    cracks: list[Crack] = Field([], description="lines with up to two tips each")
    regions: list[Region] = Field([], description="parts of the body with other materials")


class MeshFile(Model):
    """A gmsh mesh of triangles in place of a geometry.

    Format 1, 2 or 4, as text or binary. The names of physical groups may be any text; a group
    without a name is called curve_3 or surface_3 by its number. Parts of the boundary without a
    physical curve form the edge boundary. The keys size, grading and hole_size of mesh do not go
    with a mesh file. A crack can be open in the file (two faces with coincident nodes, as gmsh's
    plugin Crack makes them); its tip is the node at which its faces meet.
    """

    file: Text = Field(min_length=1, description="path of the .msh file")
    folder: Text = Field(
        ".", description="folder of a relative `file`; a relative folder starts at the scene file"
    )
    sha256: Text | None = Field(
        None, description="SHA-256 of the file; filled in when the scene is read"
    )
    cracks: list[GroupName] = Field(
        [], description="physical curves that are cracks, open or closed in the file"
    )
    regions: list[Region] = Field([], description="materials of physical surfaces")

    def digest(self) -> str:
        """Compute the SHA-256 of the current contents of the file.

        Returns
        -------
        str
            Hexadecimal digits.

        Raises
        ------
        OSError
            If the file cannot be read.
        """
        with open_file(self.path) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()

    @property
    def path(self) -> str:
        """Path of the file; absolute after the scene has been read."""
        return os.path.join(self.folder, self.file)
