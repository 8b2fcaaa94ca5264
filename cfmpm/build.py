"""Makes the body of a scene."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from cfmpm.body import particle_domains
from cfmpm.body.body import NOTHING_GROWN, Body, Grown
from cfmpm.body.grid import Grid, Ints, Triangulation, build_grid
from cfmpm.body.loads import apply_loads, hold_nodes
from cfmpm.body.materials import Materials, departures_at_rest, material_table
from cfmpm.body.points import MaterialPoints, seed
from cfmpm.body.tip_domains import choose_domains
from cfmpm.body.volume_patches import build_patches
from cfmpm.errors import Problem, SceneError
from cfmpm.meshing import triangulate
from cfmpm.registry.laws import LAWS
from cfmpm.scene import Scene, expand, geometry
from cfmpm.scene.shapes import Side

# Largest relative difference of a law's stiffness at zero strain from Hooke's law; its constants
# may be given with few digits.
UNLIKE = 1e-3


def build(scene: Scene, fixed: Collection[str] = ()) -> Body:
    """Build the body of a scene, before its first solve.

    Parameters
    ----------
    scene : Scene
    fixed : collection of str
        Names of the loads that act in full at every load factor; the others are proportional to it.

    Returns
    -------
    Body
        With stress-free material points.

    Raises
    ------
    SceneError
        If the scene is invalid on its grid.
    MeshError
        If no grid could be made.
    """
    scene = expand(scene)
    triangulation = triangulate(scene)
    grid = build_grid(triangulation, scene.mesh.element)
    points = seed(grid)
    materials = materials_of(scene, grid.region_names)
    return compose(scene, materials, triangulation, grid, points, fixed=fixed)


def compose(
    scene: Scene,
    materials: Materials,
    triangulation: Triangulation,
    grid: Grid,
    points: MaterialPoints,
    domains: particle_domains.ParticleDomains | None = None,
    quadrature: particle_domains.Quadrature | None = None,
    grown: Grown = NOTHING_GROWN,
    fixed: Collection[str] = (),
    paired: Ints | None = None,
) -> Body:
    """Assemble a body from its parts, with loads, tip domains and quadrature points.

    Parameters
    ----------
    scene : Scene
        Expanded.
    materials, triangulation, grid, points, domains, quadrature, grown
        As in `Body`.
    fixed : collection of str
        As in `build`.
    paired : (m,) int, optional
        Patch of each triangle, if elements lock; by default they are paired here.

    Returns
    -------
    Body

    Raises
    ------
    SceneError
        If the loads are invalid on the grid.
    UnheldError
        If loads act on a rigid motion of a part that no support prevents.
    """
    integration = points if quadrature is None else particle_domains.as_points(quadrature)
    floating, empty = _without_points(grid, integration.element)
    loading = apply_loads(scene.loads, true_sides(scene), grid, integration, fixed)
    radii, growing = scene.fracture.radii, scene.growth is not None
    may_lock = grid.element.locks and bool(materials.locks.any())
    return Body(
        materials=materials,
        triangulation=triangulation,
        grid=grid,
        points=points,
        particle_domains=domains,
        quadrature=quadrature,
        loading=hold_nodes(loading, floating),
        tip_domains=tuple(choose_domains(grid, tip, radii, growing=growing) for tip in grid.tips),
        patches=build_patches(grid, paired) if may_lock else None,
        grown=grown,
        empty_elements=empty,
        floating_nodes=len(floating),
    )


def true_sides(scene: Scene) -> dict[str, list[Side]]:
    """The exact sides of the boundary by the names of their edges; empty for a mesh file."""
    sides: dict[str, list[Side]] = {}
    if scene.geometry is not None:
        for name, side in geometry.BodyShape(scene.geometry).sides:
            sides.setdefault(name, []).append(side)
    return sides


def _without_points(grid: Grid, element: Ints) -> tuple[Ints, int]:
    """Find the nodes of which all triangles are without a point, and count such triangles."""
    filled = np.zeros(len(grid.elements), bool)
    filled[element] = True
    if filled.all():
        return np.empty(0, np.int64), 0
    touched = np.zeros(len(grid.nodes), bool)
    touched[grid.elements[filled]] = True
    return np.flatnonzero(~touched), int((~filled).sum())


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
        If the stiffness of a law at zero strain does not agree with E and nu.
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
                            f"the stiffness of {row.law} at zero strain differs by "
                            f"{100 * part:.2g} % from that of E and nu: make its constants agree "
                            "with E and nu",
                            "material" if name == "body" else f"material of {name}",
                        )
                    ]
                )
    return table
