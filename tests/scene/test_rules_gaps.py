"""Narrow gaps between lines: refused with one message, or meshed with a bounded grid."""

from __future__ import annotations

import math
from typing import Any

import pytest

from cfmpm.scene.model import Scene
from cfmpm.scene.rules import broken_rules

SQUARE = [[0, 0], [10, 0], [10, 10], [0, 10]]
STEEL = {"E": 210e3, "nu": 0.3}
EDGE_CRACK = {"points": [[0, 5], [3, 5]]}


def scene(outline: Any = SQUARE, **geometry: Any) -> Scene:
    return Scene(
        name="gaps",
        geometry={"outline": outline, **geometry},
        material=STEEL,
        loads=[{"body_force": (0, 1)}],
    )


def spike(width: float, to: float = 15.0) -> list[list[float]]:
    """A square whose right side has a wedge of material, or a notch, with this half width."""
    wedge = [[10, 5 + width], [to, 5], [10, 5 - width]]
    return [[0, 10], [10, 10], *wedge, [10, 0], [0, 0]]


def region(*polygon: Any, name: str = "r") -> dict[str, Any]:
    return {"name": name, "material": STEEL, "polygon": list(polygon)}


def upper(y: float, right: float | None = None) -> dict[str, Any]:
    """The region above a horizontal line."""
    return region([0, y], [10, y if right is None else right], [10, 10], [0, 10])


def circle(radius: float) -> dict[str, Any]:
    return {"circle": {"centre": [5, 5], "radius": radius}}


def hairpin(gap: float) -> list[dict[str, Any]]:
    return [{"points": [[2, 5], [8, 5], [8, 5 + gap], [2, 5 + gap]]}]


FOLDED, APART = "folds back onto itself: the angle", "the smallest gap allowed is 0.001 mm"
COINCIDE = "must coincide or be at least 0.001 mm apart"
REFUSED: dict[str, tuple[dict[str, Any], str, str]] = {
    "spike": ({"outline": spike(1e-9)}, "outline", FOLDED),
    "wider spike": ({"outline": spike(1e-4)}, "outline", "sides 3 and 4 is below 0.6 deg"),
    "turned spike": ({"outline": spike(1e-6)[::-1]}, "outline", FOLDED),
    "short spike": (
        {"outline": spike(1e-9, 10.01)},
        "outline",
        f"near (10, 5); {APART}",
    ),
    "closed notch": ({"outline": spike(1e-9, 5)}, "outline", APART),
    "spike of a hole": (
        {"holes": [{"polygon": [[5, 7], [5, 5 + 1e-8], [8, 5], [5, 5 - 1e-8], [5, 3], [3, 5]]}]},
        "holes[0].polygon",
        "sides 1 and 4 are 2e-08 mm apart near (5, 5)",
    ),
    "spike of a region": (
        {"regions": [region([3, 3], [5, 3], [5, 5 - 1e-6], [8, 5], [5, 5 + 1e-6], [5, 7], [3, 7])]},
        "regions[0].polygon",
        FOLDED,
    ),
    "crack beside itself": ({"cracks": hairpin(1e-4)}, "cracks[0].points", "are 0.0001 mm apart"),
    "nearer": ({"cracks": hairpin(2e-5)}, "cracks[0].points", "sides 1 and 3 are 2e-05 mm apart"),
    "crack that turns back": (
        {"cracks": [{"points": [[2, 5], [8, 5], [2, 5.001]]}]},
        "cracks[0].points",
        FOLDED,
    ),
    "border beside a crack": (
        {"regions": [upper(5 - 1e-5)], "cracks": [EDGE_CRACK]},
        "regions[0]",
        f"r and crack_1 are 1e-05 mm apart near (0.0049975, 4.99999): they {COINCIDE}",
    ),
    "nearer border": (
        {"regions": [upper(5 - 2e-6)], "cracks": [EDGE_CRACK]},
        "regions[0]",
        "r and crack_1 are 2e-06 mm apart",
    ),
    "border beside the outline": (
        {"regions": [region([1e-4, 1e-4], [9, 1e-4], [9, 2], [1e-4, 2])]},
        "regions[0]",
        "r and the outline are 0.0001 mm apart",
    ),
    "border around a hole": (
        {
            "holes": [circle(2)],
            "regions": [
                region(
                    {"at": [7, 5], "through": [5, 7.0005]}, [3, 5], [2, 5], [2, 9], [8, 9], [8, 5]
                )
            ],
        },
        "regions[0]",
        "r and hole_1 are",
    ),
    "two borders": (
        {
            "regions": [
                region([2, 2], [4, 2], [4, 4], [2, 4]),
                region([4.0001, 2], [6, 2], [6, 4], [4.0001, 4], name="s"),
            ]
        },
        "regions[1]",
        f"s and region r are 0.0001 mm apart near (4.0001, 2): they {COINCIDE}",
    ),
    "a border that misses a corner of a hole": (
        {
            "holes": [{"polygon": [[4, 5], [6, 5], [6, 6], [4, 6]]}],
            "regions": [upper(5 + 1e-5, 5)],
        },
        "regions[0]",
        "r and hole_1 are 6e-06 mm apart near (4, 5)",
    ),
    "a tip beside a border": (
        {"regions": [upper(5.0005)], "cracks": [{"points": [[5, 2], [5, 5]]}]},
        "regions[0]",
        "r and crack_1 are 0.0005 mm apart near (5, 5.00025)",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused(name: str) -> None:
    parts, key, words = REFUSED[name]
    ((found, reason),) = broken_rules(scene(**parts))
    assert found == f"geometry.{key}"
    assert words in reason


SPIRAL = [
    [5 + (0.5 + 0.002 * i) * math.cos(0.1 * i), 5 + (0.5 + 0.002 * i) * math.sin(0.1 * i)]
    for i in range(200)
]
ACCEPTED: dict[str, dict[str, Any]] = {
    "sharp corner": {"outline": [[0, 0], [10, 0], [10, 0.2]]},
    "narrow notch": {"outline": spike(5e-4, 5)},
    "slot": {"outline": [*SQUARE[:3], [5.0005, 10], [5.0005, 5], [5, 5], [5, 10], [0, 10]]},
    "short edge": {"outline": [*SQUARE[:3], [5.0001, 10], [5, 10.0001], [0, 10]]},
    "chamfer of a corner": {"outline": [[0, 0], [9.9999, 0], [10, 0.0001], [10, 10], [0, 10]]},
    "crack with a wider gap": {"cracks": hairpin(0.0011)},
    "crack that is sharply bent": {"cracks": [{"points": [[2, 5], [8, 5], [2, 5.6]]}]},
    "digitised crack": {
        "cracks": [{"points": [[2 + 5e-4 * i, 5 + 5e-4 * (i % 2)] for i in range(99)]}]
    },
    "spiral": {"cracks": [{"points": SPIRAL}]},
    "border along a crack": {"regions": [upper(5)], "cracks": [EDGE_CRACK]},
    "border that was meant to be along it": {"regions": [upper(5 - 5e-7)], "cracks": [EDGE_CRACK]},
    "border across a crack": {
        "regions": [upper(5, 5.2)],
        "cracks": [{"points": [[2, 5.1], [8, 5.1]]}],
    },
    "border that was meant to be the outline": {
        "regions": [region([5e-6, 5e-6], [10, 5e-6], [10, 2], [5e-6, 2])]
    },
    "borders that share a side": {
        "regions": [
            region([2, 2], [4, 2], [4, 4], [2, 4]),
            region([4 + 1e-6, 2.5], [6, 2], [6, 4], [4, 4], name="s"),
        ]
    },
    "border along part of a round hole": {
        "holes": [circle(2)],
        "regions": [
            region(
                [7, 5], {"at": [8, 5], "through": [5, 8]}, [2, 5], {"at": [3, 5], "through": [5, 7]}
            )
        ],
    },
}


@pytest.mark.parametrize("name", ACCEPTED)
def test_accepted(name: str) -> None:
    assert broken_rules(scene(**ACCEPTED[name])) == []
