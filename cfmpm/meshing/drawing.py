"""Meshing of curves and points in the unit frame, by gmsh with its OpenCASCADE kernel."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType

import numpy as np

from cfmpm.body.grid import Floats, Ints, signed_areas
from cfmpm.errors import MeshError
from cfmpm.kernels.triangles import triangle_quality
from cfmpm.meshing.sizes import GROWTH
from cfmpm.scene.shapes import XY, Side

LEAST_QUALITY = 0.3
MOST_REPAIRS = 4


@dataclass(frozen=True)
class Drawing:
    """The curves and points to be meshed, in the unit frame: a body of size one about the origin.

    Attributes
    ----------
    lines : list of list of Side
        Closed lines: the outline, then the holes.
    regions : list of list of Side
        Closed lines, which may extend beyond the body.
    cracks : list of Side
        Straight segments inside the body.
    points : list of (x, y)
        Points that become nodes.
    """

    lines: list[list[Side]]
    regions: list[list[Side]]
    cracks: list[Side]
    points: list[XY]


@dataclass(frozen=True)
class Seeds:
    """Points with small elements: size + growth r at distance r from the nearest of `points`."""

    points: Floats
    size: float
    growth: float


@dataclass(frozen=True)
class Raw:
    """A mesh by gmsh, with compact node numbers.

    Attributes
    ----------
    nodes : (n, 2) float
    triangles : (m, 3) int
        Anticlockwise.
    surfaces : (m,) int
        Face of the drawing of each triangle.
    curves : list of ((3, 2) float, (k, 2) int)
        Both ends and the midpoint of each curve of the drawing, and its node pairs; -1 for a node
        in no triangle.
    vertices : (v,) int
        Nodes at corners and points of the drawing.
    """

    nodes: Floats
    triangles: Ints
    surfaces: Ints
    curves: list[tuple[Floats, Ints]]
    vertices: Ints


class TooManyTrianglesError(Exception):
    """Thin parts would need more triangles than are allowed.

    Its arguments: about how many, the place (x, y) and the height of the thinnest part in the unit
    frame.
    """


def mesh_drawing(
    gmsh: ModuleType, drawing: Drawing, size: float, seeds: list[Seeds], most: float = math.inf
) -> Raw:
    """Mesh a drawing.

    If a short edge or a thin ligament causes triangles of low quality, the mesh is made again with
    elements as small as the height of these triangles.

    Parameters
    ----------
    size : float
        Element size away from the seeds.
    most : float
        How many triangles may be added to a mesh at once where it is thin.

    Raises
    ------
    MeshError
        Where gmsh fails.
    TooManyTrianglesError
    """
    _draw(gmsh, drawing)
    best = _generate(gmsh, size, seeds)
    worst = triangle_quality(best.nodes, best.triangles).min()
    for _ in range(MOST_REPAIRS):
        if worst >= LEAST_QUALITY:
            break
        finer = _seeds_at_bad_triangles(best)
        _check_number(best, finer, most)
        seeds = seeds + finer
        again = _generate(gmsh, size, seeds)
        improved = triangle_quality(again.nodes, again.triangles).min()
        if improved <= 1.1 * worst:  # an acute corner, for which no element size helps
            break
        best, worst = again, improved
    return best


def compact(tags: Ints, coordinates: Floats, triangles: Ints) -> tuple[Floats, Ints]:
    """Return the coordinates (n, 2) of the nodes in triangles, and the number of each node tag.

    The numbers follow the order of `tags`; -1 for a node in no triangle.
    """
    used = np.zeros(int(tags.max()) + 1, dtype=bool)
    used[triangles] = True
    kept = tags[used[tags]]
    number = np.full(len(used), -1)
    number[kept] = np.arange(len(kept))
    return coordinates.reshape(-1, 3)[used[tags], :2], number


def _draw(gmsh: ModuleType, drawing: Drawing) -> None:
    """Make a conforming drawing, in which cracks, regions and points split faces and curves."""
    cad = gmsh.model.occ
    body = _face(cad, drawing.lines)
    tools = [(2, _face(cad, [region])) for region in drawing.regions]
    tools += [(1, _curve(cad, side, _point(cad, side.start))) for side in drawing.cracks]
    tools += [(0, _point(cad, point)) for point in drawing.points]
    if tools:
        area = cad.getMass(2, body)
        faces, children = cad.fragment([(2, body)], tools)
        inside = set(children[0])
        if not np.isclose(sum(cad.getMass(*face) for face in inside), area, rtol=1e-6):
            raise MeshError(
                "the geometry could not be cut along its cracks and regions: "
                "check for lines that nearly coincide"
            )
        outside = {face for face in faces if face[0] == 2} - inside
        cad.remove(sorted(outside), recursive=True)
    cad.synchronize()


def _face(cad: ModuleType, lines: Sequence[Sequence[Side]]) -> int:
    """Draw the face inside the first closed line and outside the others."""
    loops = []
    for line in lines:
        starts = [_point(cad, side.start) for side in line]
        ends = [*starts[1:], starts[0]]
        loops.append(
            cad.addCurveLoop([_curve(cad, *s) for s in zip(line, starts, ends, strict=True)])
        )
    return int(cad.addPlaneSurface(loops))


def _curve(cad: ModuleType, side: Side, start: int, end: int | None = None) -> int:
    end = end or _point(cad, side.end)
    if side.through is None:
        return int(cad.addLine(start, end))
    return int(cad.addCircleArc(start, _point(cad, side.through), end, center=False))


def _point(cad: ModuleType, at: XY) -> int:
    return int(cad.addPoint(*at, 0))


def _generate(gmsh: ModuleType, size: float, seeds: Sequence[Seeds]) -> Raw:
    """Mesh the drawing."""
    gmsh.model.mesh.clear()
    _set_sizes(gmsh, size, seeds)
    try:
        gmsh.model.mesh.generate(2)
    except Exception as error:  # gmsh raises nothing more specific
        raise MeshError(
            f"gmsh could not mesh the body ({error}): check for lines that cross or nearly touch, "
            "or change mesh.size"
        ) from error
    return _raw(gmsh)


def _set_sizes(gmsh: ModuleType, size: float, seeds: Sequence[Seeds]) -> None:
    """Set the background field min(size, size at seeds + growth r)."""
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    field = gmsh.model.mesh.field
    for old in field.list():
        field.remove(old)
    seeds = [seed for seed in seeds if seed.size < size]
    # Isolated points: their nodes are in no triangle and are removed afterwards.
    tags = [[_point(gmsh.model.occ, p) for p in seed.points] for seed in seeds]
    gmsh.model.occ.synchronize()
    cones = []
    for seed, points in zip(seeds, tags, strict=True):
        distance, cone = field.add("Distance"), field.add("Threshold")
        field.setNumbers(distance, "PointsList", points)
        for option, value in {
            "InField": distance,
            "SizeMin": seed.size,
            "SizeMax": size,
            "DistMin": 0,
            "DistMax": (size - seed.size) / seed.growth,
        }.items():
            field.setNumber(cone, option, value)
        cones.append(cone)
    if cones:
        smallest_of_all = field.add("Min")
        field.setNumbers(smallest_of_all, "FieldsList", cones)
        field.setAsBackgroundMesh(smallest_of_all)


def _raw(gmsh: ModuleType) -> Raw:
    """Fetch the mesh from gmsh."""
    mesh = gmsh.model.mesh
    tags, coordinates, _ = mesh.getNodes()
    faces = [
        mesh.getElementsByType(2, tag)[1].reshape(-1, 3) for _, tag in gmsh.model.getEntities(2)
    ]
    triangles = np.concatenate(faces)
    nodes, number = compact(tags, coordinates, triangles)
    for face in faces:
        if signed_areas(nodes[number[face[:1]]])[0] < 0:  # the face is clockwise
            face[:] = face[:, ::-1]
    curves = []
    for _, tag in gmsh.model.getEntities(1):
        (start,), (end,) = gmsh.model.getParametrizationBounds(1, tag)
        ends_and_middle = gmsh.model.getValue(1, tag, [start, (start + end) / 2, end])
        pairs = number[mesh.getElementsByType(1, tag)[1].reshape(-1, 2)]
        curves.append((ends_and_middle.reshape(3, 3)[:, :2], pairs))
    vertices = number[mesh.getNodes(0)[0]]
    return Raw(
        nodes,
        number[np.concatenate(faces)],
        np.repeat(np.arange(len(faces)), [len(face) for face in faces]),
        curves,
        vertices[vertices >= 0],
    )


def _check_number(raw: Raw, seeds: Sequence[Seeds], most: float) -> None:
    """Refuse seeds around which there would be more triangles than are allowed."""
    corners = raw.nodes[raw.triangles[triangle_quality(raw.nodes, raw.triangles) < LEAST_QUALITY]]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    expected = 0.0
    for seed in seeds:
        # The integral of 2 pi r / (area of a triangle of size t + growth r) dr over half the mean
        # distance of the seeds.
        reach = seed.growth * 0.5 * longest.mean() / seed.size
        around = math.tau / (0.433 * seed.growth**2) * (math.log1p(reach) - reach / (1 + reach))
        expected += len(seed.points) * around
    if expected > most:
        thinnest = min(seeds, key=lambda seed: seed.size)
        raise TooManyTrianglesError(expected, tuple(thinnest.points[0].tolist()), thinnest.size)


def _seeds_at_bad_triangles(raw: Raw) -> list[Seeds]:
    """Seeds of the height of the triangles of low quality, in classes of a factor of two."""
    corners = raw.nodes[raw.triangles[triangle_quality(raw.nodes, raw.triangles) < LEAST_QUALITY]]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    areas = signed_areas(corners)
    # A degenerate triangle, at points closer than gmsh's accuracy, has no height.
    power = np.floor(np.log2(np.maximum(2 * areas, 1e-3 * longest**2) / longest))
    return [Seeds(corners[power == p].mean(axis=1), float(2**p), GROWTH) for p in np.unique(power)]
