"""Beams in bending with cracks that close in part."""

from __future__ import annotations

from outlines import named_rectangle

MATERIAL = {"E": 70e3, "nu": 0.33}
BEAMS = {
    "straight": [[[50, 4], [50, 16]]],
    "edge": [[[40, 0], [42, 13]]],
    "kinked": [[[50, 4], [54, 9], [49, 16]]],
    "two": [[[30, 4], [33, 16]], [[60, 0], [57, 12]]],
}


def bent_beam(element, cracks):
    """Clamped on the left, loaded downwards on the right: open above, closed below."""
    return {
        "geometry": {
            "outline": named_rectangle(100, 20),
            "cracks": [{"points": points} for points in cracks],
        },
        "loads": [
            {"edge": "left", "displacement": {"x": 0, "y": 0}},
            {"edge": "right", "traction": [0, -1.0]},
        ],
        "mesh": {"element": element, "size": 2.5, "grading": {"tip_size": 0.2, "growth": 0.2}},
    }
