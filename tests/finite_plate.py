"""A plate with an edge crack at finite deformation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import cfmpm
from cfmpm.scene.reading import scene_from_dict
from cfmpm.state import Result

PLATE: dict[str, Any] = {
    "name": "plate",
    "family": {"kind": "single_edge", "width": 50, "height": 80, "crack_length": 12},
    "material": {"E": 1e4, "nu": 0.3, "law": "ciarlet"},
    "kinematics": "finite",
    "loads": [
        {"edge": "top", "displacement": {"y": 4}},
        {"edge": "bottom", "displacement": {"y": -4}},
    ],
    "mesh": {"element": "T3", "size": 8},
}


def run(base: Mapping[str, Any], **changes: Any) -> Result:
    """Run a scene with other values of some keys."""
    return cfmpm.run(scene_from_dict({**base, **changes}))
