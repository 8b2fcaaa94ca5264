"""Triangulation from a gmsh mesh file, with the names of its parts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import ModuleType

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from cfmpm.body.grid import Floats, Ints, Triangulation
from cfmpm.errors import Problem, SceneError, did_you_mean
from cfmpm.meshing.drawing import compact, signed_areas
from cfmpm.meshing.session import gmsh_session
from cfmpm.scene.families import expand
from cfmpm.scene.geometry import ON
from cfmpm.scene.model import Scene

# gmsh's element types and their numbers of nodes; the corners come first.
LINES = {1: 2, 8: 3}
TRIANGLES = {2: 3, 9: 6}
# Name of the boundary without a physical curve; cracks need the whole boundary.
UNNAMED = "boundary"


@dataclass(frozen=True)
class FileMesh:
    """The content of a mesh file, with compact node numbers.

    Attributes
    ----------
    nodes : (n, 2) float
    triangles : (m, 3) int
        Anticlockwise.
    surfaces : dict of str to (k,) int
        Triangles of each physical surface.
    curves : dict of str to (k, 2) int
        Node pairs of each physical curve; -1 for a node in no triangle.
    """

    nodes: Floats
    triangles: Ints
    surfaces: Mapping[str, Ints]
    curves: Mapping[str, Ints]

    @cached_property
    def sides(self) -> Ints:
        """The sides of all triangles as node pairs, (3 m, 2)."""
        return self.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)

    @cached_property
    def side_counts(self) -> tuple[Ints, Ints]:
        """The key of each side, and the number of its triangles."""
        return np.unique(self._keys(self.sides), return_counts=True)

    def shared_by(self, pairs: Ints, count: int) -> bool:
        """Whether each node pair is a side of `count` triangles."""
        keys, counts = self.side_counts
        return bool(np.isin(self._keys(pairs), keys[counts == count]).all())

    def boundary_without(self, named: Iterable[Ints]) -> Ints:
        """Node pairs of the boundary that are in none of the given parts, (k, 2)."""
        keys, counts = self.side_counts
        rest = keys[counts == 1]
        for pairs in named:
            rest = np.setdiff1d(rest, self._keys(pairs))
        return np.column_stack(np.divmod(rest, len(self.nodes)))

    def on_boundary(self, node: int) -> bool:
        """Whether a node lies on the boundary."""
        keys, counts = self.side_counts
        return bool(np.isin(node, np.divmod(keys[counts == 1], len(self.nodes))))

    def _keys(self, pairs: Ints) -> Ints:
        """One number for each pair of nodes, independent of their order."""
        return pairs.min(axis=1) * len(self.nodes) + pairs.max(axis=1)


def triangulate_file(scene: Scene) -> Triangulation:
    """Read the triangulation of a scene that has a mesh file.

    Physical curves on the boundary become edges; the rest of the boundary becomes the edge
    ``boundary``. Curves listed as cracks become cracks; a crack starts at the boundary, or else at
    its left end. Only the corner nodes of second-order triangles are used.
    """
    scene = expand(scene)
    assert scene.mesh_file is not None
    mesh = _read(scene.mesh_file.path)
    problems = list(_faults(mesh))
    _raise_if_any(problems)
    cracks = _cracks(mesh, scene.mesh_file.cracks, problems)
    edges = {
        name: pairs
        for name, pairs in mesh.curves.items()
        if name not in cracks and mesh.shared_by(pairs, 1)
    }
    unnamed = mesh.boundary_without(edges.values())
    if len(unnamed):
        edges[UNNAMED] = np.concatenate([*([edges[UNNAMED]] if UNNAMED in edges else []), unnamed])
    points = _points(mesh, scene, problems)
    regions = _regions(mesh, [region.name for region in scene.mesh_file.regions], problems)
    for i, load in enumerate(scene.loads):
        if load.edge is not None and load.edge not in edges:
            reason = (
                f"{load.edge} is not part of the boundary of the mesh"
                if load.edge in mesh.curves
                else f"unknown edge {load.edge}{did_you_mean(load.edge, edges)}"
            )
            problems.append(Problem(reason, f"loads[{i}].edge"))
    _raise_if_any(problems)
    names = ("body", *(region.name for region in scene.mesh_file.regions))
    return Triangulation(mesh.nodes, mesh.triangles, regions, names, edges, cracks, points)


def _raise_if_any(problems: list[Problem]) -> None:
    if problems:
        raise SceneError(problems)


def _refusal(reason: str) -> SceneError:
    return SceneError([Problem(reason, "mesh_file.file")])


def _read(path: str) -> FileMesh:
    """Read a mesh file by gmsh."""
    try:
        with Path(path).open("rb") as file:
            start = file.read(11)
    except OSError as error:
        raise _refusal(f"cannot be read: {error}") from error
    if start != b"$MeshFormat":  # gmsh would run it as a script
        raise _refusal(f"is not a gmsh mesh: {path}")
    with gmsh_session() as gmsh:
        try:
            gmsh.open(path)
        except Exception as error:  # gmsh raises nothing more specific
            raise _refusal(f"cannot be read by gmsh: {error}") from error
        return _content(gmsh)


def _content(gmsh: ModuleType) -> FileMesh:
    mesh = gmsh.model.mesh
    types = [*mesh.getElementTypes(2), *mesh.getElementTypes(3)]
    foreign = [mesh.getElementProperties(t)[0] for t in types if t not in TRIANGLES]
    if foreign:
        raise _refusal(f"has {', '.join(foreign)}; only triangles are supported")
    if not types:
        raise _refusal("has no triangles; was it saved without a physical surface?")
    mesh.removeDuplicateElements()  # format 2 writes an element once for each of its groups
    mesh.renumberNodes()
    tags, coordinates, _ = mesh.getNodes()

    parts: list[Ints] = []
    surfaces: dict[str, list[Ints]] = {}
    count = 0
    for tag, corners in _elements(gmsh, 2, TRIANGLES):
        for name in _physical_names(gmsh, 2, tag):
            surfaces.setdefault(name, []).append(np.arange(count, count + len(corners)))
        parts.append(corners)
        count += len(corners)
    nodes, number = compact(tags, coordinates, np.concatenate(parts))
    triangles = number[np.concatenate(parts)]
    z = coordinates[2::3][number[tags] >= 0]
    if np.ptp(z) > ON * np.ptp(nodes, axis=0).max():
        raise _refusal("is not plane: z must be the same for all nodes")
    clockwise = signed_areas(nodes, triangles) < 0
    triangles[clockwise] = triangles[clockwise, ::-1]

    curves: dict[str, list[Ints]] = {}
    for tag, ends in _elements(gmsh, 1, LINES):
        for name in _physical_names(gmsh, 1, tag):
            curves.setdefault(name, []).append(number[ends])
    return FileMesh(
        nodes,
        triangles,
        {name: np.concatenate(numbers) for name, numbers in sorted(surfaces.items())},
        {name: np.concatenate(pairs) for name, pairs in sorted(curves.items())},
    )


def _elements(gmsh: ModuleType, dim: int, known: dict[int, int]) -> Iterator[tuple[int, Ints]]:
    """The corner nodes of the elements of each entity and type."""
    for _, tag in gmsh.model.getEntities(dim):
        types, _, nodes = gmsh.model.mesh.getElements(dim, tag)
        for kind, flat in zip(types, nodes, strict=True):
            yield tag, flat.reshape(-1, known[kind])[:, : dim + 1].astype(np.int64)


def _physical_names(gmsh: ModuleType, dim: int, entity: int) -> list[str]:
    groups = gmsh.model.getPhysicalGroupsForEntity(dim, entity)
    word = ("point", "curve", "surface")[dim]
    return [gmsh.model.getPhysicalName(dim, g) or f"{word}_{g}" for g in groups]


def _faults(mesh: FileMesh) -> Iterator[Problem]:
    """Faults of a mesh that do not depend on the scene."""
    key = "mesh_file.file"
    _, counts = mesh.side_counts
    if counts.max() > 2:
        n = int((counts > 2).sum())
        yield Problem(f"{n} edges belong to more than two triangles; check for duplicates", key)
    flat = int((signed_areas(mesh.nodes, mesh.triangles) == 0).sum())
    if flat:
        yield Problem(f"{flat} triangles have no area", key)
    n = len(mesh.nodes)
    graph = coo_array((np.ones(len(mesh.sides), dtype=bool), mesh.sides.T), shape=(n, n))
    pieces, _ = connected_components(graph, directed=False)
    if pieces > 1:
        yield Problem(f"has {pieces} parts that share no nodes; merge duplicate nodes", key)


def _cracks(mesh: FileMesh, names: list[str], problems: list[Problem]) -> dict[str, Ints]:
    cracks = {}
    for i, name in enumerate(names):
        reason = ""
        if name not in mesh.curves:
            reason = f"no physical curve {name} in the mesh{did_you_mean(name, mesh.curves)}"
        elif not mesh.shared_by(mesh.curves[name], 2):
            reason = f"{name} does not lie inside the body"
        else:
            line = _line(mesh.curves[name])
            if line is None:
                reason = f"{name} is not a single line with two ends"
            else:
                cracks[name] = _from_first_end(mesh, line)
        if reason:
            problems.append(Problem(reason, f"mesh_file.cracks[{i}]"))
    return cracks


def _line(pairs: Ints) -> Ints | None:
    """Sort node pairs to a line of k + 1 nodes; None if they do not form a line."""
    neighbours: dict[int, list[int]] = {}
    for a, b in pairs.tolist():
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    ends = [node for node, others in neighbours.items() if len(others) == 1]
    if len(ends) != 2 or max(map(len, neighbours.values())) > 2:
        return None
    line = [ends[0], neighbours[ends[0]][0]]
    while line[-1] != ends[1]:
        a, b = neighbours[line[-1]]
        line.append(b if a == line[-2] else a)
    return np.array(line) if len(line) == len(neighbours) else None


def _from_first_end(mesh: FileMesh, line: Ints) -> Ints:
    """Node pairs of a line from its end at the boundary; if none or both are, from its left end."""

    def rank(node: int) -> tuple[bool, float, float]:
        x, y = mesh.nodes[node]
        return not mesh.on_boundary(node), x, y

    if rank(line[-1]) < rank(line[0]):
        line = line[::-1]
    return np.column_stack([line[:-1], line[1:]])


def _points(mesh: FileMesh, scene: Scene, problems: list[Problem]) -> dict[str, int]:
    """The nodes at the load points."""
    points = {}
    reach = ON * np.ptp(mesh.nodes, axis=0).max()
    for i, load in enumerate(scene.loads):
        if load.point is None:
            continue
        distance = np.linalg.norm(mesh.nodes - np.array(load.point), axis=1)
        nearest = int(np.argmin(distance))
        points[str(load.name)] = nearest
        if distance[nearest] > reach:
            x, y = mesh.nodes[nearest]
            reason = f"the mesh has no node there; the nearest is at [{x:.10g}, {y:.10g}]"
            problems.append(Problem(reason, f"loads[{i}].point"))
    return points


def _regions(mesh: FileMesh, names: list[str], problems: list[Problem]) -> Ints:
    """The region of each triangle; triangles in no region are those of the body."""
    regions = np.zeros(len(mesh.triangles), dtype=np.int64)
    for i, name in enumerate(names):
        if name in mesh.surfaces:
            regions[mesh.surfaces[name]] = i + 1
        else:
            known = did_you_mean(name, mesh.surfaces)
            problems.append(
                Problem(
                    f"no physical surface {name} in the mesh{known}", f"mesh_file.regions[{i}].name"
                )
            )
    return regions
