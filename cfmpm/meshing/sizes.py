"""How large the triangles are to be, and where."""

from __future__ import annotations

import math
from itertools import pairwise

from cfmpm.scene.geometry import Body
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
    cracks = Body.of(scene).geometry.cracks
    if not cracks:
        return None
    shortest = min(sum(math.dist(a, b) for a, b in pairwise(c.points)) for c in cracks)
    return Grading(tip_size=min(size / 100, shortest / 50), growth=GROWTH)
