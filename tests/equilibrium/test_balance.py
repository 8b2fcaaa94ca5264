"""Criterion of equilibrium: the residual and its round-off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csr_array

import cfmpm
from cfmpm.equilibrium import newton, small_strain
from cfmpm.equilibrium.balance import RESIDUAL_AT_FLOOR, round_off
from cfmpm.errors import SolveError
from cfmpm.linear import solvers
from cfmpm.scene.reading import scene_from_dict

PLATE = {
    "name": "plate",
    "family": {
        "kind": "single_edge",
        "width": 50,
        "height": 80,
        "crack_length": 12,
        "traction": 10,
    },
    "material": {"E": 1e4, "nu": 0.3},
    "mesh": {"element": "T3", "size": 8},
}

PULLED = {"kinematics": "finite", "family": {**PLATE["family"], "traction": 500}}


def solve(**changes):
    return cfmpm.run(scene_from_dict(PLATE | changes))


@pytest.fixture
def inexact(monkeypatch):
    """Give the linear solver a relative error."""

    def miss(error):
        exact = solvers.Factor.solve

        def solve(self, b):
            found = exact(self, b)
            noise = np.random.default_rng(0).uniform(-1, 1, len(found.x))
            return replace(found, x=found.x + error * np.abs(found.x).max() * noise)

        monkeypatch.setattr(solvers.Factor, "solve", solve)

    return miss


class TestLinear:
    def test_a_solver_that_misses_is_not_believed(self, inexact):
        inexact(1e-7)
        with pytest.raises(
            SolveError, match=r"the unbalanced force of the linear solution .*e-0[67]"
        ):
            solve(kinematics="small")

    def test_what_round_off_explains_is_accepted_up_to_a_limit(self, inexact, monkeypatch):
        monkeypatch.setattr(small_strain, "round_off", lambda *_: 0.5)
        inexact(1e-6)
        history = solve(kinematics="small").history
        assert 1e-7 < float(history.residual_norm[0]) < 1e-4
        assert "round-off" in history.attrs["warnings"]
        inexact(1e-3)
        with pytest.raises(SolveError, match=r"round-off 5\.0e-01"):
            solve(kinematics="small")

    def test_a_rigid_motion_is_in_balance(self):
        """The final forces are zero: round-off scales with the forces of the iterations."""
        loads = [{"edge": "bottom", "displacement": {"x": 3.0, "y": -2.0}}]
        family = {name: value for name, value in PLATE["family"].items() if name != "traction"}
        result = solve(kinematics="small", family=family, loads=loads)
        error = 3.0 * small_strain.RESIDUAL
        np.testing.assert_allclose(result.displacement - [3.0, -2.0], 0.0, atol=error)
        assert float(result.history.residual_norm[0]) < small_strain.RESIDUAL

    def test_round_off_is_that_of_how_far_a_part_moved_on_the_way(self, monkeypatch):
        """Faces overlap before contact closes: the larger of both displacements counts."""
        asked = []
        monkeypatch.setattr(small_strain, "RESIDUAL", -1.0)
        monkeypatch.setattr(small_strain, "round_off", lambda K, moved, _: asked.append(moved) or 1)
        close = small_strain.close_faces

        def far(faces, prescribed, displacement, factor):
            asked.append(displacement[~prescribed])
            return close(faces, prescribed, displacement, factor)

        monkeypatch.setattr(small_strain, "close_faces", far)
        result = solve(kinematics="small", family={**PLATE["family"], "traction": -10})
        assert int(result.history.contact_pairs[0]) > 0
        before, moved = asked
        after = result.displacement[~result.loading.prescribed]
        assert (np.abs(before) > np.abs(after)).any()
        assert (np.abs(after) > np.abs(before)).any()
        np.testing.assert_allclose(moved, np.maximum(np.abs(before), np.abs(after)), rtol=1e-12)


def test_round_off_is_that_of_the_largest_row():
    """32 eps |K| |u| relative to the force, in spite of cancellation in K u."""
    K = csr_array(np.array([[4.0, -2.0, 0.0], [-2.0, 1e6, -3.0], [0.0, -3.0, 5.0]]))
    u = np.array([1.0, 2e-3, -7.0])
    floor = round_off(K, u, 10.0)
    assert floor == pytest.approx(32 * 2.220446049250313e-16 * (2 + 2e3 + 21) / 10.0, rel=1e-12)
    assert round_off(K, -3.0 * u, 30.0) == pytest.approx(floor, rel=1e-12)


class TestFinite:
    def test_balance_is_as_exact_as_asked(self):
        """One Newton iteration fewer would not meet the tolerance."""
        balance = solve(**PULLED).balance
        assert balance.residuals[-1] <= newton.RESIDUAL == 1e-9
        assert balance.residuals[-2] > newton.RESIDUAL
        assert balance.residual_norm == balance.residuals[-1]

    def test_what_round_off_explains_is_accepted_up_to_a_limit(self, monkeypatch):
        monkeypatch.setattr(newton, "round_off", lambda *_: 0.5)
        balance = solve(**PULLED).balance
        assert 1e-9 < balance.residual_norm <= RESIDUAL_AT_FLOOR == 1e-3
        assert balance.residual_floor == 0.5
        assert balance.residuals[-2] > 1e-3

    def test_a_contrast_of_stiffness_is_solved_to_its_round_off(self):
        """With a hard inclusion the residual is above the tolerance, not above round-off."""
        hard = {"circle": {"centre": [30, 40], "radius": 6}, "material": {"E": 1e12, "nu": 0.3}}
        changes = {
            "family": None,
            "kinematics": "finite",
            "geometry": {
                "outline": [[0, 0], [50, 0], [50, 80], [0, 80]],
                "regions": [{"name": "hard", **hard}],
            },
            "loads": [
                {"edge": "edge_1", "traction": [0, -500]},
                {"edge": "edge_3", "traction": [0, 500]},
            ],
        }
        balance = solve(**changes).balance
        assert newton.RESIDUAL < balance.residual_norm <= balance.residual_floor < 1e-3
