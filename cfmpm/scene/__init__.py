"""Scenes: the validated description of what is to be solved."""

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
