"""The body: grid, material points, loads."""

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
    """Record of crack growth in a body.

    Attributes
    ----------
    quality : float
        Quality of the worst triangle changed so far; 1 equilateral, 0 degenerate.
    segments : dict of str to float
        Lengths of the segments just released, by the name of the tip [mm].
    deviations : dict of str to float
        Angles between the segments just released and their directions of growth, likewise [deg].
    fracture_energy : float
        Fracture energy so far: the sum of length times g_c over all segments, with the smaller g_c
        on an interface [N]; nan without g_c.
    """

    quality: float = 1.0
    segments: Mapping[str, float] = field(default_factory=dict)
    deviations: Mapping[str, float] = field(default_factory=dict)
    fracture_energy: float = 0.0


NOTHING_GROWN = Grown()


@dataclass(frozen=True)
class Body:
    """A body before a solve.

    Attributes
    ----------
    materials : Materials
        Materials of the regions.
    triangulation : Triangulation
        The grid with closed cracks, from which growth makes the next one.
    grid : Grid
    points : MaterialPoints
    particle_domains : ParticleDomains or None
        The polygon of each material point; None before growth, and with `growth.transfer: paper`,
        which integrates over the points without domains.
    quadrature : Quadrature or None
        Quadrature points: the intersections of those polygons with the triangles.
    loading : Loading
    tip_domains : tuple of TipDomain
        One for each tip of the grid.
    patches : Patches or None
        Patches over which the volume change is averaged; None if elements do not lock.
    grown : Grown
    empty_elements, floating_nodes : int
        Number of triangles without a quadrature point, and of nodes of only such triangles, which
        are held.
    motion : Motion or None
        Motion from the reference configuration, for a grid that is reset; else None.
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
        """The quadrature points; before growth these are the material points."""
        if self.quadrature is None:
            return self.points
        return as_points(self.quadrature)

    @property
    def unresolved_tips(self) -> set[str]:
        """Tips whose domain is too small for a direction of growth."""
        pairs = zip(self.grid.tips, self.tip_domains, strict=True)
        return {tip.name for tip, domain in pairs if not domain.steers}


def locate(body: Body, reason: str = MOVED_OFF) -> Body:
    """Find the triangles of the quadrature points, starting from the previous ones.

    Parameters
    ----------
    body : Body
    reason : str
        Cause and remedy for points outside the grid, for the error message.

    Raises
    ------
    SolveError
        If points lie outside the grid.
    """
    element = relocate(body.grid, body.integration, reason)
    if body.quadrature is None:
        return replace(body, points=replace(body.points, element=element))
    return replace(body, quadrature=replace(body.quadrature, element=element))


def named_grid(
    triangulation: Triangulation, element: Element | str, names: Mapping[tuple[str, int], str]
) -> Grid:
    """Build the grid of a body after crack growth.

    Parameters
    ----------
    triangulation : Triangulation
    element : Element or str
        As in `build_grid`.
    names : mapping of (str, int) to str
        Name of the tip at each end of a crack. It does not change when the other end arrives.
    """
    grid = build_grid(triangulation, element)
    tips = tuple(replace(tip, name=names[tip.crack, tip.end]) for tip in grid.tips)
    return replace(grid, tips=tips)
