"""The body that is solved: grid, material points, loads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from cfmpm.body.grid import Grid, Triangulation, build_grid
from cfmpm.body.loads import Loading
from cfmpm.body.materials import Materials
from cfmpm.body.motion import Motion
from cfmpm.body.particle_domains import ParticleDomains, Quadrature, as_points
from cfmpm.body.points import MOVED_OFF, MaterialPoints, relocate
from cfmpm.body.tip_domains import TipDomain
from cfmpm.body.volume_patches import Patches
from cfmpm.elements.record import Element


@dataclass(frozen=True)
class Grown:
    """What growth has done to a body.

    Attributes
    ----------
    quality : float
        Of the worst triangle that it has changed so far; 1 equilateral, 0 flat.
    deviation : float
        Largest angle between a segment just released and the direction asked for [deg].
    segments : dict of str to float
        Lengths of the segments just released, by the tips that ran [mm].
    fracture_energy : float
        Spent so far: of all segments length times g_c of the material, on a border of the weaker
        one [N]; nan without a g_c.
    """

    quality: float = 1.0
    deviation: float = 0.0
    segments: Mapping[str, float] = field(default_factory=dict)
    fracture_energy: float = 0.0


NOTHING_GROWN = Grown()


@dataclass(frozen=True)
class Body:
    """A body between two solves.

    Attributes
    ----------
    materials : Materials
        Of the regions.
    triangulation : Triangulation
        The grid with its cracks closed, from which growth makes the next one.
    grid : Grid
    points : MaterialPoints
        The material.
    particle_domains : ParticleDomains or None
        The polygon of each material point; None while no crack has grown, and where points
        integrate as they are (`growth.transfer: paper`).
    quadrature : Quadrature or None
        The pieces of those polygons in the triangles.
    loading : Loading
    tip_domains : tuple of TipDomain
        One a tip of the grid.
    patches : Patches or None
        Over which the change of volume is averaged; None where triangles do not lock.
    grown : Grown
    empty_elements, floating_nodes : int
        Triangles without a quadrature point and nodes that only these touch, which are held.
    motion : Motion or None
        From the reference configuration, where the grid is reset; None where all is in that.
    """

    materials: Materials
    triangulation: Triangulation
    grid: Grid
    points: MaterialPoints
    particle_domains: ParticleDomains | None
    quadrature: Quadrature | None
    loading: Loading
    tip_domains: tuple[TipDomain, ...]
    patches: Patches | None
    grown: Grown = NOTHING_GROWN
    empty_elements: int = 0
    floating_nodes: int = 0
    motion: Motion | None = None

    @cached_property
    def integration(self) -> MaterialPoints:
        """What is summed over: the points themselves, or one row for each quadrature point."""
        if self.quadrature is None:
            return self.points
        return as_points(self.quadrature)

    @property
    def unresolved_tips(self) -> set[str]:
        """Tips whose domain cannot tell where they would turn to."""
        pairs = zip(self.grid.tips, self.tip_domains, strict=True)
        return {tip.name for tip, domain in pairs if not domain.steers}


def locate(body: Body, reason: str = MOVED_OFF) -> Body:
    """Find the triangles that what is summed over lies in, from those that held it.

    Parameters
    ----------
    body : Body
    reason : str
        Why points may lie outside, and what helps.

    Raises
    ------
    SolveError
        Where points lie outside the grid.
    """
    element = relocate(body.grid, body.integration, reason)
    if body.quadrature is None:
        return replace(body, points=replace(body.points, element=element))
    return replace(body, quadrature=replace(body.quadrature, element=element))


def named_grid(
    triangulation: Triangulation, element: Element | str, names: Mapping[tuple[str, int], str]
) -> Grid:
    """Build the grid of a body that has grown.

    Parameters
    ----------
    triangulation : Triangulation
    element : Element or str
        As in `build_grid`.
    names : mapping of (str, int) to str
        Name of the tip at each end of a crack: one end stays its start, though the other arrived.
    """
    grid = build_grid(triangulation, element)
    tips = tuple(replace(tip, name=names[tip.crack, tip.end]) for tip in grid.tips)
    return replace(grid, tips=tips)
