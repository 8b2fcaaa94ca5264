"""A gmsh mesh file as a triangulation with names."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from cfmpm.body.grid import Floats, Ints, Triangulation
from cfmpm.errors import Problem, SceneError, did_you_mean
from cfmpm.meshing.drawing import signed_areas
from cfmpm.meshing.msh import read_msh
from cfmpm.meshing.msh_numbers import DamagedError
from cfmpm.scene.families import expand
from cfmpm.scene.geometry import ON
from cfmpm.scene.model import Scene

# The edge of what no physical curve names: cracks have to know the whole boundary.
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
        Node pairs of each physical curve; -1 stands for a node in no triangle.
    """

    nodes: Floats
    triangles: Ints
    surfaces: dict[str, Ints]
    curves: dict[str, Ints]

    @cached_property
    def sides(self) -> Ints:
        """The sides of all triangles as node pairs, (3 m, 2)."""
        return self.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)

    @cached_property
    def side_counts(self) -> tuple[Ints, Ints]:
        """The key of each side, and how many triangles share it."""
        return np.unique(self._keys(self.sides), return_counts=True)

    def shared_by(self, pairs: Ints, count: int) -> bool:
        """Whether each node pair is a side of so many triangles."""
        keys, counts = self.side_counts
        return bool(np.isin(self._keys(pairs), keys[counts == count]).all())

    def boundary_without(self, named: Iterable[Ints]) -> Ints:
        """Node pairs of the boundary that are in none of the parts given, (k, 2)."""
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
        """One number for each pair of nodes, the same in either sense."""
        return pairs.min(axis=1) * len(self.nodes) + pairs.max(axis=1)


def triangulate_file(scene: Scene) -> Triangulation:
    """Read the triangulation of a scene that has a mesh file.

    Physical curves on the boundary become edges; what none of them names becomes the edge
    ``boundary``. Those listed as cracks become cracks; each begins
    at the boundary, or else at its left end. Of triangles with mid nodes only the corners count.
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
                f"{load.edge} is no part of the boundary of the mesh"
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
    """Read a mesh file."""
    try:
        contents = read_msh(Path(path).read_bytes())
    except OSError as error:
        raise _refusal(f"cannot be read: {error.strerror}") from error
    except DamagedError as error:
        raise _refusal(str(error)) from error
    used, number = np.unique(contents.triangles, return_inverse=True)
    nodes, z = contents.nodes[used, :2], contents.nodes[used, 2]
    if np.ptp(z) > ON * np.ptp(nodes, axis=0).max():
        raise _refusal("is not plane: z must be the same for all nodes")
    triangles = number.reshape(-1, 3).astype(np.int64)
    clockwise = signed_areas(nodes, triangles) < 0
    triangles[clockwise] = triangles[clockwise, ::-1]
    number_of = np.full(len(contents.nodes), -1)
    number_of[used] = np.arange(len(used))
    curves = {name: number_of[contents.lines[rows]] for name, rows in contents.curves.items()}
    return FileMesh(nodes, triangles, contents.surfaces, curves)


def _faults(mesh: FileMesh) -> Iterator[Problem]:
    """What makes a mesh useless, whatever the scene."""
    key = "mesh_file.file"
    _, counts = mesh.side_counts
    if counts.max() > 2:
        n = int((counts > 2).sum())
        yield Problem(f"{n} edges belong to more than two triangles: is something twice?", key)
    flat = int((signed_areas(mesh.nodes, mesh.triangles) == 0).sum())
    if flat:
        yield Problem(f"{flat} triangles have no area", key)
    n = len(mesh.nodes)
    graph = coo_array((np.ones(len(mesh.sides), dtype=bool), mesh.sides.T), shape=(n, n))
    pieces, _ = connected_components(graph, directed=False)
    if pieces > 1:
        yield Problem(f"is in {pieces} pieces that share no nodes; merge equal nodes", key)


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
    """Put node pairs in the order of a line, (k + 1,) nodes; None if they are not one."""
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
    """Node pairs of a line from its mouth or, without one or with two, from its left end."""

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
    """The region of each triangle; the body is what belongs to none."""
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
