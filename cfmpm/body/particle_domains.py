"""Integration over particle domains, by their intersections with the triangles of a grid."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from cfmpm.body.grid import Floats, Grid, Ints
from cfmpm.body.points import DeformedPoints, MaterialPoints
from cfmpm.kernels import clipping


@dataclass(frozen=True)
class ParticleDomains:
    """The convex polygon that each material point represents.

    Attributes
    ----------
    anchors : (p, 2) float
        A point near each domain, a node of the initial grid [mm].
    vertices : (v, 2) float
        Corners, anticlockwise, relative to the anchor [mm]. Relative coordinates avoid loss of
        digits for bodies far from the origin.
    offsets : (p + 1,) int
        The corners of domain p are ``vertices[offsets[p]:offsets[p + 1]]``.
    """

    anchors: Floats
    vertices: Floats
    offsets: Ints

    def __len__(self) -> int:
        return len(self.anchors)

    def polygon(self, p: int) -> Floats:
        """Coordinates of the corners of domain p [mm], (k, 2)."""
        return self.anchors[p] + self.vertices[self.offsets[p] : self.offsets[p + 1]]


@dataclass(frozen=True)
class Quadrature:
    """Quadrature points, in ascending order of their triangles.

    Attributes
    ----------
    owner : (q,) int
        Material point of each quadrature point.
    element : (q,) int
        Triangle of each quadrature point.
    position : (q, 2) float
        [mm].
    volume : (q,) float
        Volume per mm of thickness [mm^2].
    material : (q,) int
        Row of the material table, that of the owner.
    """

    owner: Ints
    element: Ints
    position: Floats
    volume: Floats
    material: Ints

    def __len__(self) -> int:
        return len(self.owner)


def initial_domains(grid: Grid) -> ParticleDomains:
    """Divide the triangles of a grid into the domains of the points of `points.seed`.

    Parameters
    ----------
    grid : Grid

    Returns
    -------
    ParticleDomains
        The polygons of the element.
    """
    polygons = grid.element.domains
    assert polygons is not None  # a rule of scenes
    corners = grid.nodes[grid.triangles]
    # From the corner that each polygon begins at, or next to.
    begin = [int(np.argmax(polygon[0])) for polygon in polygons]
    vertices = [
        np.einsum("vc,ecd->evd", polygon, corners - corners[:, [corner]])
        / polygon.sum(axis=1)[:, None]
        for polygon, corner in zip(polygons, begin, strict=True)
    ]
    counts = np.tile([len(polygon) for polygon in polygons], len(corners))
    return ParticleDomains(
        anchors=corners[:, begin].reshape(-1, 2),
        vertices=np.concatenate(vertices, axis=1).reshape(-1, 2),
        offsets=np.concatenate([[0], np.cumsum(counts)]),
    )


def triangular_domains(corners: Floats) -> ParticleDomains:
    """Make domains of triangles, (p, 3, 2) corners anticlockwise [mm]."""
    anchors = corners[:, 0]
    vertices = (corners - anchors[:, None]).reshape(-1, 2)
    return ParticleDomains(anchors, vertices, 3 * np.arange(len(anchors) + 1))


def initial_quadrature(points: MaterialPoints) -> Quadrature:
    """Use new material points as quadrature points; arrays are shared, not copied."""
    return Quadrature(
        owner=np.arange(len(points)),
        element=points.element,
        position=points.position,
        volume=points.volume,
        material=points.material,
    )


def as_points(quadrature: Quadrature) -> MaterialPoints:
    """Return quadrature points as `MaterialPoints`; arrays are shared."""
    return MaterialPoints(
        position=quadrature.position,
        volume=quadrature.volume,
        element=quadrature.element,
        material=quadrature.material,
    )


def realign(
    quadrature: Quadrature,
    domains: ParticleDomains,
    points: MaterialPoints,
    grid: Grid,
    changed: Ints,
) -> Quadrature:
    """Renew the quadrature points in triangles of the grid that were changed.

    Parameters
    ----------
    quadrature : Quadrature
        Quadrature of the grid before the change.
    domains : ParticleDomains
    points : MaterialPoints
    grid : Grid
        The grid after the change: old triangles keep their numbers, new ones are appended.
    changed : (k,) int
        Triangles that are new or have changed their shape. Their union does not change; any part of
        a domain outside the grid is lost.

    Returns
    -------
    Quadrature
        Unchanged triangles keep their quadrature points.
    """
    return _clip_again(quadrature, domains, points, grid, changed, np.empty(0, np.int64))


def _clip_again(
    quadrature: Quadrature,
    domains: ParticleDomains,
    points: MaterialPoints,
    grid: Grid,
    changed: Ints,
    newcomers: Ints,
) -> Quadrature:
    """Renew the quadrature in `changed`, over the domains present there and `newcomers`."""
    is_changed = np.zeros(len(grid.elements), bool)
    is_changed[changed] = True
    dropped = is_changed[quadrature.element]
    is_there = np.zeros(len(domains), bool)
    is_there[quadrature.owner[dropped]] = True
    is_there[newcomers] = True
    owner, element, position, volume = clipping.clip_domains(
        grid.nodes,
        grid.elements,
        grid.element.points,
        grid.element.weights,
        np.flatnonzero(is_changed),
        domains.anchors,
        domains.vertices,
        domains.offsets,
        np.flatnonzero(is_there),
    )
    clipped = Quadrature(owner, element, position, volume, points.material[owner])
    # Points are sorted by triangle, for fast sums over points; their order does not depend on the
    # order of earlier changes.
    order = np.argsort(np.concatenate([quadrature.element, element]), kind="stable")
    order = order[np.concatenate([~dropped, np.ones(len(clipped), bool)])[order]]
    return Quadrature(
        *(
            np.concatenate([getattr(quadrature, f.name), getattr(clipped, f.name)])[order]
            for f in fields(Quadrature)
        )
    )


def split_points(
    points: MaterialPoints,
    domains: ParticleDomains,
    quadrature: Quadrature,
    grid: Grid,
    a: Floats,
    b: Floats,
) -> tuple[MaterialPoints, ParticleDomains, Quadrature]:
    """Split each material point whose domain is cut by a new crack segment in two.

    Parameters
    ----------
    points : MaterialPoints
    domains : ParticleDomains
    quadrature : Quadrature
    grid : Grid
        The grid of `quadrature`.
    a, b : (2,) float
        The ends of the segment [mm]. A domain that contains an end is cut along the whole line, so
        that every domain stays convex.

    Returns
    -------
    points : MaterialPoints
        The part on the left of a -> b keeps its number, that on the right is appended, in the order
        of the parents. Both have material and `element` of the parent, lie at the centroids of
        their parts, and divide its volume in proportion to area.
    domains : ParticleDomains
    quadrature : Quadrature
        Renewed in the triangles that intersect the parents' domains.
    """
    cut = np.flatnonzero(
        clipping.find_cut_domains(domains.anchors, domains.vertices, domains.offsets, a, b)
    )
    if cut.size == 0:
        return points, domains, quadrature
    n = len(points)
    newcomers = np.arange(n, n + len(cut))
    columns = {f.name: getattr(points, f.name) for f in fields(points)}
    split = MaterialPoints(**{name: np.concatenate([x, x[cut]]) for name, x in columns.items()})
    lefts: list[Floats] = []
    rights: list[Floats] = []
    for p, newcomer in zip(cut, newcomers, strict=True):
        own = domains.vertices[domains.offsets[p] : domains.offsets[p + 1]]
        start, end = a - domains.anchors[p], b - domains.anchors[p]
        areas = []
        for part, side, parts in ((p, 1.0, lefts), (newcomer, -1.0, rights)):
            work = np.empty((2 * len(own), 2))
            k = clipping.clip(own, len(own), start, end, side, work)
            area, *centroid = clipping.area_and_centroid(work, k)
            split.position[part] = domains.anchors[p] + centroid
            areas.append(area)
            parts.append(work[:k])
        split.volume[[p, newcomer]] = points.volume[p] * np.array(areas) / sum(areas)
    divided = _replace_and_append(domains, cut, lefts, rights)
    touched = quadrature.element[np.isin(quadrature.owner, cut)]
    return split, divided, _clip_again(quadrature, divided, split, grid, touched, newcomers)


def _replace_and_append(
    domains: ParticleDomains, cut: Ints, lefts: list[Floats], rights: list[Floats]
) -> ParticleDomains:
    """Replace the domains that were cut by their left parts, and append the right parts."""
    blocks, start = [], 0
    for p, left in zip(cut, lefts, strict=True):
        blocks += [domains.vertices[start : domains.offsets[p]], left]
        start = domains.offsets[p + 1]
    counts = np.diff(domains.offsets)
    counts[cut] = [len(left) for left in lefts]
    counts = np.concatenate([counts, [len(right) for right in rights]])
    return ParticleDomains(
        anchors=np.concatenate([domains.anchors, domains.anchors[cut]]),
        vertices=np.concatenate([*blocks, domains.vertices[start:], *rights]),
        offsets=np.concatenate([[0], np.cumsum(counts)]),
    )


def means(
    points: MaterialPoints, quadrature: Quadrature | None, deformed: DeformedPoints
) -> DeformedPoints:
    """Give the material points the mean state of their quadrature points.

    Parameters
    ----------
    points : MaterialPoints
    quadrature : Quadrature or None
        None if the material points are the quadrature points.
    deformed : DeformedPoints
        The quadrature points.

    Returns
    -------
    DeformedPoints
        Means over the quadrature points of each point, weighted with their volumes; zero for a
        point whose domain has no area. Without `quadrature` the arrays are those of `deformed`.
    """
    state = [getattr(deformed, f.name) for f in fields(deformed)[len(fields(points)) :]]
    if quadrature is not None:
        state = [_mean_over_pieces(quadrature, values, len(points)) for values in state]
    return points.deformed(*state)


def _mean_over_pieces(quadrature: Quadrature, values: Floats, n_points: int) -> Floats:
    owner, volume = quadrature.owner, quadrature.volume
    total = np.maximum(np.bincount(owner, volume, n_points), np.finfo(float).tiny)
    mean = np.zeros((n_points, *values.shape[1:]))
    columns = mean.reshape(n_points, -1)
    for i, column in enumerate(values.reshape(len(values), -1).T):
        columns[:, i] = np.bincount(owner, volume * column, n_points) / total
    return mean
