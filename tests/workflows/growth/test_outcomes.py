"""How cracks end on many grids, and the shares of the ends."""

from __future__ import annotations

import growth_data as made_up
import numpy as np
import pytest

from cfmpm.ending import RUN_STATUS
from workflows.growth.beam_holes import BOTTOM, HOLE, MIDDLE
from workflows.growth.outcomes import (
    LOST_WAY,
    NEAR,
    Outcome,
    beam_ending,
    holes_ending,
    outcomes,
    shares,
    told,
)


def ending_at(x, y, status, lost=False):
    return Outcome(np.array([[150.0, 40.0], [x, y]]), status, 3500, lost)


@pytest.mark.parametrize(
    ("one", "expected"),
    [
        (ending_at(*(BOTTOM - [0, HOLE]), "arrived_hole"), "in the bottom hole"),
        (ending_at(MIDDLE[0] + HOLE, MIDDLE[1], "arrived_hole"), "in the middle hole"),
        (ending_at(*(BOTTOM - [0, HOLE + 0.9 * NEAR]), "stopped"), "short of the bottom hole"),
        (ending_at(*(BOTTOM - [0, HOLE + 1.1 * NEAR]), "stopped"), "elsewhere"),
        (ending_at(*(BOTTOM - [0, HOLE + 0.5 * NEAR]), "stopped", lost=True), LOST_WAY),
        (ending_at(180.0, 203.2, "arrived_boundary"), "past the holes"),
    ],
)
def test_ends_in_the_beam(one, expected):
    assert beam_ending(one) == expected


def test_ends_at_two_holes():
    assert holes_ending(ending_at(1, 1, "arrived_crack")) == "at the other crack"
    assert holes_ending(ending_at(1, 1, "stopped")) == "on the way"
    assert holes_ending(ending_at(1, 1, "stopped", lost=True)) == LOST_WAY


def test_outcomes_of_a_study():
    scatter = made_up.edge_grids()
    unstable = np.int8(RUN_STATUS.index("unstable"))
    scatter = scatter.assign(run_status=scatter.run_status.where(scatter.grid > 0, unstable))
    found = outcomes(scatter, "crack_1", how="as_printed")
    assert [one.points for one in found] == [780, 800, 2500, 2600]
    assert {one.status for one in found} == {"arrived_boundary"}
    # A crack that has arrived is not lost with what follows.
    assert not any(one.lost for one in found)


def test_shares_are_told():
    ends = ["stopped", "arrived_hole", "stopped"]
    counted = shares([ending_at(1, 1, one) for one in ends], lambda one: one.status)
    assert told(counted) == "stopped: 2 of 3, arrived_hole: 1 of 3"
