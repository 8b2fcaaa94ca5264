"""Fixed or proportional loads that do not load a tip."""

from __future__ import annotations

import numpy as np

from cfmpm.fracture import critical_load


def test_a_tip_that_one_part_does_not_load_has_zero_of_it() -> None:
    """It has no values if the state has none: no K, or a tip in a free part."""
    nan = np.nan
    part = {"J": np.array([nan, 1.0, nan]), "K_I": np.array([nan, 2.0, nan]), "place": 1}
    both = {"J": np.array([3.0, 4.0, nan]), "K_I": np.array([nan, 5.0, nan])}
    known = critical_load._known(part, both)
    assert known.keys() == {"J", "K_I"}
    np.testing.assert_array_equal(known["J"], [0.0, 1.0, nan])
    np.testing.assert_array_equal(known["K_I"], [nan, 2.0, nan])
