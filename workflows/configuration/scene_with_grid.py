"""Scenes of the workflow with another grid."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cfmpm.scene import Scene, load_scene
from cfmpm.scene.mesh import Mesh


def scene_with(
    path: str | Path, mesh: Mesh | Mapping[str, Any], radii: list[float] | None = None, **more: Any
) -> Scene:
    """Read a scene with another grid, other radii [mm] and further values replaced."""
    if isinstance(mesh, Mesh):
        mesh = mesh.model_dump(mode="json", exclude_none=True)
    overrides = {"mesh": dict(mesh), **more}
    if radii is not None:
        overrides["fracture.radii"] = list(radii)
    return load_scene(path, overrides)
