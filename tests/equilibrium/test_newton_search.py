"""Line search of Newton's method: step length, and backtracking."""

from __future__ import annotations

import numpy as np
import pytest

from cfmpm.body.points import MaterialPoints
from cfmpm.equilibrium import newton
from cfmpm.errors import SolveError

NO_POINTS = MaterialPoints(
    np.zeros((0, 2)), np.zeros(0), np.zeros(0, np.int64), np.zeros(0, np.int64)
).at_rest()


class Searched:
    """The line search from (0, 0) to (1, 0) for given unbalanced forces.

    Parameters
    ----------
    unbalanced : callable
        (along, across) as a function of the step length.
    inverted_from : float
        Step length from which on a point is inverted.
    """

    def __init__(self, unbalanced, inverted_from=np.inf):
        self.tried = []
        self._unbalanced, self._inverted_from = unbalanced, inverted_from
        self._march = object.__new__(newton.March)
        self._march._free = np.array([[True, True]])
        self._march.trial = self._trial

    def _trial(self, displacement):
        part = displacement[0, 0]
        self.tried.append(part)
        if part >= self._inverted_from:
            raise SolveError("1 material points would be turned inside out")
        force = -np.array([self._unbalanced(part)], float)
        return newton.Trial(displacement, NO_POINTS, force, 0.0)

    def end(self):
        """Final step length, and those that were tried."""
        start = self._trial(np.zeros((1, 2)))
        self.tried.clear()
        found = self._march._searched(start, np.array([[1.0, 0.0]]), np.zeros((1, 2)), np.zeros(0))
        return found.displacement[0, 0], self.tried


@pytest.mark.parametrize(
    ("unbalanced", "end"),
    [
        # Newton's own: all that is unbalanced goes.
        (lambda t: (1 - t, 0.0), 1.0),
        # The work along the correction falls, though the forces grow aside.
        (lambda t: (1 - 0.3 * t, 5.0 * t), 1.0),
        # The forces fall, though not their work along the correction.
        (lambda t: (1 - 0.1 * t, 3.0 - 3.0 * t), 1.0),
        # Too far: as much force the other way, and a quarter of the way is right.
        (lambda t: (1 - 4.0 * t, 0.0), 0.25),
        (lambda t: (1 - 2.1 * t, 0.0), 0.5),
        # A little less work is not enough where the forces grow.
        (lambda t: (1 - 0.15 * t if t == 1 else 1 - t, 5.0 * t), 0.5),
    ],
    ids=["all", "work", "force", "too far", "a little too far", "work hardly falls"],
)
def test_a_correction_is_taken_as_far_as_it_helps(unbalanced, end):
    part, tried = Searched(unbalanced).end()
    assert part == end
    assert tried == [0.5**k for k in range(len(tried))]


def test_no_point_is_turned_inside_out_on_the_way():
    part, tried = Searched(lambda t: (1 - t, 0.0), inverted_from=0.3).end()
    assert part == 0.25
    assert tried == [1.0, 0.5, 0.25]


def test_where_nothing_helps_the_step_is_given_up():
    search = Searched(lambda t: (1 + t, t))
    with pytest.raises(SolveError, match="the line search along Newton's correction"):
        search.end()
    assert search.tried == [0.5**k for k in range(8)]
