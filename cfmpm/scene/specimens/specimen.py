"""Base class and common parts of the families of specimens."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from cfmpm.scene.base import Model
from cfmpm.scene.body import Geometry, Vertex
from cfmpm.scene.loads import Load


class Specimen(Model, ABC):
    """Keys of a family of specimens, one of which defines the loads.

    Attributes
    ----------
    load_key : str
        Name of the key that defines the loads: the load parameter.
    """

    load_key: ClassVar[str] = "traction"

    @property
    def load(self) -> float | None:
        """Value of the load parameter [MPa, or N/mm for a force]; None if not given."""
        value: float | None = getattr(self, self.load_key)
        return value

    @abstractmethod
    def geometry(self) -> Geometry:
        """Return the outline with named edges, the holes and the cracks [mm]."""

    @abstractmethod
    def loads(self) -> list[Load]:
        """Return the loads that the load parameter defines; empty if it is not given."""


def rectangle(width: float, height: float) -> list[Vertex]:
    """Return the outline of a rectangle with edges bottom, right, top, left.

    Parameters
    ----------
    width, height : float
        [mm].

    Returns
    -------
    list of Vertex
        Four corners, anticlockwise from (0, 0).
    """
    corners = {"bottom": (0, 0), "right": (width, 0), "top": (width, height), "left": (0, height)}
    return [Vertex(at=at, edge=edge) for edge, at in corners.items()]


def tension(traction: float | None) -> list[Load]:
    """Return opposite normal tractions on top and bottom.

    Parameters
    ----------
    traction : float or None
        Positive in tension [MPa].

    Returns
    -------
    list of Load
        Empty if `traction` is None.
    """
    if traction is None:
        return []
    return [
        Load(edge="top", traction=(0, traction)),
        Load(edge="bottom", traction=(0, -traction)),
    ]
