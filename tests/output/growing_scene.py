"""A small scene whose crack grows."""

from __future__ import annotations

from typing import Any


def growing(element: str = "T3", **growth: Any) -> dict[str, Any]:
    """An edge crack that grows under crack control, with other values of `growth`."""
    return {
        "name": "plate",
        "family": {
            "kind": "single_edge",
            "width": 10,
            "height": 20,
            "crack_length": 4,
            "traction": 10,
        },
        "material": {"E": 210e3, "nu": 0.3, "g_c": 1.0},
        "mesh": {"element": element, "size": 2},
        "growth": {"control": "crack", "increments": 4, **growth},
    }
