"""From a scene to the body that is solved."""

from __future__ import annotations

from cfmpm.body.body import (
    Body,
    compose,
)
from cfmpm.body.grid import build_grid
from cfmpm.body.materials import Materials, material_table
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
    materials = materials_of(scene, grid.region_names)
    return compose(scene, materials, triangulation, grid, points)


def materials_of(scene: Scene, region_names: tuple[str, ...]) -> Materials:
    """Make the table of the materials of a scene.

    Parameters
    ----------
    scene : Scene
        Expanded.
    region_names : tuple of str
        ``"body"`` first: a region has its own material, or that of the body.

    Returns
    -------
    Materials
    """
    source = scene.geometry or scene.mesh_file
    own = {region.name: region.material for region in source.regions} if source else {}
    rows = [own.get(name, scene.material).model_dump() for name in region_names]
    return material_table(rows, scene.plane)
