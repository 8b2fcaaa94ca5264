"""What the families of specimens share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from cfmpm.scene.base import Model
from cfmpm.scene.body import Geometry, Vertex
from cfmpm.scene.loads import Load


class Specimen(Model, ABC):
    """Keys of a family of specimens, of which one may stand for the loads.

    Attributes
    ----------
    load_key : str
        The key that stands for the loads.
    """

    load_key: ClassVar[str] = "traction"

    @property
    def load(self) -> float | None:
        """The load parameter [MPa, or N/mm for a force]."""
        value: float | None = getattr(self, self.load_key)
        return value

    @abstractmethod
    def geometry(self) -> Geometry:
        """Return outline with named edges, holes and cracks [mm]."""

    @abstractmethod
    def loads(self) -> list[Load]:
        """Return the loads that the load parameter stands for; none where it is not given."""


def rectangle(width: float, height: float) -> list[Vertex]:
    """Return an outline from (0, 0) on, with edges bottom, right, top, left [mm]."""
    corners = {"bottom": (0, 0), "right": (width, 0), "top": (width, height), "left": (0, height)}
    return [Vertex(at=at, edge=edge) for edge, at in corners.items()]


def tension(traction: float | None) -> list[Load]:
    """Return tractions on top and bottom that pull on each other [MPa]."""
    if traction is None:
        return []
    return [
        Load(edge="top", traction=(0, traction)),
        Load(edge="bottom", traction=(0, -traction)),
    ]
