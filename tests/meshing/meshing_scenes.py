"""Scenes and checks for the tests of meshing."""

from __future__ import annotations

import numpy as np

from cfmpm.scene.model import Scene

SQUARE = [(0, 0), (10, 0), (10, 10), (0, 10)]
STEEL = {"E": 210e3, "nu": 0.3}


def body(outline=SQUARE, *, loads=({"body_force": (0, 1)},), mesh=None, **geometry):
    """A scene with a geometry."""
    return Scene(
        name="test",
        geometry={"outline": list(outline), **geometry},
        material=STEEL,
        loads=list(loads),
        mesh=mesh or {},
    )


def plate(**mesh):
    """The single edge crack of the paper, 500 x 1000 with a crack of 100."""
    family = {"kind": "single_edge", "width": 500, "height": 1000, "crack_length": 100}
    return Scene(name="plate", family={**family, "traction": 10}, material=STEEL, mesh=mesh or {})


def areas(t):
    a, b, c = (t.nodes[t.triangles[:, i]] for i in range(3))
    return np.linalg.det(np.stack([b - a, c - a], axis=1)) / 2


def lengths(t, pairs):
    return np.hypot(*(t.nodes[pairs[:, 1]] - t.nodes[pairs[:, 0]]).T)


def sides(t):
    """Sorted node pairs of all triangle sides, and in how many triangles each is."""
    every = np.sort(t.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return np.unique(every, axis=0, return_counts=True)


def as_set(pairs):
    return {tuple(pair) for pair in np.sort(pairs, axis=1).tolist()}


def worst_quality(t):
    sides_squared = sum(
        ((t.nodes[t.triangles[:, i]] - t.nodes[t.triangles[:, i - 1]]) ** 2).sum(axis=1)
        for i in range(3)
    )
    return (4 * np.sqrt(3) * areas(t) / sides_squared).min()


def assert_sound(t, scene=None):
    """Check the properties of a valid triangulation."""
    assert (areas(t) > 0).all()
    np.testing.assert_array_equal(np.unique(t.triangles), np.arange(len(t.nodes)))
    pairs, counts = sides(t)
    assert counts.max() == 2
    boundary = as_set(pairs[counts == 1])
    named = [pair for edge in t.edges.values() for pair in as_set(edge)]
    assert len(named) == sum(map(len, t.edges.values())) == len(boundary)
    assert set(named) == boundary
    inner = as_set(pairs[counts == 2])
    for line in t.cracks.values():
        assert as_set(line) <= inner
        np.testing.assert_array_equal(line[1:, 0], line[:-1, 1])
    assert t.regions.shape == (len(t.triangles),)
    assert t.regions.max() < len(t.region_names)
    assert t.region_names[0] == "body"
