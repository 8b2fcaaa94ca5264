"""The body that is solved: grid, material points, loads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from cfmpm.body import particle_domains
from cfmpm.body.grid import Grid, Ints, Triangulation, build_grid
from cfmpm.body.loads import Loading, apply_loads, hold_nodes
from cfmpm.body.materials import Materials
from cfmpm.body.motion import Motion
from cfmpm.body.points import MOVED_OFF, MaterialPoints, relocate
from cfmpm.body.tip_domains import Domains, choose_domains
from cfmpm.body.volume_patches import Patches, build_patches
from cfmpm.scene import Scene


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
    segments: dict[str, float] = field(default_factory=dict)
    fracture_energy: float = 0.0


NOTHING_GROWN = Grown()


@dataclass(frozen=True)
class Body:
    """A body between two solves.

    Attributes
    ----------
    scene : Scene
        Expanded: with its geometry, loads and names.
    materials : Materials
        Of the regions.
    triangulation : Triangulation
        The grid with its cracks closed, from which growth makes the next one.
    grid : Grid
    points : MaterialPoints
        The material.
    domains : particle_domains.ParticleDomains or None
        The polygon of each material point; None while no crack has grown, and where points
        integrate as they are (`growth.transfer: paper`).
    quadrature : particle_domains.Quadrature or None
        The pieces of those polygons in the triangles.
    loading : Loading
    tip_domains : tuple of Domains
        One a tip of the grid.
    patches : Patches or None
        Over which the change of volume is averaged; None where triangles do not lock.
    grown : Grown
    empty_elements, floating_nodes : int
        Triangles without a quadrature point and nodes that only these touch, which are held.
    motion : Motion or None
        From the reference configuration, where the grid is reset; None where all is in that.
    """

    scene: Scene
    materials: Materials
    triangulation: Triangulation
    grid: Grid
    points: MaterialPoints
    domains: particle_domains.ParticleDomains | None
    quadrature: particle_domains.Quadrature | None
    loading: Loading
    tip_domains: tuple[Domains, ...]
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
        return particle_domains.as_points(self.quadrature)

    @property
    def unresolved_tips(self) -> set[str]:
        """Tips whose domain cannot tell where they would turn to."""
        pairs = zip(self.grid.tips, self.tip_domains, strict=True)
        return {tip.name for tip, domain in pairs if not domain.steers}


def compose(
    scene: Scene,
    materials: Materials,
    triangulation: Triangulation,
    grid: Grid,
    points: MaterialPoints,
    domains: particle_domains.ParticleDomains | None = None,
    quadrature: particle_domains.Quadrature | None = None,
    grown: Grown = NOTHING_GROWN,
) -> Body:
    """Put a body together: its loads, tip domains and what it is integrated over.

    Parameters
    ----------
    scene : Scene
        Expanded.
    materials, triangulation, grid, points, domains, quadrature, grown
        As in `Body`.

    Returns
    -------
    Body

    Raises
    ------
    SceneError
        Where the loads do not make sense on the grid.
    UnheldError
        Where the loads drive a part away.
    """
    integration = points if quadrature is None else particle_domains.as_points(quadrature)
    floating, empty = _without_points(grid, integration.element)
    return Body(
        scene=scene,
        materials=materials,
        triangulation=triangulation,
        grid=grid,
        points=points,
        domains=domains,
        quadrature=quadrature,
        loading=hold_nodes(apply_loads(scene, grid, integration), floating),
        tip_domains=_tip_domains(scene, grid),
        patches=build_patches(grid) if grid.element.locks and materials.locks.any() else None,
        grown=grown,
        empty_elements=empty,
        floating_nodes=len(floating),
    )


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
    triangulation: Triangulation, scene: Scene, names: Mapping[tuple[str, int], str]
) -> Grid:
    """Build the grid of a body that has grown.

    Parameters
    ----------
    triangulation : Triangulation
    scene : Scene
    names : mapping of (str, int) to str
        Name of the tip at each end of a crack: one end stays its start, though the other arrived.
    """
    grid = build_grid(triangulation, scene.mesh.element)
    tips = tuple(replace(tip, name=names[tip.crack, tip.end]) for tip in grid.tips)
    return replace(grid, tips=tips)


def _tip_domains(scene: Scene, grid: Grid) -> tuple[Domains, ...]:
    growing = scene.growth is not None
    return tuple(
        choose_domains(grid, tip, scene.fracture.radii, growing=growing) for tip in grid.tips
    )


def _without_points(grid: Grid, element: Ints) -> tuple[Ints, int]:
    """Find the nodes that only triangles without a point touch, and count those triangles."""
    filled = np.zeros(len(grid.elements), bool)
    filled[element] = True
    if filled.all():
        return np.empty(0, np.int64), 0
    touched = np.zeros(len(grid.nodes), bool)
    touched[grid.elements[filled]] = True
    return np.flatnonzero(~touched), int((~filled).sum())
