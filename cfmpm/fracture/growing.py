"""Release of segments in a body: extended cracks, new grid, material points, loads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from cfmpm.body import particle_domains
from cfmpm.body.body import Body, Grown, named_grid
from cfmpm.body.grid import CrackTip, Floats, Grid, Ints, Triangulation
from cfmpm.body.particle_domains import ParticleDomains, Quadrature
from cfmpm.body.points import MaterialPoints, relocate, seed
from cfmpm.body.rigid_motions import UnheldError
from cfmpm.body.volume_patches import paired_triangles
from cfmpm.build import compose
from cfmpm.ending import LastCracks, RunEnded
from cfmpm.fracture.refinement import refine
from cfmpm.fracture.release import ACCEPTED, Release, advance, worths
from cfmpm.fracture.ties import Tie
from cfmpm.meshing import running_size
from cfmpm.scene import Scene


def release(
    scene: Scene,
    body: Body,
    running: Mapping[str, Floats],
    tie: Tie | None = None,
    *,
    reseed: bool = False,
) -> Body:
    """Extend the cracks at the growing tips, one after the other, and redefine the grid.

    Parameters
    ----------
    scene : Scene
        Expanded.
    body : Body
    running : mapping of str to (2,) float
        Direction of growth of each growing tip, by its name.
    tie : Tie, optional
        The tie of these tips, if they are in one: the grid then takes segments of equal lengths.
    reseed : bool
        Whether to create the material points of the new grid.

    Returns
    -------
    Body
        Without `reseed`, material points keep position, volume and state; a point that is cut by a
        new segment is split in two.

    Raises
    ------
    RunEnded
        If a part of the body is severed and moved away by the loads, or if a crack has reached the
        point of a load or a support.
    """
    mesh = body.triangulation
    tips = {tip.name: tip for tip in body.grid.tips}
    steps: list[Release] = []
    segments: dict[str, float] = {}
    spent = 0.0
    changed = [np.empty(0, np.int64)]
    lengths: Mapping[str, float] = {}
    if tie is not None:
        for name in running:
            mesh, halves = _refined(scene, mesh, tips[name])
            changed.append(halves)
        lengths = _equal_lengths(mesh, tips, running, tie)
    for name, direction in running.items():
        tip = tips[name]
        # A tip that grew before in this increment may have reached this one.
        if mesh.is_tip(tip.crack, tip.end):
            mesh, halves = _refined(scene, mesh, tip)
            changed.append(halves)
            step = advance(mesh, tip.crack, tip.end, direction, lengths.get(name))
            mesh = step.triangulation
            segments[name] = step.length
            spent += step.length * _toughness_of(mesh, step, body.materials.g_c)
            steps.append(step)
    names = {(tip.crack, tip.end): name for name, tip in tips.items()}
    grid = named_grid(mesh, body.grid.element, names)
    changed += [step.changed for step in steps]
    parts = _split_points(scene, body, grid, np.unique(np.concatenate(changed)), steps, reseed)
    grown = Grown(
        quality=min(body.grown.quality, *(step.quality for step in steps)),
        segments=segments,
        deviations={name: step.deviation for name, step in zip(segments, steps, strict=True)},
        fracture_energy=body.grown.fracture_energy + spent,
    )
    cracks = LastCracks(mesh, grown)
    if met := _point_met(mesh, steps):
        raise RunEnded("met_point", met, cracks=cracks)
    try:
        more = body.loading.fixed_names, _paired(body, grid)
        return compose(scene, body.materials, mesh, grid, *parts, grown, *more)
    except UnheldError as unheld:
        x, y = unheld.centre
        text = (
            f"severed: the part of the body around ({x:.4g}, {y:.4g}) is severed, and no support "
            "holds it against the loads"
        )
        raise RunEnded("severed", text, cracks=cracks) from unheld


def _paired(body: Body, grid: Grid) -> Ints | None:
    """Patches of the triangles of a new grid, as far as they can be those of the body before."""
    if body.patches is None:
        return None
    # The patches of a fixed grid that is reset are those of its margin too.
    return paired_triangles(grid, body.patches.of_triangle[: len(body.grid.triangles)])


def _split_points(
    scene: Scene,
    body: Body,
    grid: Grid,
    changed: Ints,
    steps: Sequence[Release],
    reseed: bool,
) -> tuple[MaterialPoints, ParticleDomains | None, Quadrature | None]:
    """Split the points that new segments cut, and find the triangles of all points."""
    if reseed:
        return seed(grid), None, None
    points, domains, quadrature = body.points, body.particle_domains, body.quadrature
    # With `transfer: paper` points are integrated without domains.
    if scene.growth is None or scene.growth.transfer != "paper":
        if domains is None or quadrature is None:
            domains = particle_domains.initial_domains(body.grid)
            quadrature = particle_domains.initial_quadrature(points)
        quadrature = particle_domains.realign(quadrature, domains, points, grid, changed)
        nodes = steps[-1].triangulation.nodes
        for step in steps:
            points, domains, quadrature = particle_domains.split_points(
                points, domains, quadrature, grid, nodes[step.start], nodes[step.end]
            )
    return replace(points, element=relocate(grid, points)), domains, quadrature


def _refined(scene: Scene, mesh: Triangulation, tip: CrackTip) -> tuple[Triangulation, Ints]:
    """Refine the grid around a growing tip; give the changed triangles."""
    size = running_size(scene, tip.crack_length)
    if size is None:
        return mesh, np.empty(0, np.int64)
    return refine(mesh, tip.path[0], size)


def _equal_lengths(
    mesh: Triangulation,
    tips: Mapping[str, CrackTip],
    running: Mapping[str, Floats],
    tie: Tie,
) -> dict[str, float]:
    """Lengths of segments after which the tips of a tie have grown alike; empty where none fit."""
    natural = {}
    for name, direction in running.items():
        tip = tips[name]
        offered = advance(mesh, tip.crack, tip.end, direction)
        if not offered.triangulation.is_tip(tip.crack, tip.end):
            return {}  # it arrives
        natural[name] = offered.length
    choices = tie.wanted(list(running), natural)
    worth = np.full(len(choices), np.inf)
    for name, direction in running.items():
        tip, lengths = tips[name], [lengths[name] for lengths in choices]
        worth = np.minimum(worth, worths(mesh, tip.crack, tip.end, direction, lengths))
    best = int(np.argmax(worth))
    return choices[best] if worth[best] >= ACCEPTED else {}


def _toughness_of(mesh: Triangulation, step: Release, toughness: Floats) -> float:
    """Critical energy release rate along a segment; on an interface the smaller one [N/mm]."""
    both = np.isin(mesh.triangles, (step.start, step.end)).sum(axis=1) == 2
    return float(toughness[mesh.regions[both]].min())


def _point_met(mesh: Triangulation, steps: Sequence[Release]) -> str:
    """Name the point of a load or a support that a crack has reached; empty if none."""
    ends = {step.end for step in steps}
    for name, node in mesh.points.items():
        if node in ends:
            return (
                f"met {name}: a crack has reached the point at which it acts, and the scene does "
                "not define on which crack face it acts from then on"
            )
    return ""
