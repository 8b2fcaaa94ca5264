"""A box that contains a part of a crack gives a warning; ending it at the boundary helps."""

from __future__ import annotations

import json
from typing import Any

import cfmpm
from cfmpm.scene import scene_from_dict


def warnings(**place: Any) -> list[str]:
    """Warnings for a plate with a traction on a given place."""
    scene: dict[str, Any] = {
        "name": "plate",
        "geometry": {
            "outline": [[0, 0], [20, 0], [20, 40], [0, 40]],
            "cracks": [{"points": [[0, 20], [5, 20]]}],
        },
        "material": {"E": 210e3, "nu": 0.3},
        "loads": [
            {"edge": "edge_2", "displacement": {"x": 0, "y": 0}},
            {"name": "pull", "traction": [0, 1], **place},
        ],
        "mesh": {"element": "T3", "size": 2},
    }
    found: list[str] = json.loads(cfmpm.run(scene_from_dict(scene)).history.attrs["warnings"])
    return found


def test_crack_in_the_box_of_a_load() -> None:
    (text,) = (text for text in warnings(box=[[-1, 10], [0.5, 30]]) if "box" in text)
    assert text == (
        "pull: its box contains 0.5 mm of crack_1; the traction acts on the boundary in the box, "
        "not on crack faces: end the box at the boundary, or name an edge"
    )
    for place in ({"box": [[-1, 10], [0.01, 30]]}, {"edge": "edge_4"}):
        assert not [text for text in warnings(**place) if "box" in text]
