"""Crack growth by configurational force in the material point method.

``load_scene(path)`` reads a scene, ``run(scene)`` solves it, ``open_history(path)`` reads what a
run has written. They are imported on first use, so that ``import cfmpm`` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from cfmpm._version import __version__

if TYPE_CHECKING:
    from cfmpm.accessor import open_history
    from cfmpm.api import Result, run
    from cfmpm.errors import MeshError, SceneError, SolveError
    from cfmpm.scene import Scene, load_scene, scene_from_dict

__all__ = [
    "MeshError",
    "Result",
    "Scene",
    "SceneError",
    "SolveError",
    "__version__",
    "load_scene",
    "open_history",
    "run",
    "scene_from_dict",
]

_HOME = {
    "open_history": "cfmpm.accessor",
    "Scene": "cfmpm.scene",
    "load_scene": "cfmpm.scene",
    "scene_from_dict": "cfmpm.scene",
    "MeshError": "cfmpm.errors",
    "SceneError": "cfmpm.errors",
    "SolveError": "cfmpm.errors",
    "Result": "cfmpm.api",
    "run": "cfmpm.api",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'cfmpm' has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return __all__
