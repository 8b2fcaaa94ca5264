"""The rules of a geometry, for the body of a mesh file."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

import numpy as np
from shapely import LineString

from cfmpm.body.grid import Ints
from cfmpm.errors import Problem
from cfmpm.meshing.file_mesh import FileMesh, parts_without
from cfmpm.registry.loads import LOADS
from cfmpm.scene.body import Crack, Geometry, Hole, Vertex
from cfmpm.scene.geometry import BodyShape
from cfmpm.scene.model import Scene
from cfmpm.scene.rules_crack import misplaced_cracks
from cfmpm.scene.rules_load import misplaced_loads

# Of the size of the body, and well below its smallest distance that counts (scene.geometry.ON): how
# far the corners of a line may leave its nodes.
STRAIGHT = 1e-7


def broken_rules_of_file(
    mesh: FileMesh, scene: Scene, edges: Mapping[str, Ints], cracks: Mapping[str, Ints]
) -> Iterator[Problem]:
    """Every rule of a geometry that a sound mesh breaks with a scene.

    Parameters
    ----------
    mesh : FileMesh
    scene : Scene
        Expanded.
    edges, cracks : mapping of str to (k, 2) int
        Node pairs; cracks in the order of their lines.
    """
    assert scene.mesh_file is not None
    yield from _overlapping_regions(mesh, scene)
    yield from _held_tractions(mesh, scene, edges)
    shared = list(_cracks_that_meet(mesh, scene.mesh_file.cracks, cracks))
    yield from shared
    if shared:
        return
    body = BodyShape(_geometry(mesh, edges, cracks))
    numbers = [scene.mesh_file.cracks.index(name) for name in cracks]
    found = []
    for key, reason in misplaced_cracks(body):
        crack = re.match(r"geometry\.cracks\[(\d+)\]", key)
        assert crack is not None
        found.append(Problem(reason, f"mesh_file.cracks[{numbers[int(crack[1])]}]"))
    if not found and cracks and parts_without(mesh, np.concatenate(list(cracks.values()))) > 1:
        found.append(Problem("the cracks cut the body in two", "mesh_file.cracks"))
    yield from found
    yield from (Problem(reason, key) for key, reason in misplaced_loads(scene, body))
    if scene.growth is not None and cracks and not body.tips and not found:
        yield Problem("needs a crack that ends inside the body: the scene has none", "growth")
    if isinstance(scene.fracture.radii, list):
        for i, radius in enumerate(scene.fracture.radii):
            if radius > body.size:
                reason = f"{radius:g} mm is larger than the body, {body.size:g} mm"
                yield Problem(reason, f"fracture.radii[{i}]")


def _geometry(mesh: FileMesh, edges: Mapping[str, Ints], cracks: Mapping[str, Ints]) -> Geometry:
    """The body as a geometry: a corner at each node of the boundary."""
    name_of: dict[int, str] = {}
    for name, pairs in reversed(list(edges.items())):
        name_of.update(dict.fromkeys(mesh.keys(pairs).tolist(), name))
    outline, *holes = (
        [(name, place) for name, place in _named(mesh, loop, name_of)] for loop in mesh.loops
    )
    taken = {name for name, _ in outline}
    shapes = []
    for i, hole in enumerate(holes, 1):
        name = hole[0][0] if hole[0][0] not in taken else f"{hole[0][0]} (hole {i})"
        taken.add(name)
        shapes.append(Hole.model_construct(name=name, polygon=_corners(hole)))
    lines = [
        Crack.model_construct(name=name, points=_line(mesh, np.append(pairs[:, 0], pairs[-1, 1])))
        for name, pairs in cracks.items()
    ]
    return Geometry.model_construct(
        outline=_corners(outline), holes=shapes, cracks=lines, regions=[]
    )


def _named(
    mesh: FileMesh, loop: Ints, name_of: Mapping[int, str]
) -> Iterator[tuple[str, tuple[float, float]]]:
    """The name of the side that leaves each node of a closed line, and the place of the node."""
    keys = mesh.keys(np.column_stack([loop, np.roll(loop, -1)]))
    for key, (x, y) in zip(keys.tolist(), mesh.nodes[loop].tolist(), strict=True):
        yield name_of[key], (x, y)


def _corners(line: list[tuple[str, tuple[float, float]]]) -> list[Vertex]:
    return [Vertex.model_construct(at=place, edge=name, through=None) for name, place in line]


def _line(mesh: FileMesh, nodes: Ints) -> list[tuple[float, float]]:
    """The corners of a line of nodes."""
    line = LineString(mesh.nodes[nodes]).simplify(STRAIGHT * mesh.size)
    return [(x, y) for x, y in line.coords]


def _overlapping_regions(mesh: FileMesh, scene: Scene) -> Iterator[Problem]:
    """Find triangles in two regions of the scene: their material is ambiguous."""
    assert scene.mesh_file is not None
    owner = np.full(len(mesh.triangles), -1)
    regions = scene.mesh_file.regions
    for i, region in enumerate(regions):
        rows = mesh.surfaces.get(region.name, np.empty(0, np.int64))
        before = owner[rows][owner[rows] >= 0]
        if len(before):
            reason = f"overlaps region {regions[before[0]].name}, in {len(before)} triangles"
            yield Problem(reason, f"mesh_file.regions[{i}]")
        owner[rows] = i


def _held_tractions(mesh: FileMesh, scene: Scene, edges: Mapping[str, Ints]) -> Iterator[Problem]:
    """Find tractions on groups of which every side also belongs to a group with a support."""
    for i, load in enumerate(scene.loads):
        pairs = edges.get(str(load.edge))
        if LOADS[load.kind].holds or pairs is None or not isinstance(load.value, tuple):
            continue
        for component, value in zip("xy", load.value, strict=True):
            holding, held = [], [np.empty(0, np.int64)]
            for k, other in enumerate(scene.loads):
                keys = mesh.keys(edges.get(str(other.edge), np.empty((0, 2), np.int64)))
                holds = getattr(other.displacement, component, None) is not None
                if other.edge != load.edge and holds and np.isin(mesh.keys(pairs), keys).any():
                    holding.append(k)
                    held.append(keys)
            if value != 0.0 and np.isin(mesh.keys(pairs), np.concatenate(held)).all():
                yield Problem(
                    f"{value:g} in {component} has no effect: loads[{holding[0]}], on the same "
                    f"sides of the mesh, prescribes the displacement in {component} there and "
                    "carries it; remove one of them",
                    f"loads[{i}].{load.kind}",
                )


def _cracks_that_meet(
    mesh: FileMesh, names: list[str], cracks: Mapping[str, Ints]
) -> Iterator[Problem]:
    """Cracks that share sides or nodes."""
    lines = list(cracks.items())
    for i, (name, pairs) in enumerate(lines):
        for other, others in lines[:i]:
            nodes = np.intersect1d(pairs, others)
            if not len(nodes):
                continue
            key = f"mesh_file.cracks[{names.index(name)}]"
            if np.isin(mesh.keys(pairs), mesh.keys(others)).any():
                yield Problem(f"has sides of {other} too; list one of them", key)
            elif len(nodes) == 1 and {nodes[0]} <= {*_ends(pairs)} & {*_ends(others)}:
                reason = (
                    f"meets {other} end to end: not supported; if they are one crack, put their "
                    "curves into one physical curve"
                )
                yield Problem(reason, key)
            else:
                yield Problem(f"crosses or touches {other}, which is not supported", key)


def _ends(pairs: Ints) -> tuple[int, int]:
    return int(pairs[0, 0]), int(pairs[-1, 1])
