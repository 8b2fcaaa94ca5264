"""A cracked plate at finite deformation: energy, stability, contact, plastic flow, growth."""

from __future__ import annotations

import json

import numpy as np
import pytest
from finite_plate import PLATE, run

from cfmpm import mechanics
from cfmpm.equilibrium import newton, stepping

STEEL = {"E": 1e4, "nu": 0.3, "law": "j2", "yield_stress": 100, "hardening": 200}


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_a_pressed_plate_with_a_closed_crack_buckles_as_one_without(element):
    """After a failed step, contact starts again from the last accepted state.

    The crack reduces the stiffness, as its faces slide and open in bending, by little more
    than its fraction of the width.
    """
    outline = [[0, 0], [50, 0], [50, 80], [0, 80]]
    sound = {"geometry": {"outline": outline}, "family": None, "fracture": {}}
    loads = [{"edge": "edge_3", "displacement": {"y": -12}}]
    loads += [{"edge": "edge_1", "displacement": {"y": 12}}]
    cracked = {"geometry": {"outline": outline, "cracks": [{"points": [[0, 40], [12, 40]]}]}}
    reached = []
    for body in (sound, sound | cracked):
        mesh = {"element": element, "size": 8}
        history = run(PLATE, **body, loads=loads, mesh=mesh, load_steps=[0.1, 1.0]).history
        assert history.attrs["run_status"] == "unstable"
        assert np.isfinite(history.strain_energy).all()
        reached.append(float(history.load_factor[-1]))
    assert (1 - 12.5 / 50) * reached[0] < reached[1] < reached[0]
    # As the plate gives way faces slide by millimetres, and turn; equilibrium is as exact as asked.
    assert (history.min_opening > -newton.RESIDUAL * 12).all()
    assert (history.contact_pairs > 0).all()


def test_accepted_states_are_stable_by_their_eigenvalues():
    """Independent check of the sign of the pivots."""
    for material in (PLATE["material"], {"E": 1e4, "nu": 0.3}, STEEL):
        result = run(PLATE, material=material, load_steps=[0.5])
        problem = mechanics.problem_of(*mechanics.locate(result.body))
        march = newton.March(problem, result.balance.points.internal_variables)
        stiffness = march.factor_at(march.trial(result.displacement))
        lowest = np.linalg.eigvalsh(stiffness.toarray())[0]
        assert lowest > 1e-9 * stiffness.diagonal().max()


def test_work_of_the_loads_is_the_energy():
    found = run(PLATE, load_steps=40).history
    np.testing.assert_allclose(found.external_work, found.strain_energy, rtol=1e-3)
    coarse = run(PLATE, load_steps=10).history
    fine_error = abs(float(found.external_work[-1] / found.strain_energy[-1]) - 1)
    coarse_error = abs(float(coarse.external_work[-1] / coarse.strain_energy[-1]) - 1)
    assert fine_error < coarse_error / 8  # the trapezoidal rule is of second order


@pytest.mark.parametrize("solver", ["superlu", "amg"])
def test_the_end_depends_neither_on_the_steps_nor_on_the_solver(solver):
    once, often = run(PLATE), run(PLATE, load_steps=20, solver=solver)
    assert once.balance.substeps < often.balance.substeps
    np.testing.assert_allclose(once.displacement, often.displacement, atol=1e-8)
    assert float(once.history.J[-1, 0]) == pytest.approx(float(often.history.J[-1, 0]), rel=1e-8)


def test_a_load_that_goes_back_leaves_nothing_behind():
    """Load to tension, zero, compression with closed faces, and zero again."""
    found = run(PLATE, load_steps=[1, 0.5, 0, -1, 0]).history
    straight = run(PLATE, load_steps=[0.5]).history
    assert float(found.J[1, 0]) == pytest.approx(float(straight.J[0, 0]), rel=1e-7)
    for end in (2, 4):
        assert abs(float(found.J[end, 0])) < 1e-12 * float(found.J[0, 0])
        assert float(found.strain_energy[end]) < 1e-12 * float(found.strain_energy[0])
    assert float(found.contact_pairs[3]) > 0
    assert abs(float(found.J[3, 0])) < 1e-6 * float(found.J[0, 0])


def test_pressed_faces_do_not_overlap():
    found = run(PLATE, load_steps=[-0.25, -1.0]).history
    assert (found.min_opening > -1e-8).all()
    assert (found.reaction_y[:, 0] < 0).all()


def test_half_the_load_of_twice_the_density_is_the_same_state():
    """Body force enters the configurational force at the load factor of the state."""
    hung = [
        {"edge": "top", "displacement": {"x": 0, "y": 0}},
        {"body_force": [0.3, -0.5]},
    ]
    double = [hung[0], {"body_force": [0.6, -1.0]}]
    mesh = {"element": "T6", "size": 8, "grading": {"tip_size": 0.5}}
    half = run(PLATE, loads=double, load_steps=[0.5], mesh=mesh).history
    whole = run(PLATE, loads=hung, mesh=mesh).history
    for name in ("J", "cf_norm", "cf_tip_x", "strain_energy"):
        np.testing.assert_allclose(half[name], whole[name], rtol=1e-8)


def test_small_loads_give_the_small_strain_solution():
    """The difference is of the order of the strain."""
    seen = []
    for size in (1e-3, 1e-5):
        loads = [
            {"edge": "top", "displacement": {"y": 40 * size}},
            {"edge": "bottom", "displacement": {"y": -40 * size}},
        ]
        finite, small = (
            run({**PLATE, "loads": loads}, kinematics=kind).history for kind in ("finite", "small")
        )
        seen.append(abs(float(finite.J[0, 0] / small.J[0, 0]) - 1))
        assert finite.K_I.values == pytest.approx(small.K_I.values, rel=10 * size)
        assert float(finite.G[0, 0]) == float(finite.J[0, 0])
    assert 1e-4 < seen[0] < 1e-2
    assert seen[1] < 0.02 * seen[0]


class TestPlasticity:
    def test_work_is_stored_or_spent(self):
        history = run(PLATE, material=STEEL, load_steps=80).history
        whole = history.strain_energy + history.plastic_work
        assert float(history.plastic_work[-1]) > 0.3 * float(whole[-1])
        np.testing.assert_allclose(history.external_work, whole, rtol=3e-3)
        np.testing.assert_allclose(history.external_work[-1], whole[-1], rtol=3e-4)

    def test_a_body_that_has_flowed_keeps_it(self):
        history = run(PLATE, material=STEEL, load_steps=[1.0, 0.0]).history
        assert float(history.plastic_work[1]) >= float(history.plastic_work[0]) > 0
        assert float(history.strain_energy[1]) > 0  # residual stress
        assert np.abs(history.reaction_y[1]).max() > 0

    def test_the_force_of_stored_energy_depends_on_the_domain(self):
        """The part of the plastic work is separate; without flow the domain does not matter."""
        kind = {
            "load_steps": 10,
            "mesh": {"element": "T6", "size": 5, "grading": {"tip_size": 0.5}},
            "fracture": {"radii": [3, 6, 10]},
        }
        history = run(PLATE, material=STEEL, **kind).history
        spread = float(history.J_spread[-1, 0] / history.J[-1, 0])
        assert spread > 0.05
        elastic = run(PLATE, **kind).history
        assert float(elastic.J_spread[-1, 0] / elastic.J[-1, 0]) < 0.1 * spread
        assert float(history.J_plastic[-1, 0]) > 0.1 * float(history.J[-1, 0])
        assert np.isnan(elastic.J_plastic).all()
        assert np.isnan(elastic.plastic_work).all()

    def test_unloading_makes_j_depend_on_the_domain_and_says_so(self):
        kind = {"load_steps": [0.5, 1.0, 0.0], "fracture": {"radii": [3, 6, 10]}}
        elastic = run(PLATE, **kind).history
        assert "depends on the domain" not in elastic.attrs["warnings"]
        history = run(PLATE, material=STEEL, **kind).history
        told = [w for w in json.loads(history.attrs["warnings"]) if "depends on the domain" in w]
        assert len(told) == 1
        assert "in steps 2 to 3 the sum of J and J_plastic differs by up to" in told[0]
        assert told[0].endswith("give larger fracture.radii, or end load_steps before")
        before = {"load_steps": [0.5]}, {"load_steps": [0.5, 1.0], "fracture": {"radii": [8, 10]}}
        for change in before:
            less = run(PLATE, material=STEEL, **kind | change).history
            assert "depends on the domain" not in less.attrs["warnings"]

    def test_below_yield_it_is_hencky(self):
        loads = [
            {"edge": "top", "displacement": {"y": 0.01}},
            {"edge": "bottom", "displacement": {"y": -0.01}},
        ]
        steel, hencky = (
            run({**PLATE, "loads": loads, "mesh": {"size": 8}}, material=material).history
            for material in (STEEL, {"E": 1e4, "nu": 0.3})
        )
        assert float(steel.J[0, 0]) == float(hencky.J[0, 0])
        assert float(steel.plastic_work[0]) == 0.0


GROWING = {
    **PLATE,
    "mesh": {"element": "T3", "size": 4, "grading": "uniform"},
    "material": {"E": 1e4, "nu": 0.3, "g_c": 3.0, "law": "hencky"},
    "loads": [
        {"edge": "top", "displacement": {"y": 0.15}},
        {"edge": "bottom", "displacement": {"y": -0.15}},
    ],
    "growth": {"direction": "cf", "criterion": "cf_norm"},
}


class TestGrowth:
    def test_at_small_load_the_path_is_that_of_small_strain(self):
        finite, small = (run(GROWING, kinematics=kind).history for kind in ("finite", "small"))
        assert finite.sizes["step"] > 3
        assert finite.sizes["step"] == small.sizes["step"]
        np.testing.assert_allclose(finite.tip_x, small.tip_x, atol=0.1)
        np.testing.assert_allclose(finite.tip_y, small.tip_y, atol=0.1)
        assert finite.attrs["run_status"] == "arrived"

    def test_a_grown_body_is_in_the_balance_of_one_solved_afresh(self):
        """Elastic material: the transferred state has no effect on the solution."""
        result = run(GROWING, growth={**GROWING["growth"], "increments": 3})
        body, balance = result.body, result.balance
        problem = mechanics.problem_of(*mechanics.locate(body))
        fresh = stepping.advance(problem, stepping.at_rest(problem), 1.0)
        np.testing.assert_allclose(
            fresh.displacement, balance.displacement, atol=1e-9 * np.abs(balance.displacement).max()
        )

    def test_growth_at_each_load_step(self):
        """No tip grows below its critical load; above it growth is immediate."""
        for kind in ("finite", "small"):
            history = run(GROWING, kinematics=kind, load_steps=5).history
            factor = history.load_factor.values
            assert (np.diff(factor) >= 0).all()
            first = int(np.argmax(history.tip_x.values[:, 0] > 12.0))
            assert first > 1
            assert float(history.cf_norm[first - 1, 0]) >= 3.0
            assert (history.cf_norm[: first - 1, 0] < 3.0).all()
