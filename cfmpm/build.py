"""From a scene to the body that is solved."""

from __future__ import annotations

from cfmpm.body.body import (
    Body,
    compose,
)
from cfmpm.body.grid import build_grid
from cfmpm.body.materials import Materials, departures_at_rest, material_table
from cfmpm.body.points import seed
from cfmpm.errors import Problem, SceneError
from cfmpm.meshing import triangulate
from cfmpm.registry.laws import LAWS
from cfmpm.scene import Scene, expand

# Part of its stiffness by which a law may differ from Hooke's at rest: constants have few digits.
UNLIKE = 1e-3


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

    Raises
    ------
    SceneError
        Where a law has another stiffness at rest than E and nu say.
    """
    source = scene.geometry or scene.mesh_file
    own = {region.name: region.material for region in source.regions} if source else {}
    rows = [own.get(name, scene.material) for name in region_names]
    table = material_table([row.model_dump() for row in rows], scene.plane)
    if scene.plane == "strain" and any(LAWS[row.law].constants for row in rows):
        for name, row, part in zip(region_names, rows, departures_at_rest(table), strict=True):
            if part > UNLIKE:
                raise SceneError(
                    [
                        Problem(
                            f"{row.law} is stiffer or softer without strain than E and nu say, by "
                            f"{100 * part:.2g} %: make them fit its constants",
                            "material" if name == "body" else f"material of {name}",
                        )
                    ]
                )
    return table
