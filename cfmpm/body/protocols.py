"""What a load and a side of the boundary have to provide; those of a scene do."""

from __future__ import annotations

from typing import Any, Protocol

from cfmpm.body.grid import Floats

XY = tuple[float, float]


class GivenLoad(Protocol):
    """A load or a support: its place and what is prescribed there."""

    @property
    def name(self) -> str | None:
        """Name of the load."""

    @property
    def edge(self) -> str | None:
        """Named part of the boundary that it acts on."""

    @property
    def box(self) -> tuple[XY, XY] | None:
        """Two opposite corners [mm]: it acts on the part of the boundary inside."""

    @property
    def point(self) -> XY | None:
        """Point that it acts on [mm]."""

    @property
    def kind(self) -> str:
        """Word in `registry.loads` of what is prescribed."""

    @property
    def value(self) -> Any:
        """The prescribed value, of the type that its kind takes."""


class TrueSide(Protocol):
    """One side of the boundary as drawn: straight, or an arc that the grid has as chords."""

    @property
    def through(self) -> XY | None:
        """A point of the arc between its ends [mm]; None for a straight side."""

    @property
    def radius(self) -> float:
        """Radius of an arc [mm]."""

    @property
    def length(self) -> float:
        """Length along the side [mm]."""

    def distances(self, points: Floats) -> Floats:
        """Return the distances of points (n, 2) from the side [mm], (n,)."""
