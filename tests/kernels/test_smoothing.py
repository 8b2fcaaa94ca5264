"""Smoothing of triangles of low quality."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from structured import rectangle

from cfmpm.kernels import smoothing, topology
from cfmpm.kernels.triangles import triangle_quality


def smooth(mesh, least, movable=None):
    nodes = mesh.nodes.copy()
    inner = np.ones(len(nodes), bool)
    for pairs in mesh.edges.values():
        inner[pairs] = False
    movable = inner if movable is None else movable & inner
    triangles = np.ascontiguousarray(mesh.triangles)
    stars = topology.node_stars(triangles, len(nodes))
    moved = smoothing.smooth(nodes, triangles, *stars, movable, least, 10)
    return nodes, moved, movable


@given(st.integers(0, 10**6), st.sampled_from([0.0, 0.2, 0.5, 1.0]))
def test_no_triangle_becomes_worse_than_the_worst_was(seed, least):
    mesh = rectangle(5, 4, shake=0.9, seed=seed)
    nodes, moved, movable = smooth(mesh, least)
    before = triangle_quality(mesh.nodes, mesh.triangles)
    after = triangle_quality(nodes, mesh.triangles)
    assert after.min() >= before.min()
    np.testing.assert_array_equal(nodes[~moved], mesh.nodes[~moved])
    assert not moved[~movable].any()
    # Only around what was bad.
    if (before >= least).all():
        assert not moved.any()
    again = smooth(mesh, least)
    np.testing.assert_array_equal(again[0], nodes)


def test_one_node_goes_to_the_middle_of_its_neighbours():
    mesh = rectangle(2, 2, shake=0.0)
    centre = int(np.flatnonzero((mesh.nodes == 0.5).all(axis=1))[0])
    mesh.nodes[centre] = (0.9, 0.52)
    nodes, moved, _ = smooth(mesh, 0.5)
    assert np.flatnonzero(moved).tolist() == [centre]
    around = np.unique(mesh.triangles[(mesh.triangles == centre).any(axis=1)])
    mean = mesh.nodes[around[around != centre]].mean(axis=0)
    np.testing.assert_allclose(nodes[centre], mean, atol=1e-15)


def test_a_triangle_that_turned_over_is_turned_back():
    mesh = rectangle(2, 2, shake=0.0)
    centre = int(np.flatnonzero((mesh.nodes == 0.5).all(axis=1))[0])
    mesh.nodes[centre] = (1.2, 0.5)
    assert triangle_quality(mesh.nodes, mesh.triangles).min() < 0.0
    nodes, _, _ = smooth(mesh, 0.2)
    assert triangle_quality(nodes, mesh.triangles).min() > 0.2


@pytest.mark.parametrize("least", [0.0, 1.0])
def test_nodes_that_may_not_move_stay(least):
    mesh = rectangle(4, 4, shake=0.9, seed=3)
    nodes, moved, _ = smooth(mesh, least, np.zeros(len(mesh.nodes), bool))
    assert not moved.any()
    np.testing.assert_array_equal(nodes, mesh.nodes)
