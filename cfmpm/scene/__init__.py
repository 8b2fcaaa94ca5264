"""Scenes: the validated description of what is to be solved."""

from cfmpm.scene.model import Scene

__all__ = ["Scene"]
