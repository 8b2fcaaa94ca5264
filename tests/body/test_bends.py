"""Angles between directions."""

from __future__ import annotations

import numpy as np
import pytest

from cfmpm.body.bends import CORNER, SHARP, turn


@pytest.mark.parametrize("degrees", [-179.0, -90.0, -20.0, 0.0, 9.0, 90.0, 180.0])
def test_turn(degrees: float) -> None:
    before = np.array([[2.0, 0.0], [0.0, 3.0], [-1.0, 1.0]])
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    after = 0.7 * before @ np.array([[c, s], [-s, c]])
    found = np.degrees(turn(before, after))
    np.testing.assert_allclose((found - degrees + 180.0) % 360.0, 180.0, atol=1e-12)
    assert np.degrees(turn(before[0], after[0])) == pytest.approx(degrees, abs=1e-12)


def test_a_sharp_kink_is_a_corner_of_the_faces() -> None:
    assert 0.0 < CORNER < SHARP
