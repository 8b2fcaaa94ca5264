"""Where a load acts, and what it comes to at the nodes there."""

from __future__ import annotations

from dataclasses import dataclass

from cfmpm.body.boundary import Segments
from cfmpm.body.grid import Floats, Ints


@dataclass(frozen=True)
class Place:
    """Where a load or a support acts.

    Attributes
    ----------
    nodes : (k,) int
        None for the whole body.
    weights : (k,) float
        Integrals of their basis functions along the boundary [mm]; 1 at a point.
    segments : Segments or None
        The parts of the boundary; None at a point and for the whole body.
    """

    nodes: Ints
    weights: Floats
    segments: Segments | None = None


@dataclass(frozen=True)
class Applied:
    """What one load comes to, at load factor one.

    Attributes
    ----------
    force : (k, 2) float or None
        On the nodes of its place [N/mm].
    displacement : (k, 2) float or None
        Prescribed to them [mm]; nan where a component is free.
    density : (2,) float or None
        Body force in the whole body [N/mm^3].
    """

    force: Floats | None = None
    displacement: Floats | None = None
    density: Floats | None = None
