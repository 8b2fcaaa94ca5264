"""Families of specimens as geometry and loads, and default names for everything."""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Iterable, Sequence
from functools import singledispatch
from typing import TypeVar

from cfmpm.scene.body import Circle, Crack, Geometry, Hole, Vertex
from cfmpm.scene.components import Components
from cfmpm.scene.loads import Load
from cfmpm.scene.model import Scene
from cfmpm.scene.specimens import (
    CentreCrack,
    CompactTension,
    PlateWithHoles,
    SingleEdge,
    Specimen,
    ThreePointBend,
)

Named = TypeVar("Named", Vertex, Hole, Crack, Load)


def expand(scene: Scene) -> Scene:
    """Write a family as geometry and loads, and name all that has no name.

    Parameters
    ----------
    scene
        Any valid scene. Lengths in mm, tractions in MPa, forces in N/mm.

    Returns
    -------
    Scene
        The same scene with `geometry` (or `mesh_file`) and `loads`, without `family`; every edge,
        hole, crack and load has a name. Expanding it again changes nothing.
    """
    geometry, loads = scene.geometry, scene.loads
    if scene.family is not None:
        geometry, family_loads = _specimen(scene.family)
        loads = loads or family_loads
    if geometry is not None:
        geometry = _named(geometry)
    load_names = _fill(
        [load.name for load in loads],
        [load.edge or f"load_{i}" for i, load in enumerate(loads, 1)],
    )
    loads = [_renamed(load, "name", name) for load, name in zip(loads, load_names, strict=True)]
    return scene.model_copy(update={"geometry": geometry, "family": None, "loads": loads})


def key_as_written(scene: Scene, key: str) -> str:
    """Turn a key of the expanded scene into the key the user has written.

    Parameters
    ----------
    scene
        The scene before its expansion.
    key
        Such as ``geometry.cracks[0].points``.
    """
    if scene.family is None:
        return key
    if not scene.loads and key.startswith("loads"):
        return f"family.{scene.family.load_key}"
    part = re.match(r"geometry\.(holes|cracks)\[\d+\]", key)
    if part and part[1] in type(scene.family).model_fields:
        return key.replace("geometry.", "family.", 1)
    if key.startswith("geometry.cracks"):
        return "family.crack_length"
    return re.sub(r"^geometry.*", "family", key)


@singledispatch
def _specimen(family: Specimen) -> tuple[Geometry, list[Load]]:
    raise TypeError(f"no geometry for the family {type(family).__name__}")


@_specimen.register
def _single_edge(family: SingleEdge) -> tuple[Geometry, list[Load]]:
    y = family.height / 2 if family.crack_height is None else family.crack_height
    crack = Crack(points=[(0, y), (family.crack_length, y)])
    geometry = Geometry(outline=_rectangle(family.width, family.height), cracks=[crack])
    return geometry, _tension(family.traction)


@_specimen.register
def _centre_crack(family: CentreCrack) -> tuple[Geometry, list[Load]]:
    centre = complex(family.width, family.height) / 2
    arm = cmath.rect(family.crack_length / 2, math.radians(family.crack_angle))
    if abs(family.crack_angle) == 90:
        arm = complex(0, arm.imag)  # the cosine of 90 degrees is not quite zero
    ends = [(z.real, z.imag) for z in (centre - arm, centre + arm)]
    geometry = Geometry(
        outline=_rectangle(family.width, family.height), cracks=[Crack(points=ends)]
    )
    return geometry, _tension(family.traction)


@_specimen.register
def _compact_tension(family: CompactTension) -> tuple[Geometry, list[Load]]:
    width = family.width
    load_line, middle, diameter = 0.25 * width, 0.6 * width, 0.25 * width
    pins = {"pin_top": 1, "pin_bottom": -1}
    geometry = Geometry(
        outline=_rectangle(1.25 * width, 2 * middle),
        holes=[
            Hole(
                name=name,
                circle=Circle(
                    centre=(load_line, middle + side * 0.275 * width), radius=diameter / 2
                ),
            )
            for name, side in pins.items()
        ],
        cracks=[Crack(points=[(0, middle), (load_line + family.crack_length, middle)])],
    )
    if family.force is None:
        return geometry, []
    # Spread evenly over the circumference: the resultant is the force, the moment zero.
    pull = family.force / (math.pi * diameter)
    return geometry, [Load(edge=name, traction=(0, side * pull)) for name, side in pins.items()]


@_specimen.register
def _three_point_bend(family: ThreePointBend) -> tuple[Geometry, list[Load]]:
    middle = family.length / 2
    x = middle + family.crack_offset
    geometry = Geometry(
        outline=_rectangle(family.length, family.height),
        holes=[Hole(circle=circle) for circle in family.holes],
        cracks=[Crack(points=[(x, 0), (x, family.crack_length)])],
    )
    if family.force is None:
        return geometry, []
    left, right = (middle - family.span / 2, 0), (middle + family.span / 2, 0)
    return geometry, [
        Load(name="support_left", point=left, displacement=Components(x=0, y=0)),
        Load(name="support_right", point=right, displacement=Components(y=0)),
        Load(name="force", point=(middle, family.height), force=(0, -family.force)),
    ]


@_specimen.register
def _plate_with_holes(family: PlateWithHoles) -> tuple[Geometry, list[Load]]:
    geometry = Geometry(
        outline=_rectangle(family.width, family.height),
        holes=[Hole(circle=circle) for circle in family.holes],
        cracks=family.cracks,
    )
    return geometry, _tension(family.traction)


def _rectangle(width: float, height: float) -> list[Vertex]:
    corners = {"bottom": (0, 0), "right": (width, 0), "top": (width, height), "left": (0, height)}
    return [Vertex(at=at, edge=edge) for edge, at in corners.items()]


def _tension(traction: float | None) -> list[Load]:
    if traction is None:
        return []
    return [
        Load(edge="top", traction=(0, traction)),
        Load(edge="bottom", traction=(0, -traction)),
    ]


def _named(geometry: Geometry) -> Geometry:
    outline, holes, cracks = geometry.outline, geometry.holes, geometry.cracks
    # Edges and holes are named alike in loads, so they share one set of names.
    edges = _fill(
        [corner.edge for corner in outline] + [hole.name for hole in holes],
        [*_numbered("edge", outline), *_numbered("hole", holes)],
    )
    crack_names = _fill([crack.name for crack in cracks], _numbered("crack", cracks))
    return geometry.model_copy(
        update={
            "outline": [_renamed(c, "edge", n) for c, n in zip(outline, edges, strict=False)],
            "holes": [
                _renamed(h, "name", n) for h, n in zip(holes, edges[len(outline) :], strict=True)
            ],
            "cracks": [_renamed(c, "name", n) for c, n in zip(cracks, crack_names, strict=True)],
        }
    )


def _numbered(word: str, things: Sequence[object]) -> list[str]:
    return [f"{word}_{i}" for i in range(1, len(things) + 1)]


def _fill(names: Sequence[str | None], defaults: Iterable[str]) -> list[str]:
    """Put a default for every None; a default that is taken gets a number."""
    taken = {name for name in names if name is not None}
    filled = []
    for name, default in zip(names, defaults, strict=True):
        new, i = name or default, 2
        while name is None and new in taken:
            new, i = f"{default[:58]}_{i}", i + 1
        taken.add(new)
        filled.append(new)
    return filled


def _renamed(thing: Named, key: str, name: str) -> Named:
    return thing.model_copy(update={key: name})
