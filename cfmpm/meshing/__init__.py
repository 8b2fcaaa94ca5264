"""From a scene to a plane triangulation, by gmsh, which is loaded only when it is needed."""

from cfmpm.meshing.body import triangulate
from cfmpm.meshing.sizes import mesh_size, resolved_grading

__all__ = ["mesh_size", "resolved_grading", "triangulate"]
