"""Release on the body: a longer crack, and the grid and points that go with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from cfmpm.body import particle_domains
from cfmpm.body.body import Body, Grown, named_grid
from cfmpm.body.grid import Floats, Triangulation
from cfmpm.body.points import relocate
from cfmpm.body.rigid_motions import UnheldError
from cfmpm.build import compose
from cfmpm.ending import LastCracks, RunEnded
from cfmpm.fracture.refinement import refine
from cfmpm.fracture.release import Release, advance
from cfmpm.meshing import running_size
from cfmpm.scene import Scene


def release(scene: Scene, body: Body, running: Mapping[str, Floats]) -> Body:
    """Lengthen the cracks at the tips that run, one after the other, and redefine the grid.

    Parameters
    ----------
    scene : Scene
        Expanded.
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
    RunEnded
        Where the crack has cut off a part that the loads drive away, or has met the point of a load
        or a support.
    """
    mesh = body.triangulation
    tips = {tip.name: tip for tip in body.grid.tips}
    steps: list[Release] = []
    segments: dict[str, float] = {}
    spent = 0.0
    refined = [np.empty(0, np.int64)]
    for name, direction in running.items():
        tip = tips[name]
        # One that ran before it in this increment may have come to it.
        if mesh.is_tip(tip.crack, tip.end):
            size = running_size(scene, tip.crack_length)
            if size is not None:
                mesh, parts = refine(mesh, tip.path[0], size)
                refined.append(parts)
            step = advance(mesh, tip.crack, tip.end, direction)
            mesh = step.triangulation
            segments[name] = float(np.hypot(*(mesh.nodes[step.end] - mesh.nodes[step.start])))
            spent += segments[name] * _toughness_of(mesh, step, body.materials.g_c)
            steps.append(step)
    names = {(tip.crack, tip.end): tip.name for tip in body.grid.tips}
    grid = named_grid(mesh, body.grid.element, names)
    changed = np.unique(np.concatenate([*refined, *(step.changed for step in steps)]))
    points, domains, quadrature = body.points, body.particle_domains, body.quadrature
    # As the paper transfers them, points integrate as they are.
    if scene.growth is None or scene.growth.transfer != "paper":
        if domains is None or quadrature is None:
            domains = particle_domains.initial_domains(body.grid)
            quadrature = particle_domains.initial_quadrature(points)
        quadrature = particle_domains.realign(quadrature, domains, points, grid, changed)
        for step in steps:
            points, domains, quadrature = particle_domains.split_points(
                points, domains, quadrature, grid, mesh.nodes[step.start], mesh.nodes[step.end]
            )
    points = replace(points, element=relocate(grid, points))
    grown = Grown(
        quality=min(body.grown.quality, *(step.quality for step in steps)),
        deviation=max(step.deviation for step in steps),
        segments=segments,
        fracture_energy=body.grown.fracture_energy + spent,
    )
    cracks = LastCracks(mesh, grown)
    met = _point_met(mesh, steps)
    if met:
        raise RunEnded("met_point", met, cracks=cracks)
    try:
        fixed = body.loading.fixed_names
        return compose(scene, body.materials, mesh, grid, points, domains, quadrature, grown, fixed)
    except UnheldError as unheld:
        x, y = unheld.centre
        text = (
            f"severed: the part of the body around ({x:.4g}, {y:.4g}) is cut off, and the loads "
            "drive it away"
        )
        raise RunEnded("severed", text, cracks=cracks) from unheld


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
