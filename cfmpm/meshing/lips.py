"""Cracks that are open in a mesh file already: their lips are put together.

A crack that gmsh's plugin Crack has opened, an outline that runs around a slit, and surfaces that
were meshed apart have two lips of coincident nodes. Put together they are a line inside the body,
as in a file whose crack is closed, which is opened where all cracks are.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from cfmpm.body.grid import Ints
from cfmpm.errors import Problem
from cfmpm.meshing.file_mesh import FileMesh
from cfmpm.scene.geometry import ON
from cfmpm.scene.rules_body import at

# Of the shortest side of the boundary: nodes nearer than that coincide.
NEAR = 1e-3


@dataclass(frozen=True)
class Closed:
    """A mesh whose open cracks have been closed.

    Attributes
    ----------
    mesh : FileMesh
    open : dict of str to (k, 2) int
        Node pairs of each crack that was open in the file: where its lips coincide.
    """

    mesh: FileMesh
    open: dict[str, Ints]


def close_lips(mesh: FileMesh, cracks: Sequence[str], problems: list[Problem]) -> Closed:
    """Put the lips of listed cracks together where these are open.

    Parameters
    ----------
    mesh : FileMesh
    cracks : sequence of str
        Names of physical curves; those that the mesh does not have are left out.
    problems : list of Problem
        Added to for a crack on the boundary without a second lip.

    Returns
    -------
    Closed
        A crack of which a part is open is that part.
    """
    lips = {}
    for name in cracks:
        if name in mesh.curves:
            pairs = mesh.curves[name]
            on_boundary = mesh.count_of(pairs) == 1
            if on_boundary.any():
                lips[name] = pairs[on_boundary]
    if not lips:
        return Closed(mesh, {})
    groups = _coincident(mesh)
    on_lips = np.unique(np.concatenate(list(lips.values())))
    glued = np.isin(groups, groups[on_lips])
    target = np.where(glued, groups, np.arange(len(mesh.nodes)))
    closed, number = _merged(mesh, target)
    found = {}
    for name, pairs in lips.items():
        line = _unique(closed, number[pairs])
        if (closed.count_of(line) == 2).all():
            found[name] = line
        else:
            i = list(cracks).index(name)
            problems.append(Problem(_no_second_lip(mesh, name, pairs), f"mesh_file.cracks[{i}]"))
    return Closed(closed, found)


def unlisted_lips(mesh: FileMesh, *, listed: bool) -> Iterator[str]:
    """Coincident nodes on the boundary that belong to no crack of the scene."""
    groups = _coincident(mesh)
    double = np.flatnonzero(np.bincount(groups) > 1)
    if not len(double):
        return
    here = np.flatnonzero(np.isin(groups, double))
    names = [
        name
        for name, pairs in mesh.curves.items()
        if np.isin(pairs, here).any(axis=1).all() and (mesh.count_of(pairs) == 1).all()
    ]
    places = mesh.nodes[double]
    a, b = (places[np.lexsort(places.T[::-1])[k]].tolist() for k in (0, -1))
    crack = f"list {' or '.join(names)}" if names else "put it into a physical curve and list that"
    also = "also " if listed else ""
    yield (
        f"is {also}open along {len(double)} places where nodes coincide, from {at((a[0], a[1]))} "
        f"to {at((b[0], b[1]))}; if this is a crack, {crack} in mesh_file.cracks, else merge equal "
        "nodes (gmsh: Coherence Mesh)"
    )


def _coincident(mesh: FileMesh) -> Ints:
    """The first of the nodes at the place of each node, those inside the body by themselves."""
    n = len(mesh.nodes)
    here = mesh.on_boundary
    sides = mesh.nodes[mesh.boundary]
    shortest = float(np.hypot(*(sides[:, 1] - sides[:, 0]).T).min())
    near = KDTree(mesh.nodes[here]).query_pairs(
        min(ON * mesh.size, NEAR * shortest), output_type="ndarray"
    )
    joined = here[near].reshape(-1, 2)
    graph = coo_array((np.ones(len(joined), dtype=bool), joined.T), shape=(n, n))
    _, label = connected_components(graph, directed=False)
    _, first = np.unique(label, return_index=True)
    return first[label]


def _merged(mesh: FileMesh, target: Ints) -> tuple[FileMesh, Ints]:
    """Put each node in the place of another one; also the new number of each node."""
    kept, number = np.unique(target, return_inverse=True)
    merged = replace(mesh, nodes=mesh.nodes[kept], triangles=number[mesh.triangles])
    curves = {
        # A node in no triangle is -1.
        name: _unique(merged, np.where(pairs >= 0, number[pairs], -1))
        for name, pairs in mesh.curves.items()
    }
    return replace(merged, curves=curves), number


def _unique(mesh: FileMesh, pairs: Ints) -> Ints:
    """Each node pair once, as where a group holds both lips."""
    _, first = np.unique(mesh.keys(pairs), return_index=True)
    return pairs[np.sort(first)]


def _no_second_lip(mesh: FileMesh, name: str, pairs: Ints) -> str:
    """Say why a crack on the boundary cannot be closed."""
    others = mesh.without([pairs])
    middles = mesh.nodes[pairs].mean(axis=1)
    length = np.hypot(*(mesh.nodes[pairs[:, 1]] - mesh.nodes[pairs[:, 0]]).T)
    distance = np.full(len(pairs), np.inf)
    for a, b in mesh.nodes[others]:
        along = np.clip((middles - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        distance = np.minimum(distance, np.hypot(*(a + along[:, None] * (b - a) - middles).T))
    if (distance <= NEAR * length).all():
        return (
            f"{name} is open, and its lips do not have the same nodes; mesh both alike, or as "
            "one line inside the body"
        )
    return (
        f"{name} does not lie inside the body: it is a part of the boundary without a second lip "
        "at the same place; a slot with width is no crack"
    )
