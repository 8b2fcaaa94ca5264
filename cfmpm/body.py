"""The body that is solved: grid, material points, loads; and how a longer crack changes it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from cfmpm import pieces
from cfmpm.fracture.domains import Domains, choose_domains
from cfmpm.fracture.refinement import refine
from cfmpm.fracture.release import Release, advance, is_tip
from cfmpm.grid import Floats, Grid, Ints, Triangulation, build_grid
from cfmpm.loading import Loading, UnheldError, apply_loads, hold_nodes
from cfmpm.materials import locks, region_materials
from cfmpm.meshing import running_size, triangulate
from cfmpm.motion import Motion
from cfmpm.patches import Patches, build_patches
from cfmpm.points import MaterialPoints, relocate, seed
from cfmpm.scene import Scene, expand


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


class GrowthEndError(Exception):
    """A longer crack has left no body that could be solved.

    Attributes
    ----------
    triangulation : Triangulation
        The grid with that crack.
    grown : Grown
    """

    def __init__(self, triangulation: Triangulation, grown: Grown, ending: str) -> None:
        self.triangulation, self.grown = triangulation, grown
        super().__init__(ending)


class SeveredError(GrowthEndError):
    """A crack has cut off a part that the loads drive away."""

    def __init__(self, triangulation: Triangulation, grown: Grown, centre: Floats) -> None:
        super().__init__(
            triangulation,
            grown,
            f"severed: the part of the body around ({centre[0]:.4g}, {centre[1]:.4g}) is cut off, "
            "and the loads drive it away",
        )


NOTHING_GROWN = Grown()


@dataclass(frozen=True)
class Body:
    """A body between two solves.

    Attributes
    ----------
    scene : Scene
        Expanded: with its geometry, loads and names.
    triangulation : Triangulation
        The grid with its cracks closed, from which growth makes the next one.
    grid : Grid
    points : MaterialPoints
        The material.
    domains : pieces.ParticleDomains or None
        The polygon of each material point; None while no crack has grown, and where points
        integrate as they are (`growth.transfer: paper`).
    quadrature : pieces.Quadrature or None
        The pieces of those polygons in the triangles.
    integration : MaterialPoints
        What is summed over: the points themselves, or one row for each quadrature point.
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
    triangulation: Triangulation
    grid: Grid
    points: MaterialPoints
    domains: pieces.ParticleDomains | None
    quadrature: pieces.Quadrature | None
    integration: MaterialPoints
    loading: Loading
    tip_domains: tuple[Domains, ...]
    patches: Patches | None
    grown: Grown = NOTHING_GROWN
    empty_elements: int = 0
    floating_nodes: int = 0
    motion: Motion | None = None

    @property
    def blind_tips(self) -> set[str]:
        """Tips whose domain cannot tell where they would turn to."""
        pairs = zip(self.grid.tips, self.tip_domains, strict=True)
        return {tip.name for tip, domain in pairs if not domain.steers}


def build(scene: Scene) -> Body:
    """Build the body of a scene, before its first solve.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Body
        With material points free of stress.

    Raises
    ------
    SceneError
        Where the scene turns out not to make sense on its grid.
    MeshError
        Where no grid could be made.
    """
    scene = expand(scene)
    triangulation = triangulate(scene)
    grid = build_grid(triangulation, scene.mesh.element)
    points = seed(grid)
    return compose(scene, triangulation, grid, points)


def compose(
    scene: Scene,
    triangulation: Triangulation,
    grid: Grid,
    points: MaterialPoints,
    domains: pieces.ParticleDomains | None = None,
    quadrature: pieces.Quadrature | None = None,
    grown: Grown = NOTHING_GROWN,
) -> Body:
    """Put a body together: its loads, tip domains and what it is integrated over.

    Parameters
    ----------
    scene : Scene
        Expanded.
    triangulation, grid, points, domains, quadrature, grown
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
    integration = points if quadrature is None else pieces.as_points(quadrature)
    floating, empty = _without_points(grid, integration.element)
    return Body(
        scene=scene,
        triangulation=triangulation,
        grid=grid,
        points=points,
        domains=domains,
        quadrature=quadrature,
        integration=integration,
        loading=hold_nodes(apply_loads(scene, grid, integration), floating),
        tip_domains=_tip_domains(scene, grid),
        patches=build_patches(grid) if locks(scene, grid.region_names) else None,
        grown=grown,
        empty_elements=empty,
        floating_nodes=len(floating),
    )


def release(body: Body, running: Mapping[str, Floats]) -> Body:
    """Lengthen the cracks at the tips that run, one after the other, and redefine the grid.

    Parameters
    ----------
    body : Body
    running : mapping of str to (2,) float
        Direction of each tip that runs, by its name.

    Returns
    -------
    Body
        Material points stay where they are and keep volume and state; those that a new segment
        cuts become two.

    Raises
    ------
    GrowthEndError
        Where the crack has cut off a part that the loads drive away, or has met the point of a load
        or a support.
    """
    scene, mesh = body.scene, body.triangulation
    tips = {tip.name: tip for tip in body.grid.tips}
    steps: list[Release] = []
    segments: dict[str, float] = {}
    spent = 0.0
    materials = region_materials(scene, body.grid.region_names)
    toughness = np.array([material.g_c for material in materials], float)
    refined = [np.empty(0, np.int64)]
    for name, direction in running.items():
        tip = tips[name]
        # One that ran before it in this increment may have come to it.
        if is_tip(mesh, tip.crack, tip.end):
            size = running_size(scene, float(np.hypot(*np.diff(tip.path, axis=0).T).sum()))
            if size is not None:
                mesh, parts = refine(mesh, tip.path[0], size)
                refined.append(parts)
            step = advance(mesh, tip.crack, tip.end, direction)
            mesh = step.triangulation
            segments[name] = float(np.hypot(*(mesh.nodes[step.end] - mesh.nodes[step.start])))
            spent += segments[name] * _toughness_of(mesh, step, toughness)
            steps.append(step)
    names = {(tip.crack, tip.end): tip.name for tip in body.grid.tips}
    grid = named_grid(mesh, scene, names)
    changed = np.unique(np.concatenate([*refined, *(step.changed for step in steps)]))
    points, domains, quadrature = body.points, body.domains, body.quadrature
    # As the paper transfers them, points integrate as they are.
    if scene.growth is None or scene.growth.transfer != "paper":
        if domains is None or quadrature is None:
            domains = pieces.initial_domains(body.grid)
            quadrature = pieces.initial_quadrature(points)
        quadrature = pieces.realign(quadrature, domains, points, grid, changed)
        for step in steps:
            points, domains, quadrature = pieces.split_points(
                points, domains, quadrature, grid, mesh.nodes[step.start], mesh.nodes[step.end]
            )
    points = replace(points, element=relocate(grid, points))
    grown = Grown(
        quality=min(body.grown.quality, *(step.quality for step in steps)),
        deviation=max(step.deviation for step in steps),
        segments=segments,
        fracture_energy=body.grown.fracture_energy + spent,
    )
    met = _point_met(mesh, steps)
    if met:
        raise GrowthEndError(mesh, grown, met)
    try:
        return compose(scene, mesh, grid, points, domains, quadrature, grown)
    except UnheldError as unheld:
        raise SeveredError(mesh, grown, unheld.centre) from unheld


def _toughness_of(mesh: Triangulation, step: Release, toughness: Floats) -> float:
    """Critical energy release rate of what a segment runs through, on a border the weaker one."""
    both = np.isin(mesh.triangles, (step.start, step.end)).sum(axis=1) == 2
    return float(toughness[mesh.regions[both]].min())


def _point_met(mesh: Triangulation, steps: Sequence[Release]) -> str:
    """Say which point of a load or a support a crack has run into; empty where none."""
    ends = {step.end for step in steps}
    for name, node in mesh.points.items():
        if node in ends:
            return (
                f"met {name}: a crack has run into the point at which it acts, and the scene does "
                "not say on which of its faces it acts on"
            )
    return ""


def update_owners(body: Body) -> None:
    """Give the material points the area means of their quadrature points, in place."""
    if body.quadrature is None:
        return
    source = body.integration
    n = len(body.points)
    for name in ("displacement_gradient", "stress", "energy"):
        mean = pieces.point_state(body.quadrature, getattr(source, name), n)
        setattr(body.points, name, mean)


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
