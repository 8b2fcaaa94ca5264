"""The boundary value problem of small strain and finite deformation, with additional forces."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from posed import balanced, driven, elastic, pose, unloaded
from scipy.sparse import csr_array
from structured import rectangle

from cfmpm.body.grid import build_grid
from cfmpm.body.points import locate
from cfmpm.body.springs import ghost, supports
from cfmpm.equilibrium import newton, small_strain, stepping

SOFT = elastic(1.3, 0.9)


@pytest.fixture
def grid():
    return build_grid(rectangle(4, 4, shake=0.4, crack=(2, 0, 2)), "T3")


def springs_of(grid):
    """Springs across the crack and between separate triangles need additional matrix entries."""
    place = np.array([[0.3, 0.2], [0.7, 0.9], [0.9, 0.4]]) * np.ptp(grid.nodes, axis=0)
    nothing = np.zeros(3)
    held = supports(grid, locate(grid, place), place, np.array([0, 1, 0]), 7.0, nothing, nothing)
    stabilised = ghost(grid, np.full(len(grid.elements), 0.5), 0.6, 3.0)
    return held, stabilised


def spread(n, matrix, free):
    """Expand a matrix of the free degrees of freedom to all of them."""
    found = np.zeros((n, n))
    found[np.ix_(free, free)] = matrix.toarray()
    return found


@pytest.mark.parametrize("finite", [False, True], ids=["small", "finite"])
def test_stiffness_of_forces_is_added_where_it_belongs(grid, finite):
    held = np.random.default_rng(2).random(grid.nodes.shape) < 0.3
    plain = pose(grid, unloaded(grid, held), SOFT)
    forces = springs_of(grid)

    def assembled(problem):
        if not finite:
            return small_strain.assemble_stiffness(problem)
        at_rest = problem.points.at_rest()
        nothing = np.zeros_like(grid.nodes)
        trial = newton.Trial(nothing, at_rest, nothing, 0.0)
        return newton.assemble_stiffness(problem, trial, at_rest.internal_variables)

    free, n = np.flatnonzero(~held), held.size
    expected = spread(n, assembled(plain), free)
    pattern = assembled(plain).nnz
    for force in forces:
        expected[np.ix_(free, free)] += force.matrix.toarray()[np.ix_(free, free)]
    found = assembled(replace(plain, forces=forces))
    assert found.has_sorted_indices
    assert found.nnz > pattern
    np.testing.assert_allclose(spread(n, found, free), expected, rtol=0, atol=1e-14)


def test_springs_hold_a_body_at_small_strain(grid):
    """Stiff springs at the nodes of the lower side act as supports, also in tension."""
    low, high = grid.nodes.min(axis=0)[1], grid.nodes.max(axis=0)[1]
    lower = np.flatnonzero(grid.nodes[:, 1] == low)
    upper = np.flatnonzero(grid.nodes[:, 1] == high)
    target = np.array([0.2, -0.1])
    both = np.concatenate([lower, upper])
    values = np.concatenate([np.tile(target, (len(lower), 1)), np.zeros((len(upper), 2))])
    exact = balanced(pose(grid, driven(grid, both, values), SOFT))
    nodes, axis = np.repeat(lower, 2), np.tile([0, 1], len(lower))
    element = np.array([np.flatnonzero((grid.triangles == node).any(axis=1))[0] for node in nodes])
    nothing = np.zeros(len(nodes))
    springs = supports(grid, element, grid.nodes[nodes], axis, 1e8, nothing, target[axis])
    problem = pose(grid, driven(grid, upper, 0.0), SOFT, forces=(springs,))
    found = balanced(problem)
    np.testing.assert_allclose(found.displacement, exact.displacement, rtol=0, atol=1e-7)
    reaction = springs.pull - springs.resistance(found.displacement)
    np.testing.assert_allclose(
        reaction[lower], exact.internal_force[lower], rtol=0, atol=1e-5 * np.abs(reaction).max()
    )


@dataclass(frozen=True)
class Hardening:
    """A cubic spring along x with a dead force."""

    nodes: np.ndarray
    size: float
    pull: np.ndarray

    def resistance(self, displacement):
        force = np.zeros_like(displacement)
        force[self.nodes] = self.size * displacement[self.nodes] ** 3
        return force

    def stiffness(self, displacement):
        slope = np.zeros_like(displacement)
        slope[self.nodes] = 3.0 * self.size * displacement[self.nodes] ** 2
        n = slope.size  # zeros are stored: the pattern stays
        return csr_array((slope.ravel(), np.arange(n), np.arange(n + 1)), shape=(n, n))


def test_a_force_of_ones_own_that_is_not_linear():
    """Solved together with the body, with quadratic convergence."""
    grid = build_grid(rectangle(4, 4, shake=0.4), "T3")
    low, high = grid.nodes.min(axis=0)[0], grid.nodes.max(axis=0)[0]
    pulled = np.flatnonzero(grid.nodes[:, 0] == high)
    pull = np.zeros_like(grid.nodes)
    pull[pulled, 0] = 0.05
    force = Hardening(pulled, 20.0, pull)
    loading = driven(grid, np.flatnonzero(grid.nodes[:, 0] == low), 0.0)
    problem = pose(grid, loading, SOFT, forces=(force,))
    found = stepping.advance(problem, stepping.at_rest(problem), 1.0)
    unbalanced = pull - force.resistance(found.displacement) - found.internal_force
    assert np.abs(unbalanced[~loading.prescribed]).max() < 1e-9 * np.abs(found.internal_force).max()
    assert np.abs(force.resistance(found.displacement)).max() > 0.2 * pull.max()
    before, last = found.residuals[-2:]
    assert last < 100.0 * before**2 + 1e-13
    # What pull and force leave of each other is the work that the body stores.
    many = stepping.at_rest(problem)
    for factor in np.linspace(0.0, 1.0, 101)[1:]:
        many = stepping.advance(problem, many, factor)
    stored = np.sum(found.points.energy * found.points.volume)
    assert many.external_work == pytest.approx(stored, rel=2e-3)
