"""A strip in tension whose edge cracks grow by fatigue."""

from __future__ import annotations

from typing import Any

from outlines import named_rectangle

C, M = 1e-12, 3.0
WIDTH, HEIGHT, TENSION, G_C, E, NU = 50.0, 300.0, 100.0, 20.0, 210e3, 0.3


def strip(cracks, m=M, size=0.5, **changes) -> dict[str, Any]:
    return {
        "name": "strip",
        "geometry": {
            "outline": named_rectangle(WIDTH, HEIGHT),
            "cracks": [
                {"name": name, "points": [[0, y], [a, y]]} for name, (y, a) in cracks.items()
            ],
        },
        "material": {"E": E, "nu": NU, "g_c": G_C},
        "loads": [
            {"edge": "bottom", "traction": [0, -TENSION]},
            {"edge": "top", "traction": [0, TENSION]},
        ],
        "mesh": {"element": "T6", "size": 10, "grading": {"tip_size": size, "growth": 0.3}},
        "fracture": {"refine": size},
        "growth": {"control": "fatigue"},
        "fatigue": {"C": C, "m": m},
    } | changes
