"""Outlines of scenes."""

from __future__ import annotations

from typing import Any


def named_rectangle(width: float, height: float) -> list[dict[str, Any]]:
    """Corners from (0, 0) on, with edges bottom, right, top, left."""
    return [
        {"at": [0, 0], "edge": "bottom"},
        {"at": [width, 0], "edge": "right"},
        {"at": [width, height], "edge": "top"},
        {"at": [0, height], "edge": "left"},
    ]
