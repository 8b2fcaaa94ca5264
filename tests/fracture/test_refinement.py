from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import round_off
from posed import balanced, pose
from structured import rectangle

import cfmpm
from cfmpm import build
from cfmpm.body.grid import build_grid
from cfmpm.fracture import growing
from cfmpm.fracture.refinement import EQUILATERAL, GROWTH, refine
from cfmpm.scene import expand, scene_from_dict

TIP = np.array([5.0, 4.0])


def areas(mesh):
    a, b, c = (mesh.nodes[mesh.triangles[:, k]] for k in range(3))
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def smallest_angle(mesh):
    corners = mesh.nodes[mesh.triangles] @ np.array([1.0, 1.0j])
    turns = (np.roll(corners, 1, axis=1) - corners) / (np.roll(corners, -1, axis=1) - corners)
    return np.angle(turns).min()


def cracked(number, **options):
    mesh = rectangle(8, 8, 8, 8, shake=0.3, crack=(4, 0, 5), seed=number, **options)
    right = (mesh.nodes[mesh.triangles].mean(axis=1)[:, 0] > 6.0).astype(np.int64)
    return replace(mesh, regions=right, region_names=("body", "other"), points={"push": 30})


@pytest.mark.parametrize("number", range(5))
@pytest.mark.parametrize("size", [2.0, 0.4, 0.05])
def test_triangles_are_halved_until_they_are_small_enough(number, size):
    mesh = cracked(number)
    fine, changed = refine(mesh, TIP, size)
    distance = np.hypot(*(fine.nodes[fine.triangles].mean(axis=1) - TIP).T)
    assert (np.sqrt(areas(fine) / EQUILATERAL) <= size + GROWTH * distance).all()
    assert (len(changed) == 0) == (size == 2.0)
    # Nothing moves, nothing is lost, no angle gets too small.
    assert areas(fine).min() > 0.0
    for region in (0, 1):
        part = areas(fine)[fine.regions == region].sum()
        assert part == pytest.approx(areas(mesh)[mesh.regions == region].sum(), rel=1e-13)
    np.testing.assert_array_equal(fine.nodes[: len(mesh.nodes)], mesh.nodes)
    assert fine.points == mesh.points
    assert smallest_angle(fine) > 0.49 * smallest_angle(mesh)
    # What did not change has its number still.
    n = len(mesh.triangles)
    same = np.setdiff1d(np.arange(n), changed)
    np.testing.assert_array_equal(fine.triangles[same], mesh.triangles[same])
    assert np.isin(np.arange(n, len(fine.triangles)), changed).all()
    # It is conforming, and its lines are those of before.
    grid = build_grid(fine, "T3")
    lines = sum(len(pairs) for pairs in fine.edges.values())
    faces = 2 * len(fine.cracks["crack_1"])
    assert np.count_nonzero(grid.twins < 0) == lines + faces
    for old, new in (
        *((mesh.edges[name], fine.edges[name]) for name in mesh.edges),
        (mesh.cracks["crack_1"], fine.cracks["crack_1"]),
    ):
        np.testing.assert_array_equal(new[1:, 0], new[:-1, 1])
        assert np.isin(old, new).all()
        lengths = [np.hypot(*np.diff(fine.nodes[p], axis=1)[:, 0].T).sum() for p in (old, new)]
        assert lengths[1] == pytest.approx(lengths[0], rel=1e-14)
    (tip,) = grid.tips
    np.testing.assert_array_equal(tip.path[0], TIP)


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_uniform_stress_stays_uniform(element):
    """Patch test of growth with bisection of triangles before each release."""
    scene = scene_from_dict(
        {
            "name": "strip",
            "family": {"kind": "single_edge", "width": 12, "height": 6, "crack_length": 3},
            "material": {"E": 1e3, "nu": 0.3, "g_c": 1e-6},
            "loads": [
                {"edge": "left", "displacement": {"x": 0}},
                {"edge": "right", "displacement": {"x": 0.012}},
            ],
            "mesh": {"element": element, "size": 1.2, "grading": "uniform"},
            "fracture": {"refine": 0.4},
            "growth": {},
        }
    )
    body = build.build(scene)
    nodes, volume = len(body.grid.nodes), body.points.volume.sum()
    for _ in range(8):
        body = growing.release(expand(scene), body, {"crack_1": np.array([1.0, 0.0])})
        problem = pose(body.grid, body.loading, body.materials, body.integration)
        solved, slopes = balanced(problem), problem.gradients
        points, u = solved.points, solved.displacement
        pull = 1e3 / (1.0 - 0.3**2) * 0.012 / 12.0
        modulus = round_off.stiffest(1e3, 0.3)
        error = round_off.LinearBody(body.grid, points, slopes, u, modulus).of_stress / pull
        assert np.abs(points.stress / pull - [1.0, 0.0, 0.0]).max() < error
        assert error < 1e-6
        assert body.points.volume.sum() == pytest.approx(volume, rel=1e-12)
        assert body.grid.tips[0].h < 0.7
    assert len(body.grid.nodes) > nodes + 40


def pulled_plate(crack_length, increments):
    """Section 5.2 of the paper on 2600 triangles of 20 mm."""
    config = {
        "name": "plate",
        "family": {"kind": "single_edge", "width": 500, "height": 1000},
        "material": {"E": 210e3, "nu": 0.3, "g_c": 1.0},
        "loads": [
            {"edge": "bottom", "displacement": {"y": -1}},
            {"edge": "top", "displacement": {"y": 1}},
        ],
        "mesh": {"element": "T3", "size": 20.5, "grading": "uniform"},
        "fracture": {"refine": 2.0},
        "growth": {"increments": increments},
    }
    config["family"]["crack_length"] = crack_length
    history = cfmpm.run(scene_from_dict(config)).history
    return history.crack_length.values[:, 0], history.K_I.values[:, 0]


@pytest.mark.parametrize(("length", "g"), [(100, 328.87), (200, 479.48), (300, 489.83)])
def test_refinement_makes_a_coarse_grid_accurate(length, g):
    exact = np.sqrt(g * 210e3 / (1.0 - 0.3**2))
    lengths, k = pulled_plate(length - 5.0, 8)
    # The first value is that of the grid as it was.
    assert lengths[1] < length < lengths[-1]
    assert np.interp(length, lengths[1:], k[1:]) == pytest.approx(exact, rel=0.01)


def test_the_coarse_grid_alone_is_not():
    (_, _), (k, _) = pulled_plate(100.0, 1)
    assert k < 0.99 * np.sqrt(328.87 * 210e3 / (1.0 - 0.3**2))
