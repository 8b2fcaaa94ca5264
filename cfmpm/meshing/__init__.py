"""Triangulation of the body of a scene by gmsh, which is loaded only when needed."""

from cfmpm.body.grid import Triangulation
from cfmpm.meshing.body import triangulate_body
from cfmpm.meshing.files import triangulate_file
from cfmpm.meshing.sizes import (
    expected_triangles,
    mesh_size,
    resolved_grading,
    running_size,
)
from cfmpm.scene.model import Scene

__all__ = ["expected_triangles", "mesh_size", "resolved_grading", "running_size", "triangulate"]


def triangulate(scene: Scene) -> Triangulation:
    """Triangulate the body of a scene; the same scene always gives the same arrays.

    Parameters
    ----------
    scene : Scene
        A validated scene.

    Returns
    -------
    Triangulation
        Coordinates in mm. Corners, crack ends and load points have exactly the coordinates of the
        scene (after :func:`cfmpm.scene.snap`).

    Raises
    ------
    MeshError
        If gmsh cannot be loaded or cannot mesh the body.
    SceneError
        If a mesh file cannot be used, or does not fit the scene.
    """
    return triangulate_body(scene) if scene.mesh_file is None else triangulate_file(scene)
