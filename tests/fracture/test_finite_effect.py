"""Estimates of the effect of finite deformation by sums over points."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import posed
import pytest
from outlines import named_rectangle

from cfmpm import mechanics
from cfmpm.build import build
from cfmpm.equilibrium import newton, small_strain
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.equilibrium.problem import BoundaryValueProblem
from cfmpm.fracture import cf, finite_effect
from cfmpm.fracture.evaluation import evaluate_tips
from cfmpm.scene import scene_from_dict
from cfmpm.scene.families import expand


def plate(law: str = "hencky", nu: float = 0.3, element: str = "T3") -> dict[str, Any]:
    """A plate with an edge crack, held at the bottom and pulled."""
    return {
        "name": "plate",
        "geometry": {
            "outline": named_rectangle(40, 60),
            "cracks": [{"points": [[0, 30], [12, 30]]}],
        },
        "material": {"E": 1e4, "nu": nu, "law": law},
        "loads": [
            {"edge": "bottom", "displacement": {"x": 0, "y": 0}},
            {"edge": "top", "traction": [3, 10]},
        ],
        "mesh": {"element": element, "size": 6},
    }


def solved(**changes: Any) -> tuple[BoundaryValueProblem, Equilibrium]:
    scene = scene_from_dict(plate(**changes))
    problem = mechanics.problem_of(*mechanics.locate(build(scene)))
    return problem, posed.balanced(problem)


@pytest.mark.parametrize("scale", [1.0, 30.0])
@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("nu", [0.3, 0.49])
@pytest.mark.parametrize("law", ["hencky", "neo_hookean", "ciarlet"])
def test_effect_on_the_energy_is_work_of_the_unbalanced_force(
    law: str, nu: float, element: str, scale: float
) -> None:
    problem, balance = solved(law=law, nu=nu, element=element)
    u = scale * balance.displacement
    points, _ = newton.deform(problem, u, np.zeros((len(problem.points), 0)))
    unbalanced = scale * balance.internal_force - newton.internal_force(problem, points)
    energy = scale**2 * (balance.points.energy @ balance.points.volume)
    found, gradient = finite_effect.on_energy(problem, balance, scale)
    assert found == pytest.approx(abs(np.vdot(unbalanced, u)) / (2.0 * energy), rel=1e-9)
    norms = np.linalg.norm(balance.points.displacement_gradient, axis=(1, 2))
    assert 0.5 * norms.min() < gradient < norms.max()


def test_a_state_that_would_turn_points_inside_out_is_extrapolated_from() -> None:
    problem, balance = solved()
    effects = [finite_effect.on_energy(problem, balance, scale)[0] for scale in (1e4, 2e4)]
    assert math.isfinite(effects[0])
    assert effects[1] == pytest.approx(2.0 * effects[0])


def test_a_body_at_rest_has_no_effect() -> None:
    problem, balance = solved()
    nothing = replace(
        balance,
        displacement=np.zeros_like(balance.displacement),
        points=small_strain.deform(problem, np.zeros_like(balance.displacement)),
    )
    assert finite_effect.on_energy(problem, nothing) == (0.0, 0.0)


def test_where_j_may_change() -> None:
    """By the energy or the mean gradient times the slenderness, earlier with faces in contact."""
    body = build(scene_from_dict(plate()))
    _, balance = solved()
    pressed = replace(balance, contact_pairs=1)
    slenderness = (40**2 + 60**2) / (40 * 60)
    for state, gradient in ((balance, finite_effect.FELT), (pressed, finite_effect.FELT_BY_CLOSED)):
        limit = gradient / slenderness
        assert not finite_effect.may_be_felt(body, state, 0.0, 0.99 * limit)
        assert finite_effect.may_be_felt(body, state, 0.0, 1.01 * limit)
        assert not finite_effect.may_be_felt(body, state, 0.99 * finite_effect.FELT_ENERGY, 0.0)
        assert finite_effect.may_be_felt(body, state, 1.01 * finite_effect.FELT_ENERGY, 0.0)


def on_j_of(scene: dict[str, Any]) -> tuple[Any, Equilibrium, Any]:
    """Body, equilibrium at small strain, and the effect on J of a scene."""
    body, gradients = mechanics.locate(build(expand(scene_from_dict(scene))))
    problem = mechanics.problem_of(body, gradients)
    stiffness = small_strain.assemble_stiffness(problem)
    factor = small_strain.factored(problem, stiffness)
    balance = small_strain.solve_linear(problem, stiffness, 1.0, factor)
    nodal = cf.nodal_force(body.grid, balance.points, gradients, np.zeros(2))
    tips = evaluate_tips(body, gradients, balance, nodal)
    return tips, balance, finite_effect.Judged(body, problem, balance, factor).slopes[1:]


def test_a_tip_that_is_pressed_shut_has_no_j_to_compare_with() -> None:
    """J of a bend that closes the crack is an error of contact: below G_floor."""
    larger = []
    for size in (1, 2, 4):
        tips, balance, effect = on_j_of(
            {
                "name": "shut",
                "family": {
                    "kind": "three_point_bend",
                    "length": 100,
                    "height": 20,
                    "span": 80,
                    "crack_length": 4,
                    "force": -100,
                },
                "material": {"E": 1e4, "nu": 0.3},
                "kinematics": "small",
                "mesh": {"element": "T3", "size": size},
            }
        )
        assert balance.contact_pairs
        energy = balance.points.energy @ balance.points.volume
        # The crack is 4 mm long, which is the clearance.
        larger.append(finite_effect.NO_J * energy / 4.0 < tips["J"][0] < tips["G_floor"][0])
        assert np.isnan(effect).all()
    assert any(larger)


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_a_crack_along_the_load_has_no_j_to_compare_with(element: str) -> None:
    """Its J is round-off, of either sign: of several tips some are above zero."""
    pulled = plate(element=element)
    pulled["geometry"]["cracks"] = [{"points": [[x, 20], [x, 40]]} for x in (8, 16, 24, 32)]
    pulled["loads"] = [
        {"edge": "bottom", "traction": [0, -10]},
        {"edge": "top", "traction": [0, 10]},
    ]
    tips, balance, effect = on_j_of(pulled)
    assert not balance.contact_pairs
    assert np.abs(tips["J"]).max() < 1e-12
    assert np.isnan(effect).all()
