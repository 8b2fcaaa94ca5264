"""Rules for loads: their places exist, and they do not contradict each other.

Functions yield findings: the dotted key in the expanded scene, and the reason.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping

from shapely import LineString, Point, box

from cfmpm.errors import did_you_mean
from cfmpm.registry.loads import LOADS
from cfmpm.scene.geometry import CLEAR, ON, BodyShape
from cfmpm.scene.loads import Load
from cfmpm.scene.model import Scene
from cfmpm.scene.rules_body import Finding, at
from cfmpm.scene.shapes import XY

# Largest length of cracks in the box of a traction, as a fraction of the length of the boundary in
# it: a box a little larger than a side may contain the mouth of a crack. A support may contain any
# length: it holds the boundary.
MOST_CRACK = 0.1


def unknown_edges(scene: Scene) -> Iterator[Finding]:
    """Find loads on edges that do not exist in the geometry."""
    assert scene.geometry is not None
    names = [v.edge for v in scene.geometry.outline] + [h.name for h in scene.geometry.holes]
    known = list(dict.fromkeys(str(name) for name in names))
    for i, load in enumerate(scene.loads):
        if load.edge is not None and load.edge not in known:
            yield f"loads[{i}].edge", f"unknown edge {load.edge}" + did_you_mean(load.edge, known)


def contradictions(scene: Scene) -> Iterator[Finding]:
    """Find different displacements prescribed for one component at one place."""
    first: dict[tuple[Hashable, str], tuple[int, float]] = {}
    for i, load in enumerate(scene.loads):
        if load.displacement is None:
            continue
        for component in ("x", "y"):
            value = getattr(load.displacement, component)
            if value is None:
                continue
            before, prescribed = first.setdefault((_place(load), component), (i, value))
            if value != prescribed:
                yield (
                    f"loads[{i}].displacement.{component}",
                    f"{value:g} contradicts loads[{before}], which prescribes {prescribed:g} there",
                )


def swallowed_loads(scene: Scene) -> Iterator[Finding]:
    """Find tractions and forces in a component whose displacement is prescribed at the same place.

    The support carries such a load directly, so that it has no effect on the body: an error in the
    scene. Places that overlap in part are found on the grid later, and give a warning.
    """
    held = {
        (_place(load), component): i
        for i, load in reversed([*enumerate(scene.loads)])
        for component in ("x", "y")
        if load.displacement is not None and getattr(load.displacement, component) is not None
    }
    for i, load in enumerate(scene.loads):
        kind = LOADS[load.kind]
        if kind.holds or not kind.places or not isinstance(load.value, tuple):
            continue
        for component, value in zip("xy", load.value, strict=True):
            support = held.get((_place(load), component))
            if value != 0.0 and support is not None:
                yield (
                    f"loads[{i}].{load.kind}",
                    f"{value:g} in {component} has no effect: loads[{support}] prescribes the "
                    f"displacement in {component} there and carries it; remove one of them",
                )


def misplaced_loads(scene: Scene, body: BodyShape) -> Iterator[Finding]:
    """Find boxes without boundary, and points outside the body, near its boundary or on a crack."""
    for i, load in enumerate(scene.loads):
        if load.box is not None:
            yield from _box(f"loads[{i}].box", load, body)
        if load.point is not None:
            yield from _point(f"loads[{i}].point", load.point, body)


def _place(load: Load) -> Hashable:
    if load.box is not None:
        (x0, y0), (x1, y1) = load.box
        return "box", min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1)
    return load.edge or load.point


def _box(key: str, load: Load, body: BodyShape) -> Iterator[Finding]:
    assert load.box is not None
    (x0, y0), (x1, y1) = load.box
    if min(abs(x1 - x0), abs(y1 - y0)) <= ON * body.size:
        yield key, "has zero width or height: give two opposite corners"
        return
    area = box(min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1))
    held = body.polygon.boundary.intersection(area).length
    cracks = cracks_in_box(load.box, body.cracks)
    length = sum(cracks.values())
    inside = f"{length:.4g} mm of {' and '.join(cracks)}"
    if held <= ON * body.size:
        only = f", only {inside}, whose faces a load cannot act on" if length > 0.0 else ""
        yield key, f"contains no part of the boundary{only}"
    elif length > MOST_CRACK * held and not LOADS[load.kind].holds:
        yield (
            key,
            f"contains {inside} and {held:.4g} mm of the boundary: a {load.kind} cannot act on "
            "crack faces; end the box at the boundary, or use an edge",
        )


def cracks_in_box(
    corners: tuple[XY, XY], cracks: Mapping[str, LineString], least: float = 0.0
) -> dict[str, float]:
    """Return the length of each crack inside a box.

    Parameters
    ----------
    corners : ((float, float), (float, float))
        Opposite corners of the box [mm].
    cracks : mapping of str to LineString
        Cracks by name.
    least : float
        Cracks with at most this length inside the box are left out [mm].

    Returns
    -------
    dict of str to float
        Length inside the box by name [mm].
    """
    (x0, y0), (x1, y1) = corners
    area = box(min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1))
    lengths = {name: float(line.intersection(area).length) for name, line in cracks.items()}
    return {name: length for name, length in lengths.items() if length > least}


def _point(key: str, point: tuple[float, float], body: BodyShape) -> Iterator[Finding]:
    name, _, distance = body.nearest(point)
    clear = CLEAR * body.size
    for crack, line in body.cracks.items():
        if line.distance(Point(point)) <= clear:
            yield key, f"{at(point)} is on {crack}: a load on a crack needs a choice of its face"
            return
    if body.is_on_boundary(point):
        return
    if not body.polygon.covers(Point(point)):
        yield key, f"{at(point)} is outside the body, {distance:.2g} mm from {name}"
    elif distance <= clear:
        yield (
            key,
            f"{at(point)} is {distance:.2g} mm from {name}; it must be on it, or at least "
            f"{clear:.2g} mm away",
        )
