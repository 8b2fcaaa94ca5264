"""Steps, sizes and names as text in warnings and file names."""

from __future__ import annotations

import numpy as np
import pytest

from cfmpm.output.analysis import by_about, in_steps
from cfmpm.output.files import LONGEST_NAME, in_file_name
from cfmpm.output.warnings.doubt import SIZE, Doubt


@pytest.mark.parametrize(
    ("steps", "said"),
    [
        ([3], "in step 3"),
        ([2, 3, 4], "in steps 2 to 4"),
        ([2, 3, 5], "in 3 of the steps 2 to 5"),
        ([1, 400], "in 2 of the steps 1 to 400"),
    ],
)
def test_steps(steps: list[int], said: str) -> None:
    where = np.zeros(500, bool)
    where[np.array(steps) - 1] = True
    assert in_steps(where) == said


@pytest.mark.parametrize(("size", "said"), [(1234.0, "1234"), (0.0123, "0.012"), (2.0, "2")])
def test_sizes(size: float, said: str) -> None:
    assert Doubt(f"up to {SIZE} points", size=size).said() == f"up to {said} points"


def test_names_of_files_are_short_and_differ() -> None:
    long = ["\u88c2" * 90 + end for end in "ab"]
    names = [in_file_name(name) for name in long]
    assert names[0] != names[1]
    assert all(len(name.encode()) <= LONGEST_NAME for name in names)
    assert in_file_name("tip/1") == "tip%2F1"


@pytest.mark.parametrize(
    ("effect", "said"),
    [
        (0.012, "by about 1.2 % (finite_effect)"),
        (-0.1, "by about -10 % (finite_effect)"),
        (np.inf, "by an amount that is not found (finite_effect: inf)"),
    ],
)
def test_a_change_that_is_not_found_has_no_size(effect, said):
    assert by_about(effect, "finite_effect") == said
