"""Scenes: the validated description of a problem to be solved.

Public names are imported on first use. The models of a scene include models that other packages
register. Such a package may import a module of `cfmpm.scene` before the models are made; imports
here at once would then be circular.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cfmpm.scene.document import parse_override
    from cfmpm.scene.families import expand
    from cfmpm.scene.geometry import body_polygon, snap, tip_points
    from cfmpm.scene.model import Scene
    from cfmpm.scene.reading import (
        changed_keys,
        config_hash,
        effective_config,
        load_scene,
        placed,
        scene_from_dict,
        scene_from_document,
    )

__all__ = [
    "Scene",
    "body_polygon",
    "changed_keys",
    "config_hash",
    "effective_config",
    "expand",
    "load_scene",
    "parse_override",
    "placed",
    "scene_from_dict",
    "scene_from_document",
    "snap",
    "tip_points",
]

_HOME = {
    "Scene": "cfmpm.scene.model",
    "parse_override": "cfmpm.scene.document",
    "expand": "cfmpm.scene.families",
    **dict.fromkeys(("body_polygon", "snap", "tip_points"), "cfmpm.scene.geometry"),
}


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'cfmpm.scene' has no attribute {name!r}")
    return getattr(import_module(_HOME.get(name, "cfmpm.scene.reading")), name)


def __dir__() -> list[str]:
    return __all__
