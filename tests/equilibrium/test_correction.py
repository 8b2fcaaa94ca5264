"""States of finite deformation by corrections with the stiffness of small strain."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from outlines import named_rectangle

from cfmpm import mechanics
from cfmpm.build import build
from cfmpm.equilibrium import correction, small_strain, stepping
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.equilibrium.problem import BoundaryValueProblem
from cfmpm.errors import SolveError
from cfmpm.linear.solvers import Factor
from cfmpm.scene import scene_from_dict


def solved(
    traction: list[float], cracks: list[Any] | None = None, height: float = 10.0
) -> tuple[BoundaryValueProblem, Equilibrium, Factor]:
    """A beam of 100 mm, held at the left."""
    scene = scene_from_dict(
        {
            "name": "beam",
            "geometry": {
                "outline": named_rectangle(100, height),
                "cracks": [{"points": points} for points in cracks or []],
            },
            "material": {"E": 1e4, "nu": 0.3},
            "loads": [
                {"edge": "left", "displacement": {"x": 0, "y": 0}},
                {"edge": "right", "traction": traction},
            ],
            "mesh": {"element": "T6", "size": 5},
        }
    )
    problem = mechanics.problem_of(*mechanics.locate(build(scene)))
    stiffness = small_strain.assemble_stiffness(problem)
    factor = small_strain.factored(problem, stiffness)
    return problem, small_strain.solve_linear(problem, stiffness, 1.0, factor), factor


@pytest.mark.parametrize(
    ("traction", "cracks", "scale"),
    [
        ([30.0, 0.0], [], 1.0),
        ([0.0, 2.0], [], 1.0),
        ([0.0, 1.0], [], 2.0),
        ([0.0, 2.0], [[[50, 10], [50, 6]]], 1.0),
        ([0.0, -2.0], [[[50, 10], [50, 6]]], 1.0),
    ],
    ids=["pulled", "bent", "scaled", "closed", "open"],
)
def test_the_state_is_that_of_newtons_method(
    traction: list[float], cracks: list[Any], scale: float
) -> None:
    problem, balance, factor = solved(traction, cracks)
    found = correction.settled(problem, balance, factor, scale)
    asked = stepping.from_rest(problem, scale)
    assert found.finite
    assert (found.contact_pairs > 0) == (asked.contact_pairs > 0) == (balance.contact_pairs > 0)
    largest = np.abs(asked.displacement).max()
    apart = np.abs(found.displacement - asked.displacement).max()
    assert apart < 1e-4 * largest
    assert apart < 0.1 * np.abs(scale * balance.displacement - asked.displacement).max()
    energies = (state.points.energy @ state.points.volume for state in (found, asked))
    assert next(energies) == pytest.approx(next(energies), rel=1e-4)


def test_faces_that_small_strain_leaves_open_are_closed() -> None:
    """The held end is split; the beam that is pulled and bent presses one half onto the other."""
    problem, balance, factor = solved([5.0, 0.5], [[[0, 5], [30, 5]]])
    assert balance.contact_pairs == 0
    found = correction.settled(problem, balance, factor, 1.0)
    assert found.contact_pairs == stepping.from_rest(problem, 1.0).contact_pairs > 0


def test_what_is_learned_is_exact() -> None:
    """The change of force along the last correction is given back as that correction."""
    _, balance, factor = solved([0.0, 1.0])
    rng = np.random.default_rng(1)
    n = balance.n_unknowns
    pairs = []
    for _ in range(3):
        moved = rng.normal(size=n)
        resisted = rng.normal(size=n)
        pairs.append((moved, resisted * np.sign(moved @ resisted)))
    tangent = correction.Learning(factor, pairs)
    moved, resisted = pairs[-1]
    np.testing.assert_allclose(tangent.solve(resisted).x, moved, rtol=1e-6, atol=1e-9)
    force = rng.normal(size=n)
    assert correction.Learning(factor).solve(force).x == pytest.approx(factor.solve(force).x)


def test_a_load_above_a_limit_has_no_state() -> None:
    """Hencky's law carries at most E / e."""
    problem, balance, factor = solved([5e3, 0.0])
    with pytest.raises(SolveError, match=r"correction|inverted"):
        correction.settled(problem, balance, factor, 1.0)
