"""Crack growth on a grid that is reset (paper section 4.2, step 8)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from cfmpm.body import particle_domains
from cfmpm.body.body import Body
from cfmpm.body.grid import Floats, Grid
from cfmpm.body.motion import Motion
from cfmpm.body.points import DeformedPoints, MaterialPoints, relocate
from cfmpm.body.transfer import interpolate_displacement
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.fracture import growing
from cfmpm.fracture.ties import Tie
from cfmpm.kernels import clipping
from cfmpm.scene import Scene
from cfmpm.updated import reset
from cfmpm.updated.integration import clipped, with_state

# Distance of a grid node from its tracer above which they do not coincide, over the size of the
# body: round-off is far below it.
COINCIDE = 1e-12


def release(
    scene: Scene,
    body: Body,
    balance: Equilibrium,
    running: Mapping[str, Floats],
    tie: Tie | None,
) -> tuple[Body, Equilibrium]:
    """Release segments in a body whose grid was reset.

    The segments are aligned and released on the reference grid, where the crack faces are closed.
    The current grid follows from it: a fixed grid has the nodes of the reference and a new margin;
    the nodes of a following grid move to their places in the deformed body.

    Parameters
    ----------
    scene : Scene
        Expanded.
    body : Body
    balance : Equilibrium
        Both from `reset.reset`.
    running, tie
        As of `growing.release`.

    Returns
    -------
    body : Body
        Material points keep position, volume and displacement gradient. With integration over
        domains each triangle of the reference grid remains one domain: the points of triangles that
        have changed are created anew, with the mean displacement gradient over them.
    balance : Equilibrium
        Start of the next solve.

    Raises
    ------
    RunEnded
        As by `growing.release`.
    SolveError
        If material points lie outside the new grid.
    """
    motion = body.motion
    assert motion is not None
    by_domains = motion.reset.by_domains
    points = replace(body.points, position=motion.position, element=motion.element)
    at_rest = replace(
        body, grid=motion.reference, points=points, loading=motion.loading, motion=None
    )
    grown = growing.release(scene, at_rest, running, tie, reseed=by_domains)
    fresh = reset.begin(grown, scene)
    moved, nodes, smoothed = _carried(body, fresh)
    assert fresh.motion is not None
    new = replace(fresh.motion, displacement=moved, smoothed=smoothed, resets=motion.resets)
    grid, quadrature = replace(fresh.grid, nodes=nodes), None
    if by_domains:
        before = particle_domains.means(body.points, body.quadrature, balance.points)
        rows = _averaged(before, motion.reference, new)
        placed: MaterialPoints = replace(fresh.points, position=rows.position)
        if motion.reset.fixed or smoothed.any():
            quadrature = clipped(new, placed, grid, fixed=motion.reset.fixed)
            rows = with_state(quadrature, rows)
    else:
        placed = replace(body.points, element=fresh.points.element)
        placed = replace(placed, element=relocate(grid, placed))
        rows = replace(balance.points, element=placed.element)
    kept = {
        "displacement": moved,
        "triangle": new.triangle,
        "base": rows.displacement_gradient,
        "smoothed": smoothed,
        "resets": motion.resets,
    }
    nothing = np.zeros_like(nodes)
    return reset.restore(fresh, nodes, placed, quadrature, kept), replace(
        balance,
        points=rows,
        displacement=nothing,
        internal_force=nothing,
        contact_force=nothing,
    )


def _carried(body: Body, fresh: Body) -> tuple[Floats, Floats, np.ndarray]:
    """Displacement of the tracers, nodes of the grid, and nodes apart from their tracers."""
    motion, new = body.motion, fresh.motion
    assert motion is not None
    assert new is not None
    moved = interpolate_displacement(motion.reference, motion.displacement, new.reference)
    if motion.reset.fixed:
        return moved, fresh.grid.nodes, new.smoothed
    shift = body.grid.nodes - motion.reference.nodes
    shift = interpolate_displacement(motion.reference, shift, new.reference)
    smoothed = np.hypot(*(shift - moved).T) > COINCIDE * new.reference.diagonal
    return moved, new.reference.nodes + shift, smoothed


def _averaged(before: DeformedPoints, old: Grid, new: Motion) -> DeformedPoints:
    """Give each triangle of the new reference grid the mean state of the domains in it.

    Parameters
    ----------
    before : DeformedPoints
        The points of the old reference grid, one for each triangle.
    old : Grid
    new : Motion
    """
    grid = new.reference
    corners = grid.nodes[grid.triangles]
    n = len(old.elements)
    changed = np.ones(len(corners), bool)
    changed[:n] = (corners[:n] != old.nodes[old.triangles]).any(axis=(1, 2))
    domains = particle_domains.triangular_domains(old.nodes[old.triangles])
    owner, element, _, area = clipping.clip_domains(
        grid.nodes,
        grid.elements,
        grid.element.points,
        grid.element.weights,
        np.flatnonzero(changed),
        domains.anchors,
        domains.vertices,
        domains.offsets,
        np.flatnonzero(changed[:n]),
    )
    whole = np.flatnonzero(~changed)
    owner, element = np.concatenate([whole, owner]), np.concatenate([whole, element])
    area = np.concatenate([grid.areas[whole], area])
    total = np.bincount(element, area, len(corners))
    gradient = np.zeros((len(corners), 2, 2))
    np.add.at(gradient, element, area[:, None, None] * before.displacement_gradient[owner])
    gradient /= total[:, None, None]
    points = MaterialPoints(
        position=new.tracers[grid.triangles].mean(axis=1),
        volume=grid.areas,
        element=np.arange(len(corners)),
        material=grid.regions,
    )
    nothing = np.zeros(len(corners))
    return points.deformed(gradient, np.zeros((len(corners), 3)), nothing)
