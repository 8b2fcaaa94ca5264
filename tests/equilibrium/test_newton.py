"""Newton's method at finite deformation: its steps, their limits, the states it takes."""

from __future__ import annotations

import numpy as np
import pytest
from finite_plate import PLATE, run

from cfmpm import mechanics
from cfmpm.equilibrium import newton
from cfmpm.errors import SolveError

BLOCK = {
    "name": "block",
    "geometry": {"outline": [[0, 0], [40, 0], [40, 20], [0, 20]]},
    "material": {"E": 1e3, "nu": 0.3},
    "kinematics": "finite",
    "loads": [
        {"edge": "edge_4", "displacement": {"x": 0}},
        {"point": [0, 0], "displacement": {"y": 0}},
        {"name": "pull", "edge": "edge_2", "traction": [1, 0]},
    ],
    "mesh": {"element": "T3", "size": 10},
}


def pulled(stress, **changes):
    loads = [*BLOCK["loads"][:2], {**BLOCK["loads"][2], "traction": [stress, 0]}]
    return run({**BLOCK, "loads": loads}, **changes)


def test_newton_is_quadratic():
    """One step of ten per cent from the undeformed state."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(newton, "FIRST_STRAIN", 1.0)
        patch.setattr(newton, "STRETCH_JUMP", 10.0)
        mesh = {**PLATE["mesh"], "grading": {"tip_size": 0.08, "growth": 0.3}}
        result = run(PLATE, mesh=mesh)
    assert result.balance.substeps == 1
    seen = np.array(result.balance.residuals)
    assert result.balance.newton_iterations == len(seen) - 1
    # Above round-off the logarithm of each residual is twice that of the one before, and more.
    above = np.flatnonzero(seen[1:] > 1e-12)
    assert len(above) >= 2
    constant = seen[1:][above] / seen[:-1][above] ** 2
    assert constant.max() <= 10.0


@pytest.mark.parametrize("law", ["hencky", "neo_hookean", "ciarlet"])
def test_uniform_stretch_is_that_of_the_law(law):
    """Block with free sides: the nominal stress is dW/dl, the lateral stress is zero."""
    result = pulled(300.0, material={"E": 1e3, "nu": 0.3, "law": law})
    F = result.points.displacement_gradient + np.eye(2)
    assert np.ptp(F, axis=0).max() < 1e-12
    length, width = F[0, 0, 0], F[0, 1, 1]
    lam, mu = 1e3 * 0.3 / (1.3 * 0.4), 1e3 / 2.6

    def energy(a, b):
        j = np.log(a * b)
        if law == "hencky":
            return 0.5 * lam * j**2 + mu * (np.log(a) ** 2 + np.log(b) ** 2)
        volume = (
            0.5 * lam * j**2 if law == "neo_hookean" else 0.25 * lam * ((a * b) ** 2 - 1 - 2 * j)
        )
        return 0.5 * mu * (a * a + b * b - 2 - 2 * j) + volume

    h = 1e-5
    along = (energy(length + h, width) - energy(length - h, width)) / (2 * h)
    across = (energy(length, width + h) - energy(length, width - h)) / (2 * h)
    assert along == pytest.approx(300.0, rel=1e-7)
    assert abs(across) < 1e-4
    assert float(result.history.strain_energy[-1]) == pytest.approx(800 * energy(length, width))


def test_work_of_dead_loads_is_the_energy_to_second_order_of_the_steps():
    """Work by the trapezoidal rule from force and displacement at both ends of each step."""
    material = {"E": 1e3, "nu": 0.3, "law": "ciarlet"}
    errors = []
    for steps in (8, 16):
        found = pulled(60.0, material=material, load_steps=steps).history.isel(step=-1)
        assert int(found.substeps) == steps
        errors.append(float(found.external_work / found.strain_energy) - 1)
    assert 1e-6 < abs(errors[0]) < 1e-3
    assert errors[1] == pytest.approx(errors[0] / 4, rel=0.1)


def test_a_point_turned_inside_out_is_no_state():
    """A point with det F < 0 is refused even if its law gives a stress."""
    result = pulled(100.0)
    grid, points = result.grid, result.body.integration
    problem = mechanics.problem_of(*mechanics.locate(result.body))
    march = newton.March(problem, result.balance.points.internal_variables)
    for mirrored in ([-1.5, 1.0], [1.0, -1.5], [-1.0, 1.0]):
        moved = grid.nodes * mirrored - grid.nodes
        with pytest.raises(SolveError, match=f"{len(points)} material points would be inverted"):
            march.trial(moved)
    # A half turn is none.
    assert march.trial(-2.0 * grid.nodes).points.energy == pytest.approx(0.0, abs=1e-20)


class TestLimitPoint:
    """Hencky elasticity carries no dead load above E'/e (nominal, plane strain)."""

    LIMIT = 1e3 / (1 - 0.3**2) / np.e

    def test_below_it_there_is_a_state(self):
        assert pulled(0.99 * self.LIMIT).history.attrs["run_status"] == "solved"

    def test_beyond_it_the_last_stable_state_is_kept(self):
        history = pulled(1.2 * self.LIMIT, load_steps=4).history
        assert history.attrs["run_status"] == "unstable"
        reached = 1.2 * float(history.load_factor[-1])
        assert 0.999 < reached < 1.0
        assert np.isfinite(history.strain_energy).all()

    def test_a_stretch_that_would_jump_is_not_taken(self):
        """The neo-Hookean law can carry the load, but not in one step."""
        result = pulled(500.0, material={"E": 1e3, "nu": 0.3, "law": "ciarlet"})
        assert result.history.attrs["run_status"] == "solved"
        assert result.balance.substeps >= 2

    @pytest.mark.parametrize(
        ("length", "substeps"),
        [(1.48, 1), (1.52, 2), (1 / 1.48, 1), (1 / 1.52, 2)],
        ids=["pulled", "pulled too far", "pressed", "pressed too far"],
    )
    def test_no_step_stretches_or_presses_a_point_by_more_than_half(self, length, substeps):
        """Displacement on the whole boundary: only the limit on the stretch limits the steps."""
        loads = [
            {"edge": "edge_4", "displacement": {"x": 0}},
            {"edge": "edge_2", "displacement": {"x": 40 * (length - 1)}},
            {"edge": "edge_1", "displacement": {"y": 0}},
            {"edge": "edge_3", "displacement": {"y": 0}},
        ]
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(newton, "FIRST_STRAIN", 10.0)
            result = run(BLOCK, loads=loads, material={"E": 1e3, "nu": 0.3, "law": "ciarlet"})
        assert result.balance.substeps == substeps
        F = result.points.displacement_gradient + np.eye(2)
        # What Newton's method may leave unbalanced, over the modulus, with room.
        error = 10 * newton.RESIDUAL
        np.testing.assert_allclose(F, [np.diag([length, 1.0])] * len(F), rtol=0, atol=error)

    def test_ellipticity_lost_is_counted_and_said(self):
        """Equibiaxial, Hencky loses it near a stretch of 2 (design study)."""
        pull = [
            {"edge": "edge_4", "displacement": {"x": 0}},
            {"edge": "edge_2", "displacement": {"x": 60}},
            {"edge": "edge_1", "displacement": {"y": 0}},
            {"edge": "edge_3", "displacement": {"y": 30}},
        ]
        history = run(BLOCK, loads=pull, load_steps=[0.5, 1.0]).history
        assert list(history.unstable_points.values > 0) == [False, True]
        assert "ellipticity" in history.attrs["warnings"]
        kept = run(BLOCK, loads=pull, material={"E": 1e3, "nu": 0.3, "law": "ciarlet"}).history
        assert float(kept.unstable_points[-1]) == 0


@pytest.mark.parametrize(("traction", "leans"), [(200.0, False), (-200.0, True)])
def test_what_holds_a_rotation_carries_nothing_where_loads_hold_it(traction, leans):
    """A body under dead tractions only, with bending due to the edge crack."""
    family = {**PLATE["family"], "crack_height": 25, "traction": traction}
    result = run(PLATE, family=family, loads=[])
    force = (
        result.balance.internal_force
        - result.loading.proportional.force
        - result.balance.contact_force
    )
    carried = np.abs(force[result.loading.prescribed]).max()
    assert (carried > 1e-6 * np.abs(result.balance.internal_force).max()) == leans
    assert ("with a reaction moment" in result.history.attrs["warnings"]) == leans


def test_a_block_pressed_to_nothing_ends_in_its_last_state():
    history = run(
        BLOCK,
        loads=[
            {"edge": "edge_4", "displacement": {"x": 0}},
            {"edge": "edge_2", "displacement": {"x": -60}},
            {"edge": "edge_1", "displacement": {"y": 0}},
            {"edge": "edge_3", "displacement": {"y": 0}},
        ],
        material={"E": 1e3, "nu": 0.3, "law": "ciarlet"},
    ).history
    assert history.attrs["run_status"] == "unstable"
    assert 0.5 < float(history.load_factor[-1]) < 40 / 60
    assert np.isfinite(history.strain_energy).all()


def test_the_first_loss_of_ellipticity_is_dated():
    """Also in the first step."""
    ideal = {"E": 1e4, "nu": 0.3, "law": "j2", "yield_stress": 10.0}
    balance = run(PLATE, material=ideal, load_steps=[0.02]).balance
    assert balance.unstable_points > 0
    assert 0 < balance.unstable_from <= 0.02
    later = run(PLATE, material=ideal, load_steps=[0.02, 0.04]).balance
    assert later.unstable_points > 0
    assert later.unstable_from == balance.unstable_from
