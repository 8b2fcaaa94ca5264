"""Expansion of a scene: specimens become geometry and loads, and every part gets a name."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import TypeVar

from cfmpm.scene.body import Crack, Geometry, Hole, Vertex
from cfmpm.scene.loads import Load
from cfmpm.scene.model import Scene

Named = TypeVar("Named", Vertex, Hole, Crack, Load)


def expand(scene: Scene) -> Scene:
    """Replace a family by its geometry and loads, and give default names to unnamed parts.

    Parameters
    ----------
    scene : Scene
        Any valid scene. Lengths in mm, tractions in MPa, forces in N/mm.

    Returns
    -------
    Scene
        An equivalent scene with `geometry` (or `mesh_file`) and `loads`, without `family`; every
        edge, hole, crack and load has a name. Expanding it again does not change it.
    """
    geometry, loads = scene.geometry, scene.loads
    if scene.family is not None:
        geometry, loads = scene.family.geometry(), loads or scene.family.loads()
    if geometry is not None:
        geometry = _named(geometry)
    load_names = _fill(
        [load.name for load in loads],
        [load.edge or f"load_{i}" for i, load in enumerate(loads, 1)],
    )
    loads = [_renamed(load, "name", name) for load, name in zip(loads, load_names, strict=True)]
    return scene.model_copy(update={"geometry": geometry, "family": None, "loads": loads})


def key_as_written(scene: Scene, key: str) -> str:
    """Convert a key of the expanded scene to a key of the scene file.

    Parameters
    ----------
    scene : Scene
        The scene before its expansion.
    key : str
        A dotted key of the expanded scene, such as ``geometry.cracks[0].points``.

    Returns
    -------
    str
        The key that the user wrote, such as ``family.crack_length``.
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


def _named(geometry: Geometry) -> Geometry:
    outline, holes, cracks = geometry.outline, geometry.holes, geometry.cracks
    # A load names an edge or a hole by the same key, so both share one set of names.
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
    """Replace each None by its default; a default already in use gets a number."""
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
