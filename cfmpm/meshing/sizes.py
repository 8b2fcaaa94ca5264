"""How large the triangles are to be, and where."""

from __future__ import annotations

import math
from itertools import pairwise

from shapely import LineString, Point

from cfmpm.scene.geometry import Body, tip_points
from cfmpm.scene.model import Grading, Scene

# Element size per distance, from tips and from whatever else needs small elements.
GROWTH = 0.3


def mesh_size(scene: Scene) -> float | None:
    """Return the element size away from the crack tips [mm]; None for a mesh file."""
    if scene.mesh_file is not None:
        return None
    return scene.mesh.size or math.sqrt(Body.of(scene).polygon.area) / 20


def resolved_grading(scene: Scene) -> Grading | None:
    """Return the grading towards the crack tips in numbers [mm]; None for a uniform grid."""
    if isinstance(scene.mesh.grading, Grading) and scene.mesh_file is None:
        return scene.mesh.grading
    size = mesh_size(scene)
    if size is None or scene.mesh.grading == "uniform":
        return None
    tips = tip_points(scene)
    if not tips:
        return None
    room = min(_room(scene, crack, end) for crack, end, _ in tips)
    # A tip that touches something has no room; six decades are as far as a grid can be graded.
    return Grading(tip_size=max(min(size / 100, room / 50), 1e-6 * size), growth=GROWTH)


def _room(scene: Scene, crack_name: str, end: int) -> float:
    """Distance from a tip to the boundary, another crack, a bend or the far end of its own [mm]."""
    body = Body.of(scene)
    lines = {str(crack.name): crack.points for crack in body.geometry.cracks}
    own = lines.pop(crack_name)
    tip = Point(own[end])
    others = [LineString(points) for points in lines.values()]
    if len(own) > 2:
        others.append(LineString(own[:-1] if end == -1 else own[1:]))
    length = sum(math.dist(a, b) for a, b in pairwise(own))
    return min(length, *(float(tip.distance(line)) for line in (body.polygon.boundary, *others)))
