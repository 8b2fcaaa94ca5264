"""A gmsh mesh file as a triangulation with names."""

from __future__ import annotations

from collections.abc import Collection, Container, Iterator
from itertools import chain, count

import numpy as np

from cfmpm.body.grid import Ints, Triangulation, signed_areas
from cfmpm.errors import Problem, SceneError, did_you_mean
from cfmpm.input_file import open_file
from cfmpm.meshing.file_mesh import FileMesh, broken_body, broken_triangles, parts_apart
from cfmpm.meshing.file_rules import broken_rules_of_file
from cfmpm.meshing.lips import Closed, close_lips, unlisted_lips
from cfmpm.meshing.msh import read_msh
from cfmpm.meshing.msh_numbers import DamagedError
from cfmpm.scene.families import expand
from cfmpm.scene.geometry import ON
from cfmpm.scene.model import Scene

# The edge of what no physical curve names: cracks have to know the whole boundary.
UNNAMED = "boundary"


def triangulate_file(scene: Scene) -> Triangulation:
    """Read the triangulation of a scene that has a mesh file.

    Physical curves on the boundary become edges; what none of them names becomes the edge
    ``boundary``. Those listed as cracks become cracks; each begins at the boundary, or else at its
    left end. One that is open in the file already ends where its lips meet. Of triangles with mid
    nodes only the corners count. What is found has to obey the rules of a geometry.
    """
    scene = expand(scene)
    assert scene.mesh_file is not None
    mesh = _read(scene.mesh_file.path)
    problems: list[Problem] = []
    _refuse(broken_triangles(mesh), problems)
    closed = close_lips(mesh, scene.mesh_file.cracks, problems)
    mesh = closed.mesh
    unlisted = unlisted_lips(mesh, listed=bool(closed.open))
    _refuse(chain(parts_apart(mesh), unlisted, broken_body(mesh)), problems)
    refused = {problem.key for problem in problems}
    cracks = _cracks(closed, scene.mesh_file.cracks, problems, refused)
    edges = {
        name: pairs
        for name, pairs in mesh.curves.items()
        if name not in cracks and (mesh.count_of(pairs) == 1).all()
    }
    unnamed = mesh.without(edges.values())
    if len(unnamed):
        edges[_free(UNNAMED, mesh.curves)] = unnamed
    problems += _unknown_edges(mesh, scene, edges, closed.open)
    problems += broken_rules_of_file(mesh, scene, edges, cracks)
    points = _points(mesh, scene, problems)
    regions = _regions(mesh, [region.name for region in scene.mesh_file.regions], problems)
    _raise_if_any(list({problem.key: problem for problem in reversed(problems)}.values())[::-1])
    names = ("body", *(region.name for region in scene.mesh_file.regions))
    return Triangulation(mesh.nodes, mesh.triangles, regions, names, edges, cracks, points)


def _refuse(reasons: Iterator[str], known: list[Problem]) -> None:
    """Refuse the file for what is known to be wrong, or else for the first of some reasons."""
    for reason in reasons:
        _raise_if_any(known)
        raise _refusal(reason)


def _free(name: str, taken: Container[str]) -> str:
    """A name that no group of the file has."""
    tries = chain([name], (f"{name}_{i}" for i in count(2)))
    return next(word for word in tries if word not in taken)


def _unknown_edges(
    mesh: FileMesh, scene: Scene, edges: Collection[str], lips: Container[str]
) -> Iterator[Problem]:
    """Loads on curves that are no edges."""
    for i, load in enumerate(scene.loads):
        if load.edge is None or load.edge in edges:
            continue
        reason = f"unknown edge {load.edge}{did_you_mean(load.edge, edges)}"
        if load.edge in mesh.curves:
            reason = f"{load.edge} is not part of the boundary of the mesh"
        if load.edge in lips:
            reason = f"{load.edge} is a crack"
        yield Problem(reason, f"loads[{i}].edge")


def _raise_if_any(problems: list[Problem]) -> None:
    if problems:
        raise SceneError(problems)


def _refusal(reason: str) -> SceneError:
    return SceneError([Problem(reason, "mesh_file.file")])


def _read(path: str) -> FileMesh:
    """Read a mesh file."""
    try:
        with open_file(path) as file:
            contents = read_msh(file.read())
    except OSError as error:
        raise _refusal(f"cannot be read: {error.strerror}") from error
    except DamagedError as error:
        raise _refusal(str(error)) from error
    used, number = np.unique(contents.triangles, return_inverse=True)
    nodes, z = contents.nodes[used, :2], contents.nodes[used, 2]
    if np.ptp(z) > ON * np.ptp(nodes, axis=0).max():
        raise _refusal("is not plane: z must be the same for all nodes")
    triangles = number.reshape(-1, 3).astype(np.int64)
    clockwise = signed_areas(nodes[triangles]) < 0
    triangles[clockwise] = triangles[clockwise, ::-1]
    number_of = np.full(len(contents.nodes), -1)
    number_of[used] = np.arange(len(used))
    curves = {name: number_of[contents.lines[rows]] for name, rows in contents.curves.items()}
    return FileMesh(nodes, triangles, contents.surfaces, curves)


def _cracks(
    closed: Closed, names: list[str], problems: list[Problem], refused: Container[str]
) -> dict[str, Ints]:
    """The listed cracks as lines; those refused before are left out."""
    mesh, cracks = closed.mesh, {}
    for i, name in enumerate(names):
        key = f"mesh_file.cracks[{i}]"
        if key in refused:
            continue
        pairs = closed.open.get(name, mesh.curves.get(name))
        reason = ""
        if pairs is None:
            reason = f"no physical curve {name} in the mesh{did_you_mean(name, mesh.curves)}"
        elif not (mesh.count_of(pairs) == 2).all():
            reason = f"{name} does not lie inside the body"
        else:
            line = _line(pairs)
            if line is None:
                reason = (
                    f"{name} is not a single line with two ends; each crack needs a physical curve "
                    "of its own"
                )
            else:
                cracks[name] = _from_first_end(mesh, line)
        if reason:
            problems.append(Problem(reason, key))
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
        return node not in mesh.on_boundary, x, y

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
