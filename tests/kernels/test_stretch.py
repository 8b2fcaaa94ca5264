"""The measure that limits load steps: the largest stretch, or inverse stretch, of a point."""

from __future__ import annotations

import numpy as np
import pytest

from cfmpm.kernels import stretch

EYE = np.eye(2)


def rotation(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


def deformed(first, second, before=0.4, after=-1.1):
    """H of principal stretches along rotated axes, followed by a rotation."""
    return rotation(after) @ np.diag([first, second]) @ rotation(before) - EYE


@pytest.mark.parametrize(
    ("first", "second", "extent"),
    [
        (1.0, 1.0, 1.0),
        (3.0, 1.0, 3.0),
        (3.0, 0.9, 3.0),
        (1.2, 0.25, 4.0),
        (1.0, 0.5, 2.0),
        (0.5, 0.4, 2.5),
        (5.0, 4.0, 5.0),
    ],
)
def test_extent_is_the_largest_stretch_or_the_smallest_inverted(first, second, extent):
    for before, after in ((0.0, 0.0), (0.4, -1.1), (2.0, 3.0)):
        for pair in ((first, second), (second, first)):
            found = stretch.extent(deformed(*pair, before, after))
            assert found == pytest.approx(extent, rel=1e-14)


def test_extent_of_random_gradients_by_singular_values():
    rng = np.random.default_rng(0)
    for _ in range(200):
        F = EYE + rng.uniform(-0.9, 0.9, (2, 2))
        if np.linalg.det(F) < 0.01:
            continue
        largest, smallest = np.linalg.svd(F)[1]
        assert stretch.extent(F - EYE) == pytest.approx(max(largest, 1 / smallest), rel=1e-11)


@pytest.mark.parametrize("place", [0, 1, 2])
@pytest.mark.parametrize(
    ("before", "after", "jump"),
    [
        ((1.0, 1.0), (1.6, 1.0), 1.6),
        ((1.0, 1.0), (1.0, 0.5), 2.0),
        ((1.0, 0.8), (1.0, 0.4), 2.0),
        ((2.0, 1.0), (2.6, 0.7), 1.3),
        # From pulled to pressed: by what it is then, over what it was.
        ((1.5, 1.0), (1.0, 0.5), 2.0 / 1.5),
    ],
)
def test_jump_is_that_of_the_point_that_jumps_most(place, before, after, jump):
    still = np.stack([deformed(1.3, 0.9), deformed(2.0, 0.6), deformed(1.0, 1.0)])
    moved = still.copy()
    still[place], moved[place] = deformed(*before), deformed(*after, before=1.0)
    assert stretch.largest_jump(still, moved) == pytest.approx(jump, rel=1e-13)


def test_what_goes_back_does_not_jump():
    one, other = deformed(1.0, 0.5)[None], deformed(1.0, 0.8)[None]
    assert stretch.largest_jump(one, other) == pytest.approx(0.625, rel=1e-13)
