"""The background grid: topology, boundaries, crack faces and tips, components."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cfmpm.elements.record import Element, find_element
from cfmpm.kernels import basis, topology

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Triangulation:
    """A plane triangulation in which cracks are closed lines of edges.

    Attributes
    ----------
    nodes : (n, 2) float
        Coordinates [mm]; every node belongs to a triangle.
    triangles : (m, 3) int
        Corner nodes, anticlockwise.
    regions : (m,) int
        Index into `region_names`.
    region_names : tuple of str
        ``"body"`` first, then the regions of the scene.
    edges : dict of str to (k, 2) int
        Node pairs of each named part of the boundary (outline and holes).
    cracks : dict of str to (k, 2) int
        Node pairs of each crack line, consecutive from its first point to its last.
    points : dict of str to int
        The node at each point load or point support, by the load's name.
    uncounted : dict of str to float
        Of a crack, the length from its first point on that its crack length leaves out [mm].
    """

    nodes: Floats
    triangles: Ints
    regions: Ints
    region_names: tuple[str, ...]
    edges: Mapping[str, Ints]
    cracks: Mapping[str, Ints]
    points: Mapping[str, int]
    uncounted: Mapping[str, float] = field(default_factory=dict)

    def end_of(self, crack: str, end: int) -> int:
        """Return the first (end 0) or the last (end -1) node of a crack."""
        pairs = self.cracks[crack]
        return int(pairs[0, 0] if end == 0 else pairs[-1, 1])

    @property
    def crack_lengths(self) -> dict[str, float]:
        """Length of each crack as it is counted [mm]."""
        return {
            name: line_length(self.nodes[line_of(pairs)]) - self.uncounted.get(name, 0.0)
            for name, pairs in self.cracks.items()
        }

    def edge_at(self, node: int) -> str | None:
        """Return the named part of the boundary of the body that a node lies on, if any."""
        return next((name for name, pairs in self.edges.items() if (pairs == node).any()), None)

    def is_inside(self, node: int) -> bool:
        """Whether triangles close a ring around a node.

        The names of edges do not tell: in a grid with a margin they lie inside it.
        """
        corners = self.triangles.ravel()
        place = np.flatnonzero(corners == node)
        after, before = (corners[place - place % 3 + (place + step) % 3] for step in (1, 2))
        return np.array_equal(np.sort(after), np.sort(before))

    def is_tip(self, crack: str, end: int) -> bool:
        """Whether an end of a crack lies inside the grid and on no other crack line."""
        node = self.end_of(crack, end)
        met = sum(np.count_nonzero(pairs == node) for pairs in self.cracks.values())
        return met == 1 and self.is_inside(node)


@dataclass(frozen=True)
class CrackTip:
    """One end of a crack inside the body.

    Attributes
    ----------
    name : str
        The crack's name; with ``_start`` or ``_end`` where both its ends are tips.
    crack : str
    end : {0, -1}
        Whether it is the first or the last node of the crack.
    node : int
    path : (k, 2) float
        Corners of the crack line from the tip backwards [mm].
    tangent : (2,) float
        Unit vector along the crack at the tip, pointing ahead.
    h : float
        Mean length of the grid edges at the tip [mm].
    """

    name: str
    crack: str
    end: int
    node: int
    path: Floats
    tangent: Floats
    h: float

    @property
    def crack_length(self) -> float:
        """Length of the crack line that ends here [mm]."""
        return line_length(self.path)


@dataclass(frozen=True)
class Grid:
    """A grid of triangles with doubled nodes along the cracks.

    Attributes
    ----------
    element : Element
        Element type of the triangles.
    nodes : (n, 2) float
        Coordinates [mm]; corners first, then the nodes on sides, then those inside triangles.
    elements : (m, k) int
        Corner nodes anticlockwise, then the others as in `Element.nodes`.
    twins : (m, 3) int
        The half-edge across each side, -1 on the boundary and on crack faces.
    regions : (m,) int
    region_names : tuple of str
    edges : dict of str to (k, p + 1) int
        Nodes of the boundary edges of each named part, as of `edge_nodes`.
    crack_faces : dict of str to (k, 2) int
        Half-edges on the left and on the right of each edge of a crack, first point to last.
    tips : tuple of CrackTip
    points : dict of str to int
        The node of each point load or point support.
    """

    element: Element
    nodes: Floats
    elements: Ints
    twins: Ints
    regions: Ints
    region_names: tuple[str, ...]
    edges: Mapping[str, Ints]
    crack_faces: Mapping[str, Ints]
    tips: tuple[CrackTip, ...]
    points: Mapping[str, int]

    @property
    def triangles(self) -> Ints:
        """Corner nodes, (m, 3)."""
        return self.elements[:, :3]

    @property
    def n_corners(self) -> int:
        """Number of corner nodes; the others are numbered from here."""
        return int(self.elements[:, :3].max()) + 1

    @property
    def areas(self) -> Floats:
        """Area of each triangle [mm^2], (m,)."""
        return signed_areas(self.nodes[self.elements[:, :3]])

    def edge_nodes(self, half_edges: Ints) -> Ints:
        """Nodes of half-edges, the ends and then those between, first to second; (k, p + 1)."""
        return _nodes_of(half_edges, self.elements, self.element)

    def basis_values(self, element: Ints, position: Floats) -> Floats:
        """Evaluate the basis functions at positions in triangles.

        Parameters
        ----------
        element : (q,) int
            The triangles.
        position : (q, 2) float
            [mm].

        Returns
        -------
        (q, k) float
        """
        table = self.element.nodes, self.element.factors
        values: Floats = basis.basis_values(*table, self.nodes, self.elements, element, position)
        return values

    @cached_property
    def extent(self) -> tuple[Floats, Floats]:
        """Lower left and upper right corner of the box around the nodes [mm], (2,) each."""
        # By columns: a reduction over the first of two axes takes ten times as long.
        x, y = np.ascontiguousarray(self.nodes.T)
        return np.array([x.min(), y.min()]), np.array([x.max(), y.max()])

    @property
    def diagonal(self) -> float:
        """Length of the diagonal of that box [mm]."""
        low, high = self.extent
        return float(np.hypot(*(high - low)))

    @cached_property
    def parts(self) -> Ints:
        """Number of the connected part of the body that each element belongs to, (m,)."""
        parts: Ints = topology.connected_parts(self.twins)
        return parts

    def basis_gradients(self, element: Ints, position: Floats) -> Floats:
        """Evaluate the gradients of the basis functions at positions in triangles.

        Parameters
        ----------
        element, position
            As in `basis_values`.

        Returns
        -------
        (q, k, 2) float
            dS_I/dX_j [1/mm].
        """
        table = self.element.nodes, self.element.factors
        return np.asarray(
            basis.basis_gradients(*table, self.nodes, self.elements, element, position)
        )


def build_grid(triangulation: Triangulation, element: Element | str) -> Grid:
    """Double the nodes along the cracks of a triangulation, and number the nodes of its elements.

    Parameters
    ----------
    triangulation : Triangulation
    element : Element or str
        The element, or its word in `registry.elements`.

    Returns
    -------
    Grid
        A crack node is doubled where the triangles around it form several fans (paper section 4.1);
        the end of a crack inside the body remains one node, the tip.
    """
    n_nodes = len(triangulation.nodes)
    triangles = triangulation.triangles.copy()
    offsets, half_edges = topology.node_stars(triangles, n_nodes)
    twins = topology.find_twins(triangles, offsets, half_edges)

    def sides(pairs: Ints) -> tuple[Ints, Ints]:
        """Half-edges on the left and on the right of node pairs, -1 where there is none."""
        star = (triangulation.triangles, offsets, half_edges)
        return (
            topology.find_half_edges(*star, pairs),
            topology.find_half_edges(*star, np.ascontiguousarray(pairs[:, ::-1])),
        )

    named = {name: np.maximum(*sides(pairs)) for name, pairs in triangulation.edges.items()}
    crack_faces = {
        name: np.column_stack(sides(pairs)) for name, pairs in triangulation.cracks.items()
    }
    tips = tuple(
        tip
        for name, pairs in triangulation.cracks.items()
        for tip in _tips(name, pairs, triangulation, offsets, half_edges)
    )

    nodes = triangulation.nodes
    if crack_faces:
        faces = np.concatenate([f.ravel() for f in crack_faces.values()])
        twins.reshape(-1)[faces] = -1
        on_cracks = np.unique(np.concatenate([p.ravel() for p in triangulation.cracks.values()]))
        parents = topology.split_nodes(triangles, twins, offsets, half_edges, on_cracks, n_nodes)
        nodes = np.concatenate([nodes, nodes[parents]])

    of = find_element(element) if isinstance(element, str) else element
    nodes, elements = _with_further_nodes(of, nodes, triangles, twins)
    return Grid(
        element=of,
        nodes=nodes,
        elements=elements,
        twins=twins,
        regions=triangulation.regions,
        region_names=triangulation.region_names,
        edges={name: _nodes_of(found, elements, of) for name, found in named.items()},
        crack_faces=crack_faces,
        tips=tips,
        points=triangulation.points,
    )


def _nodes_of(half_edges: Ints, elements: Ints, element: Element) -> Ints:
    return elements[(half_edges // 3)[:, None], element.sides[half_edges % 3]]


def _with_further_nodes(
    element: Element, corners: Floats, triangles: Ints, twins: Ints
) -> tuple[Floats, Ints]:
    """Add the nodes on sides and inside triangles; each crack face gets its own nodes."""
    p = element.order
    if p == 1:
        return corners, triangles
    own = np.arange(twins.size)
    twin = twins.reshape(-1)
    first = np.where(twin >= 0, np.minimum(own, twin), own)
    is_first = first == own
    number = np.cumsum(is_first) - 1
    on_sides = len(corners) + (p - 1) * number[first][:, None] + np.arange(p - 1)
    if p > 2:
        # The triangle across a side has the nodes on it in reverse order.
        on_sides[~is_first] = on_sides[~is_first, ::-1]
    start = corners[triangles].reshape(-1, 2)[is_first]
    end = corners[np.roll(triangles, -1, axis=1)].reshape(-1, 2)[is_first]
    along = [((p - j) * start + j * end) / p for j in range(1, p)]
    within = element.nodes[3 * p :]
    places = np.einsum("kc,ecd->ekd", within, corners[triangles]) / p
    inside = np.arange(len(triangles) * len(within)).reshape(len(triangles), -1)
    inside += len(corners) + len(start) * (p - 1)
    nodes = [corners, np.stack(along, axis=1).reshape(-1, 2), places.reshape(-1, 2)]
    return np.concatenate(nodes), np.hstack(
        [triangles, on_sides.reshape(len(triangles), -1), inside]
    )


def _tips(
    name: str,
    pairs: Ints,
    triangulation: Triangulation,
    offsets: Ints,
    half_edges: Ints,
) -> list[CrackTip]:
    """Find the ends of one crack that lie inside the body and on no crack."""
    nodes, triangles = triangulation.nodes, triangulation.triangles
    line = line_of(pairs)
    ends = {0: line[::-1], -1: line}
    inside = {end: path for end, path in ends.items() if triangulation.is_tip(name, end)}
    tips = []
    for end, path in inside.items():
        tip = path[-1]
        back = nodes[path[::-1]] - nodes[tip]
        tangent = -back[1] / np.hypot(*back[1])
        star = half_edges[offsets[tip] : offsets[tip + 1]]
        rim = nodes[triangles[star // 3, (star + 1) % 3]]
        tips.append(
            CrackTip(
                name=f"{name}_{'end' if end else 'start'}" if len(inside) == 2 else name,
                crack=name,
                end=end,
                node=int(tip),
                path=nodes[path[::-1]],
                tangent=tangent,
                h=float(np.hypot(*(rim - nodes[tip]).T).mean()),
            )
        )
    return tips


def line_of(pairs: Ints) -> Ints:
    """Return the nodes along a line of consecutive node pairs, (k + 1,)."""
    return np.concatenate([pairs[:, 0], pairs[-1:, 1]])


def line_length(points: Floats) -> float:
    """Return the length of the line through points (k, 2) [mm]."""
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def lengths_of(nodes: Floats, pairs: Ints) -> Floats:
    """Return the length of the line between the first two nodes of each row, (k,) [mm]."""
    lengths: Floats = np.hypot(*(nodes[pairs[:, 1]] - nodes[pairs[:, 0]]).T)
    return lengths


def signed_areas(corners: Floats) -> Floats:
    """Return the areas of triangles, negative where the corners are in clockwise order.

    Parameters
    ----------
    corners : (k, 3, 2) float
        [mm].

    Returns
    -------
    (k,) float
        [mm^2].
    """
    (ux, uy), (vx, vy) = ((corners[:, k] - corners[:, 0]).T for k in (1, 2))
    areas: Floats = 0.5 * (ux * vy - uy * vx)
    return areas


def regions_ahead(grid: Grid, tip: CrackTip, direction: Floats) -> list[int]:
    """Return the regions of the triangles at a tip that a direction enters.

    Parameters
    ----------
    grid : Grid
    tip : CrackTip
    direction : (2,) float
        Unit vector.

    Returns
    -------
    list of int
        One region, or two if the direction is along their interface.
    """
    if len(grid.region_names) == 1:
        return [0]
    element, corner = np.nonzero(grid.triangles == tip.node)
    inside = np.full(len(element), np.inf)
    for step, sign in ((1, 1.0), (2, -1.0)):
        side = grid.nodes[grid.triangles[element, (corner + step) % 3]] - grid.nodes[tip.node]
        cross = side[:, 0] * direction[1] - side[:, 1] * direction[0]
        inside = np.minimum(inside, sign * cross / np.hypot(*side.T))
    # Outside by no more than round-off; the sector behind the tip passes too where it is wide.
    entered = element[inside >= min(float(inside.max()), -1e-9)]
    return np.unique(grid.regions[entered]).tolist()
