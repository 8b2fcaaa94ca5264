"""Scenes: the validated description of what is to be solved."""

from cfmpm.scene.families import expand
from cfmpm.scene.geometry import body_polygon, snap, tip_points
from cfmpm.scene.model import Scene

__all__ = ["Scene", "body_polygon", "expand", "snap", "tip_points"]
