"""Element sizes and grading."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from shapely import LineString, Point

from cfmpm.body.bends import SHARP, turn
from cfmpm.scene.families import expand
from cfmpm.scene.geometry import BodyShape
from cfmpm.scene.mesh import Grading
from cfmpm.scene.model import Scene
from cfmpm.scene.rules import estimated_triangles

# Ratio of the element size elsewhere, and of the crack length, to the element size at a growing
# tip: K is then within 1 or 2 % along the whole path (tests/verification/test_growth_grids.py).
RUNNING, OF_CRACK = 10.0, 20.0
# Ratio of the element size elsewhere, and of the clearance, to the element size at a stationary
# tip: no other grading has half the error at the same run time, at small strain and at finite
# deformation (`snakemake work-precision`).
AT_REST, OF_ROOM = 300.0, 150.0
# Increase of the element size per distance from a growing tip and other points with small elements,
# and from a stationary tip.
GROWTH, GROWTH_AT_REST = 0.3, 0.4


def mesh_size(scene: Scene) -> float | None:
    """Return the element size away from the crack tips [mm]; None for a mesh file."""
    return None if scene.mesh_file is not None else size_in(BodyShape.of(scene), scene)


def size_in(body: BodyShape, scene: Scene) -> float:
    """Return the element size away from the crack tips [mm], for a given body of the scene."""
    return scene.mesh.size or math.sqrt(body.polygon.area) / 20


def resolved_grading(scene: Scene) -> Grading | None:
    """Return the grading towards the crack tips [mm]; None for a uniform grid."""
    return None if scene.mesh_file is not None else grading_in(BodyShape.of(scene), scene)


def grading_in(body: BodyShape, scene: Scene) -> Grading | None:
    """Return the grading towards the crack tips [mm], for a given body of the scene."""
    if isinstance(scene.mesh.grading, Grading):
        return scene.mesh.grading
    if scene.mesh.grading == "uniform" or not body.tips:
        return None
    size = size_in(body, scene)
    room = min(_room(body, crack, end) for crack, end, _ in body.tips)
    if scene.growth is not None:
        tip_size = min(size / RUNNING, room / OF_CRACK)
        return Grading(tip_size=max(tip_size, 1e-6 * size), growth=GROWTH)
    # A tip at an object has zero clearance; a grid can be graded over six decades at most.
    tip_size = max(min(size / AT_REST, room / OF_ROOM), 1e-6 * size)
    return Grading(tip_size=tip_size, growth=GROWTH_AT_REST)


def running_size(scene: Scene, length: float) -> float | None:
    """Return the largest element size at a growing tip [mm]; None without refinement.

    Parameters
    ----------
    scene : Scene
        Expanded.
    length : float
        Length of the crack [mm].
    """
    if scene.fracture.refine is not None:
        return scene.fracture.refine
    if scene.growth is None or scene.growth.transfer == "paper" or scene.mesh_file is not None:
        return None
    if scene.mesh.grading != "auto":
        return None
    return min(size_in(BodyShape.of(scene), scene) / RUNNING, length / OF_CRACK)


def expected_triangles(scene: Scene) -> float | None:
    """Estimate the number of triangles of a scene; None for a mesh file.

    Parameters
    ----------
    scene : Scene
    """
    if scene.mesh_file is not None:
        return None
    scene = expand(scene)
    return triangles_in(BodyShape.of(scene), scene)


def triangles_in(body: BodyShape, scene: Scene) -> float:
    """Estimate how many triangles an expanded scene will have whose body is known."""
    chosen = {"size": size_in(body, scene), "grading": grading_in(body, scene) or "uniform"}
    mesh = scene.mesh.model_copy(update=chosen)
    return estimated_triangles(scene.model_copy(update={"mesh": mesh}), body)


def _room(body: BodyShape, crack_name: str, end: int) -> float:
    """Distance from a tip to the boundary, another crack, or a part of its own [mm].

    These are its other end, a sharp kink, and what comes back towards the tip.
    """
    lines = {str(crack.name): crack.points for crack in body.geometry.cracks}
    own = lines.pop(crack_name)
    own = own[::-1] if end == -1 else own
    tip = Point(own[0])
    others = [LineString(points) for points in lines.values()]
    along = np.diff(np.array(own), axis=0)
    sharp = np.abs(turn(along[:-1], along[1:])) > SHARP
    length, parts = 0.0, []
    for i, (a, b) in enumerate(pairwise(own)):
        if i and (sharp[i - 1] or length > 2.0 * math.dist(own[0], a)):
            parts.append(math.dist(own[0], a))
        length += math.dist(a, b)
    clear = (float(tip.distance(line)) for line in (body.polygon.boundary, *others))
    return min(length, *parts, *clear)
