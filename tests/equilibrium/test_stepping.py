"""Load steps at finite deformation, and their end."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import cfmpm
from cfmpm import mechanics
from cfmpm.body.points import MaterialPoints
from cfmpm.equilibrium import newton, stepping
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.errors import SolveError
from cfmpm.linear.engine import NotPositiveDefiniteError
from cfmpm.scene.reading import scene_from_dict

NOTHING = np.zeros((1, 2))
NO_POINTS = MaterialPoints(
    np.zeros((0, 2)), np.zeros(0), np.zeros(0, np.int64), np.zeros(0, np.int64)
).at_rest()
REST = Equilibrium(NO_POINTS, NOTHING, NOTHING, NOTHING, 0, 0.0, 0.0, "", 2, 0, load_factor=0.0)


@dataclass
class Body:
    """A body of one node whose displacement is the load factor, between limits.

    Attributes
    ----------
    first : float
        Length of the first step that converges.
    limits : (float, float)
        Load factors between which it is stable.
    iterations : int
        Newton iterations in each step.
    leap : float
        Largest change of the load factor within the limit on the stretch.
    """

    first: float = 0.3
    limits: tuple[float, float] = (-np.inf, np.inf)
    iterations: int = 3
    leap: float = np.inf

    def __post_init__(self) -> None:
        self.tried: list[float] = []
        self.factored: list[float] = []

    def march(self, problem: Any, internal_variables: Any) -> Body:
        return self

    def trial(self, displacement: Any) -> SimpleNamespace:
        return SimpleNamespace(displacement=displacement, internal_force=NOTHING)

    def factor_at(self, trial: Any) -> None:
        self.factored.append(float(trial.displacement[0, 0]))

    def rate(self, trial: Any) -> Any:
        return np.array([[1.0, 0.0]])

    def first_step(self, rate: Any, total: float) -> float:
        return float(np.copysign(min(self.first, abs(total)), total))

    def apart(self, displacement: Any) -> Any:
        return displacement

    def balance(self, trial: Any, load_factor: float, force_before: Any) -> SimpleNamespace:
        assert trial.displacement[0, 0] == pytest.approx(load_factor)
        self.tried.append(load_factor)
        # It is factored on the way, and left in that state where it fails.
        self.factored.append(load_factor)
        if not self.limits[0] <= load_factor <= self.limits[1]:
            raise NotPositiveDefiniteError("one pivot is negative")
        return SimpleNamespace(trial=trial, residuals=(1.0,) * (self.iterations + 1))

    def check_jump(self, before: Any, after: Any) -> None:
        if np.abs(after.displacement - before.displacement).max() > self.leap:
            raise SolveError("a stretch of a point would jump")

    def accept(self, last: Equilibrium, before: Any, found: Any, load_factor: float) -> Equilibrium:
        return replace(
            last,
            displacement=found.trial.displacement,
            load_factor=load_factor,
            substeps=last.substeps + 1,
        )


def advance(monkeypatch: pytest.MonkeyPatch, body: Body, start: float, end: float) -> Equilibrium:
    monkeypatch.setattr(stepping, "March", body.march)
    last = replace(REST, load_factor=start, displacement=np.array([[start, 0.0]]))
    return stepping.advance(SimpleNamespace(), last, end)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("body", "ends", "tried"),
    [
        # Half as long again after each that was easy; the last one takes the rest with it.
        (Body(first=0.3), (0, 1), [0.3, 0.75, 1.0]),
        (Body(first=0.1), (0, 1), [0.1, 0.25, 0.475, 0.8125, 1.0]),
        (Body(first=0.3, iterations=7), (0, 1), [0.3, 0.6, 0.9, 1.0]),
        (Body(first=0.35, iterations=7), (0, 1), [0.35, 0.7, 1.0]),
        (Body(first=0.3, iterations=6), (0, 1), [0.3, 0.75, 1.0]),
        (Body(first=0.3), (1, 0), [0.7, 0.25, 0.0]),
        (Body(first=0.3), (0.5, -0.5), [0.2, -0.25, -0.5]),
        (Body(first=5.0), (0, 1), [1.0]),
        # A leap is not taken: half of it is, and what is left after that.
        (Body(first=1.0, leap=0.6), (0, 1), [1.0, 0.5, 1.0]),
        (Body(first=0.9, leap=0.6), (0, 1), [1.0, 0.5, 1.0]),
    ],
)
def test_steps(
    monkeypatch: pytest.MonkeyPatch, body: Body, ends: tuple[float, float], tried: list[float]
) -> None:
    body.tried.clear()
    found = advance(monkeypatch, body, *ends)
    np.testing.assert_allclose(body.tried, tried, atol=1e-12)
    assert found.load_factor == ends[1]
    assert found.stopped == ""


@pytest.mark.parametrize("step", [-0.1, 0.0, 1e-7])
def test_steps_that_do_not_lead_to_the_load_factor_end(
    monkeypatch: pytest.MonkeyPatch, step: float
) -> None:
    body = Body(iterations=7)
    monkeypatch.setattr(body, "first_step", lambda rate, total: step)
    with pytest.raises(SolveError, match="load factor 1 is not reached from 0 in 10000 substeps"):
        advance(monkeypatch, body, 0.0, 1.0)
    assert len(body.tried) == stepping.SUBSTEPS


@pytest.mark.parametrize(("sign", "first"), [(1.0, 0.3), (-1.0, 0.3), (1.0, 1.0)])
def test_a_limit_is_found_to_a_thousandth_of_the_first_step(
    monkeypatch: pytest.MonkeyPatch, sign: float, first: float
) -> None:
    body = Body(first=first, limits=(-0.61, 0.61))
    found = advance(monkeypatch, body, 0.0, sign)
    short = 0.61 - abs(found.load_factor)
    assert 0.0 <= short < first * 2.0**-10
    # Halved no more than ten times over, steps that were lengthened in between apart.
    assert min(abs(np.diff([0.0, *body.tried]))) > 0.4 * first * 2.0**-10
    assert found.stopped.startswith(
        f"no stable state was found between load factors {found.load_factor:.6g} and"
    )
    assert "no longer positive definite (one pivot is negative): a limit point" in found.stopped
    # After each failure it goes on from the last state that was accepted.
    for k, at in enumerate(body.factored[:-1]):
        if abs(at) > 0.61:
            assert abs(body.factored[k + 1]) <= 0.61


def test_a_body_that_cannot_begin_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """The message states what was observed; the body may be a mechanism."""
    body = Body(first=1.0, limits=(0.0, 0.0))
    with pytest.raises(SolveError, match=r"between load factors 0 and .*mechanism"):
        advance(monkeypatch, body, 0.0, 1.0)
    np.testing.assert_allclose(body.tried, [0.5**k for k in range(11)])


@pytest.mark.parametrize(("strain", "part"), [(0.2, 0.05), (-0.1, 0.1), (0.02, 0.5), (0.009, 1.0)])
def test_the_first_step_strains_a_body_by_a_hundredth(strain: float, part: float) -> None:
    """Confined: the strain is uniaxial and uniform."""
    scene = {
        "name": "block",
        "geometry": {"outline": [[0, 0], [40, 0], [40, 20], [0, 20]]},
        "material": {"E": 1e3, "nu": 0.3},
        "kinematics": "finite",
        "load_steps": [1e-3],
        "loads": [
            {"edge": "edge_4", "displacement": {"x": 0}},
            {"edge": "edge_2", "displacement": {"x": 40 * strain}},
            {"edge": "edge_1", "displacement": {"y": 0}},
            {"edge": "edge_3", "displacement": {"y": 0}},
        ],
        "mesh": {"element": "T3", "size": 10},
    }
    result = cfmpm.run(scene_from_dict(scene))
    problem = mechanics.problem_of(*mechanics.locate(result.body))
    march = newton.March(problem, result.balance.points.internal_variables)
    at_rest = march.trial(np.zeros_like(result.grid.nodes))
    march.factor_at(at_rest)
    rate = march.rate(at_rest)
    for total in (1.0, -1.0):
        assert march.first_step(rate, total) == pytest.approx(part * total, rel=1e-3)
