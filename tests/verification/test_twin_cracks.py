"""Mirror-symmetric cracks grow together; other cracks grow one by one.

The grid of gmsh is not symmetric, so that nothing but the comparison within its error keeps the
symmetry of the paths.
"""

from __future__ import annotations

import json
import re
from typing import Any

import numpy as np
import pytest
import xarray as xr

import cfmpm
from cfmpm.output.analysis import new_length
from cfmpm.scene import scene_from_dict

WIDTH, HEIGHT, G_C, E, NU = 60.0, 120.0, 0.1, 3000.0, 0.3


def plate(cracks: list[Any], size: float, increments: int, **changes: Any) -> dict[str, Any]:
    """A plate in tension with horizontal cracks at half of its height."""
    body = {
        "outline": [
            {"at": [0, 0], "edge": "bottom"},
            {"at": [WIDTH, 0], "edge": "right"},
            {"at": [WIDTH, HEIGHT], "edge": "top"},
            {"at": [0, HEIGHT], "edge": "left"},
        ],
        "cracks": [{"points": [[x, 60.0] for x in xs]} for xs in cracks],
        "holes": changes.pop("holes", []),
    }
    return {
        "name": "twins",
        "geometry": body,
        "material": {"E": E, "nu": NU, "g_c": G_C},
        "loads": [
            {"edge": "bottom", "traction": [0, -1]},
            {"edge": "top", "traction": [0, 1]},
        ],
        "mesh": {"size": size} | changes.pop("mesh", {}),
        "growth": {"control": "crack", "increments": increments} | changes.pop("growth", {}),
        **changes,
    }


def history(scene: dict[str, Any]) -> xr.Dataset:
    return cfmpm.run(scene_from_dict(scene)).history


def warned(of: xr.Dataset) -> list[str]:
    return [text for text in json.loads(of.attrs["warnings"]) if "grid decides" in text]


def grown(of: xr.Dataset) -> np.ndarray:
    """Growth of each tip since the start, (step, tip)."""
    return np.hypot(of["tip_x"] - of["tip_x"][0], of["tip_y"] - of["tip_y"][0]).values


def double_edge_factor(a: np.ndarray) -> np.ndarray:
    """K / (sigma sqrt(pi a)) of a double edge notched plate (Tada, Paris and Irwin), to 0.5 %."""
    angle = np.pi * a / WIDTH
    return (1.0 + 0.122 * np.cos(angle) ** 4) * np.sqrt(np.tan(angle) / angle)


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_double_edge_notched_plate(element: str) -> None:
    of = history(plate([[0, 10], [60, 50]], 5.0, 20, mesh={"element": element}))
    assert (of["tied"] == 1.0).all()
    lengths = grown(of)
    assert lengths[-1].min() > 5.0
    assert np.abs(lengths[:, 0] - lengths[:, 1]).max() < 1e-3
    path_x, path_y = of["tip_x"].values, of["tip_y"].values
    np.testing.assert_allclose(path_x.sum(axis=1), WIDTH, atol=0.01)
    np.testing.assert_allclose(path_y, 60.0, atol=0.1)
    a = 10.0 + lengths.mean(axis=1)
    k_c = np.sqrt(G_C * E / (1.0 - NU**2))
    right = k_c / (double_edge_factor(a) * np.sqrt(np.pi * a))
    np.testing.assert_allclose(of["load_factor"], right, rtol=0.01 if element == "T6" else 0.03)
    (text,) = warned(of)
    assert text.startswith(
        "crack_1 and crack_2: in steps 1 to 21 the loads at which they reach g_c"
    )
    assert "they grow together" in text


@pytest.mark.parametrize("cracks", [[[10, 20], [40, 50]], [[14, 24], [36, 46]]])
def test_two_collinear_cracks_up_to_their_meeting_and_beyond(cracks: list[Any]) -> None:
    """In the first plate all four tips grow first, later the outer ones."""
    of = history(plate(cracks, 5.0, 22))
    names = of["tip"].values.tolist()
    lengths, x = grown(of), of["tip_x"].values
    solved = np.isfinite(of["load_factor"].values) & ~(of["jump"].values > 0.0)
    for pair in (["crack_1_start", "crack_2_end"], ["crack_1_end", "crack_2_start"]):
        first, second = (names.index(name) for name in pair)
        apart = np.abs(lengths[:, first] - lengths[:, second])
        assert apart[solved].max() < np.nanmax(of["tip_size"])
        middle = x[solved][:, [first, second]].sum(axis=1)
        assert np.median(np.abs(middle - WIDTH)) < 0.01
        assert any(text.startswith(f"{pair[0]} and {pair[1]}: in step") for text in warned(of))
    assert lengths[-1].max() > 4.0


def test_two_cracks_at_a_hole() -> None:
    hole = {"circle": {"centre": [30, 60], "radius": 6}}
    of = history(plate([[24, 20], [36, 40]], 5.0, 12, holes=[hole]))
    lengths = grown(of)
    assert lengths[-1].min() > 2.0
    # Unequal lengths are made up: less than half of an element is left.
    assert (np.abs(np.diff(lengths, axis=1)[:, 0]) <= 0.5 * of["tip_size"].max("tip")).all()
    np.testing.assert_allclose(of["tip_y"], 60.0, atol=0.15)
    assert new_length(of)[-1] == pytest.approx(lengths[-1].sum(), rel=1e-3)


def test_lengths_of_10_and_10_5_mm_go_one_by_one() -> None:
    of = history(plate([[0, 10], [60, 49.5]], 5.0, 4))
    assert (of["tied"] == 0.0).all()
    assert warned(of) == []
    lengths = grown(of)
    assert (lengths[:, 0] == 0.0).all()
    assert (np.diff(lengths[:, 1]) > 0.0).all()


def test_inclined_cracks_of_10_and_10_5_mm_go_one_by_one_behind_their_kinks() -> None:
    """After a kink J and G differ most, and the error of the grid is largest."""
    scene = plate([[0, 10], [60, 49.5]], 5.0, 5)
    slope = {"points": [[0, 70], [10, 60]]}, {"points": [[60, 70.5], [49.5, 60]]}
    scene["geometry"]["cracks"] = list(slope)
    of = history(scene)
    assert (of["tied"] == 0.0).all()
    assert (grown(of)[:, 0] == 0.0).all()


def test_a_finer_grid_tells_apart_what_a_coarse_one_does_not() -> None:
    """The action of the warning helps: cracks of 10 and 10.05 mm."""
    cracks = [[0, 10], [60, 49.95]]
    coarse = history(plate(cracks, 10.0, 1, mesh={"element": "T3"}))
    text = warned(coarse)[0]
    found = re.search(r"agree within the error of the grid, ([\d.]+) % at most", text)
    assert found is not None
    # Of J and G, whose square root is the load.
    ratio = coarse["load_factor"].values[0] / coarse["critical_load_factor"].values[0]
    assert np.ptp(ratio) < 0.01 * float(found[1]) < 0.2
    assert "told apart by a finer grid (smaller mesh.size)" in text
    fine = history(plate(cracks, 2.5, 1))
    assert warned(fine) == []
    assert (grown(fine)[:, 0] == 0.0).all()
    assert grown(fine)[-1, 1] > 0.0


def test_the_largest_tip_alone_is_the_choice_of_the_grid() -> None:
    cracks = [[0, 10], [60, 50]]
    of = history(plate(cracks, 5.0, 1, growth={"tips": "largest"}))
    (text,) = warned(of)
    assert "growth.tips: all lets them grow together" in text
    assert np.count_nonzero(grown(of)[-1]) == 1
    assert np.count_nonzero(grown(history(plate(cracks, 5.0, 1)))[-1]) == 2
