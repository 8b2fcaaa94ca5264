"""The place of a load, and its nodal values there."""

from __future__ import annotations

from dataclasses import dataclass

from cfmpm.body.boundary import Segments
from cfmpm.body.grid import Floats, Ints


@dataclass(frozen=True)
class Place:
    """The place of a load or a support.

    Attributes
    ----------
    nodes : (k,) int
        Empty for the whole body.
    weights : (k,) float
        Integrals of their basis functions along the boundary [mm]; 1 at a point.
    segments : Segments or None
        The parts of the boundary; None for a point and for the whole body.
    """

    nodes: Ints
    weights: Floats
    segments: Segments | None = None


@dataclass(frozen=True)
class Applied:
    """Nodal values of one load, at load factor one.

    Attributes
    ----------
    force : (k, 2) float or None
        Forces on the nodes of its place [N/mm].
    displacement : (k, 2) float or None
        Prescribed displacement of these nodes [mm]; nan for a free component.
    density : (2,) float or None
        Body force in the whole body [N/mm^3].
    """

    force: Floats | None = None
    displacement: Floats | None = None
    density: Floats | None = None
