"""The complementarity problem of closed crack faces: convergence, and unsolvable cases."""

from __future__ import annotations

import numpy as np
import pytest
import round_off
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csc_array, csr_array, eye_array

from cfmpm.equilibrium import complementarity
from cfmpm.errors import SolveError
from cfmpm.linear import solvers
from cfmpm.linear.solvers import Solution


class Flexibility:
    """A body, given by the openings due to unit contact forces."""

    def __init__(self, matrix):
        self.matrix = np.array(matrix, float)

    def solve(self, b):
        return Solution(self.matrix @ b, 0.0)


def pressed(matrix, gap, slack=0.0):
    """Forces and openings of the pairs."""
    body = Flexibility(matrix)
    push = csc_array(eye_array(len(gap)))
    force = complementarity.Flexibility(push, body).complementary_force(np.array(gap, float), slack)
    return force, gap + body.matrix @ force


# In which the pairs that are wrong, changed all at once, come round again and again.
ROUND_AND_ROUND = [
    ([[27.25, -12, 21], [-12, 10.25, -11], [21, -11, 17.25]], [-2, 4, -4]),
    (
        [[23.25, -17, 0, -24], [-17, 20.25, -7, 20], [0, -7, 15.25, -1], [-24, 20, -1, 26.25]],
        [-2, 1, -2, 2],
    ),
    (
        [
            [20.25, -6, -11, 8, 12],
            [-6, 14.25, -4, 14, -4],
            [-11, -4, 18.25, -17, -8],
            [8, 14, -17, 27.25, 6],
            [12, -4, -8, 6, 10.25],
        ],
        [-3, 1, -2, 2, 0],
    ),
]


@pytest.mark.parametrize(("matrix", "gap"), ROUND_AND_ROUND, ids=["three", "four", "five"])
def test_pairs_that_go_round_change_one_at_a_time(matrix, gap):
    force, opening = pressed(matrix, gap)
    assert (force >= 0.0).all()
    assert opening.min() > -1e-12
    np.testing.assert_allclose(force * opening, 0.0, atol=1e-12)
    assert force.any()


@pytest.mark.parametrize("last", [1.0, 1.0 + 2.0**-51, 0.5], ids=["zero", "noise", "negative"])
def test_pairs_that_depend_on_each_other_have_no_answer(last):
    """The pivot of the second pair is zero, round-off or negative."""
    with pytest.raises(SolveError, match="2 pairs of nodes cannot all be closed"):
        pressed([[1.0, 1.0], [1.0, last]], [-1.0, -2.0])


def test_faces_that_only_touch_are_not_pressed():
    """An overlap within the tolerance is accepted; a larger one closes the pair."""
    force, opening = pressed(np.diag([2.0, 2.0]), [-1e-3, -3e-3], slack=2e-3)
    np.testing.assert_allclose(force, [0.0, 1.5e-3])
    np.testing.assert_allclose(opening, [-1e-3, 0.0], atol=1e-18)


def test_what_a_neighbour_opens_does_not_pull():
    """Each pair alone closes; the force of the first opens the second, whose force is then zero."""
    flexibility = np.array([[2.0, 1.9], [1.9, 2.0]])
    force, opening = pressed(flexibility, [-2.0, -1.0])
    np.testing.assert_allclose(force, [1.0, 0.0])
    error = round_off.of_sum(flexibility * force, axis=1)
    assert (np.abs(opening - [0.0, 0.9]) < error).all()


def test_what_a_neighbour_closes_is_pressed():
    """A pair that is open at first overlaps once the other one is closed."""
    flexibility = np.array([[2.0, -1.5], [-1.5, 2.0]])
    force, opening = pressed(flexibility, [-2.0, 1.0])
    assert (force > 0.0).all()
    assert (np.abs(opening) < round_off.of_sum(flexibility * force, axis=1)).all()


@pytest.mark.parametrize("patience", [0, complementarity.PATIENCE])
@settings(max_examples=40)
@given(seed=st.integers(0, 10**6), n=st.integers(1, 12))
def test_block_pivoting_solves_any_definite_problem(patience, seed, n):
    """With patience 0 pairs change one at a time, which ends for any such matrix (Murty)."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(n, n))
    K = root @ root.T + 1e-3 * np.eye(n)
    gap = rng.normal(size=n)
    factor = solvers.select(n, "superlu").factor(csr_array(K))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(complementarity, "PATIENCE", patience)
        patch.setattr(complementarity, "ROUNDS", 5000)
        pairs = complementarity.Flexibility(csc_array(eye_array(n)), factor)
        force = pairs.complementary_force(gap, 1e-12)
    opening = gap + np.linalg.solve(K, force)
    assert (force >= 0).all()
    assert opening.min() > -1e-9 * max(1.0, np.abs(force).max() * np.linalg.norm(np.linalg.inv(K)))
    assert np.abs(opening[force > 0]).max(initial=0.0) < 1e-9 * np.linalg.cond(K)


def beside_a_part(seed: int):
    """Pairs of a body with a free part: themselves, flexibility, openings by motions, gaps."""
    rng = np.random.default_rng(seed)
    n, motions = 40, 3
    part = rng.normal(size=(n, n)) / np.sqrt(n)
    flexibility = part @ part.T + 0.1 * np.eye(n)
    parting, gap = rng.normal(size=(n, motions)), rng.normal(size=n)
    pairs = complementarity.Flexibility(csc_array(eye_array(n)), Flexibility(flexibility))
    return pairs, flexibility, parting, gap


@pytest.mark.parametrize("soft", [1e4, 1e9])
def test_soft_springs_are_no_reason_to_overlap(soft: float) -> None:
    """What they yield to is a difference of large numbers, which is not taken for an overlap."""
    pairs, flexibility, parting, gap = beside_a_part(seed=3)
    springs = np.sqrt(soft) * parting
    force = pairs.complementary_force(gap, 1e-12, springs)
    # Open pairs that touch just so, as behind a part that has moved.
    gap[force == 0.0] -= (gap + (flexibility + springs @ springs.T) @ force)[force == 0.0]
    again = pairs.complementary_force(gap, 1e-12, springs)
    assert again.min() >= 0.0
    np.testing.assert_allclose(again, force, atol=1e-12 * soft * force.max())


def test_motions_that_nothing_resists_are_found_with_the_forces() -> None:
    """No resultant on a motion, no overlap, no tension, no force on an open pair."""
    pairs, flexibility, parting, gap = beside_a_part(seed=5)
    soft = pairs.complementary_force(gap, 1e-12, 1e2 * parting)
    found = pairs.force_beside_motions(gap, 1e-12, parting, soft > 0.0)
    assert found is not None
    force, moved = found
    opening = gap + flexibility @ force + parting @ moved
    scale = np.abs(force).max()
    assert force.min() >= 0.0
    assert force.max() > 0.0
    assert opening.min() > -1e-11
    assert np.abs(parting.T @ force).max() < 1e-11 * scale
    assert np.abs(opening * force).max() < 1e-11 * scale


def test_no_closed_pairs_determine_no_motion() -> None:
    pairs = complementarity.Flexibility(csc_array(eye_array(2)), Flexibility(np.eye(2)))
    nothing = np.zeros(2, bool)
    assert pairs.force_beside_motions(np.array([1.0, -1.0]), 0.0, np.eye(2), nothing) is None


def test_parts_that_only_touch_do_not_press() -> None:
    """Overlaps within the slack are no reason for a force on a part that has been moved."""
    pairs = complementarity.Flexibility(csc_array(eye_array(4)), Flexibility(np.eye(4)))
    # The last pair is one of a crack away from the part.
    parting = np.array([[1.0], [-1.0], [1.0], [0.0]])
    gap, closed = np.array([-1e-14, -1e-14, 1.0, -1e-3]), np.array([True, True, False, True])
    found = pairs.force_beside_motions(gap, 1e-12, parting, closed)
    assert found is not None
    assert not found[0][:3].any()
    assert found[0][3] == 1e-3
    far = pairs.force_beside_motions(1e3 * gap, 1e-12, parting, closed)
    assert far is not None
    assert far[0][:3].max() == pytest.approx(1e-11, rel=1e-9)


def test_a_motion_that_no_closed_pair_determines_is_left_alone() -> None:
    pairs = complementarity.Flexibility(csc_array(eye_array(3)), Flexibility(np.eye(3)))
    # Sliding along the faces, up to round-off.
    parting = np.array([[1.0, 1e-14], [-1.0, 3e-14], [1.0, 1.0]])
    gap, closed = np.array([-2e-3, -1e-3, 1.0]), np.array([True, True, False])
    found = pairs.force_beside_motions(gap, 1e-12, parting, closed)
    assert found is not None
    force, moved = found
    np.testing.assert_allclose(force, [1.5e-3, 1.5e-3, 0.0], rtol=1e-12)
    np.testing.assert_allclose(moved, [0.5e-3, 0.0], atol=1e-12)
