"""Springs on a grid: supports between nodes, and ghost stabilisation."""

from __future__ import annotations

import numpy as np
import pytest
from structured import rectangle

from cfmpm.body.grid import build_grid
from cfmpm.body.springs import ghost, supports


@pytest.fixture
def grid():
    return build_grid(rectangle(4, 4, shake=0.4, crack=(2, 0, 2)), "T3")


def energy(springs, u):
    return 0.5 * np.sum(u.ravel() * (springs.matrix @ u.ravel()))


def test_support_is_the_derivative_of_its_energy(grid):
    rng = np.random.default_rng(0)
    element = np.array([3, 10, 10, 20])
    position = grid.nodes[grid.triangles[element]].mean(axis=1) + 0.02
    axis = np.array([0, 1, 0, 1])
    come, target = rng.normal(size=(2, 4))
    springs = supports(grid, element, position, axis, 70.0, come, target)
    u, level = rng.normal(size=grid.nodes.shape), 0.3

    def stored(u):
        total = 0.0
        for e, x, i, c, t in zip(element, position, axis, come, target, strict=True):
            corners = grid.triangles[e]
            shape = np.linalg.solve(np.vstack([np.ones(3), grid.nodes[corners].T]), [1.0, *x])
            total += 35.0 * (c + shape @ u[corners, i] - level * t) ** 2
        return total

    force = springs.resistance(u) - level * springs.pull
    for _ in range(4):
        d = rng.normal(size=u.shape)
        slope = (stored(u + 1e-5 * d) - stored(u - 1e-5 * d)) / 2e-5
        np.testing.assert_allclose(np.sum(force * d), slope, rtol=1e-8)


def test_ghost_feels_jumps_of_the_gradient_and_nothing_else(grid):
    fill = np.full(len(grid.elements), 0.5)
    springs = ghost(grid, fill, 0.6, 10.0)
    assert springs is not None
    linear = grid.nodes @ np.array([[0.3, -0.2], [0.7, 0.1]]) + np.array([3.0, -1.0])
    scale = abs(springs.matrix).max()
    assert abs(springs.resistance(linear)).max() < 1e-13 * scale
    u = np.random.default_rng(1).normal(size=grid.nodes.shape)
    # Side by side from the definition.
    total = 0.0
    for e, k in zip(*np.nonzero(grid.twins >= 0), strict=True):
        other = grid.twins[e, k] // 3
        if other < e:
            continue
        gradients = []
        for t in (e, other):
            x = grid.nodes[grid.triangles[t]]
            gradients.append(
                np.linalg.solve(np.diff(x, axis=0), np.diff(u[grid.triangles[t]], axis=0))
            )
        a, b = grid.nodes[grid.triangles[e, k]], grid.nodes[grid.triangles[e, (k + 1) % 3]]
        normal = np.array([(b - a)[1], -(b - a)[0]])  # of length h
        total += 5.0 * np.sum((normal @ (gradients[0] - gradients[1])) ** 2)
    np.testing.assert_allclose(energy(springs, u), total, rtol=1e-12)


def test_ghost_does_not_cross_a_crack(grid):
    """Relative motion of the crack faces has no energy along the faces, only ahead of the tip."""
    fill = np.full(len(grid.elements), 0.5)
    springs = ghost(grid, fill, 0.6, 10.0)
    left, right = (grid.crack_faces["crack_1"][:, side] for side in (0, 1))
    pairs = {tuple(sorted(pair)) for pair in np.column_stack([left // 3, right // 3]).tolist()}
    stiffness = springs.matrix.toarray()
    for e, other in pairs:
        own = np.setdiff1d(grid.triangles[e], grid.triangles[other])
        far = np.setdiff1d(grid.triangles[other], grid.triangles[e])
        shared = np.intersect1d(grid.triangles[e], grid.triangles[other])
        if shared.size == 0:  # away from the tip
            assert not stiffness[np.ix_(2 * own, 2 * far)].any()


def test_ghost_only_where_one_side_holds_little_and_both_hold_some(grid):
    fill = np.ones(len(grid.elements))
    assert ghost(grid, fill, 0.6, 10.0) is None
    fill[5] = 0.1
    touched = ghost(grid, fill, 0.6, 10.0).matrix.nonzero()[0] // 2
    near = np.append(grid.twins[5][grid.twins[5] >= 0] // 3, 5)
    assert set(touched) == set(grid.triangles[near].ravel())
    fill[near[:-1]] = 0.0
    assert ghost(grid, fill, 0.6, 10.0) is None
