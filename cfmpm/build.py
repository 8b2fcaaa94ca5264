"""From a scene to the body that is solved."""

from __future__ import annotations

from cfmpm.body.body import (
    Body,
    compose,
)
from cfmpm.body.grid import build_grid
from cfmpm.body.points import seed
from cfmpm.meshing import triangulate
from cfmpm.scene import Scene, expand


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
