"""Contact at finite deformation: openings, forces and stiffness of rotated crack faces."""

from __future__ import annotations

import numpy as np
import pytest
from cracked_beams import BEAMS, MATERIAL, bent_beam
from scipy.sparse import csr_array, eye_array

from cfmpm import build
from cfmpm.body.loads import Loading, NodalLoads
from cfmpm.equilibrium import contact
from cfmpm.errors import SolveError
from cfmpm.linear import solvers
from cfmpm.scene import expand
from cfmpm.scene.reading import scene_from_dict


class TestTurnedFaces:
    """Two cracks in T6 grids at large displacement: sliding, open, rotated."""

    @pytest.fixture
    def faces(self):
        scene = bent_beam("T6", BEAMS["two"])
        full = expand(scene_from_dict({"name": "contact", "material": MATERIAL, **scene}))
        self.grid = build.build(full).grid
        self.free = np.zeros((len(self.grid.nodes), 2), bool)
        self.loading = Loading(self.free, NodalLoads.none(len(self.grid.nodes)), {})
        x, y = (self.grid.nodes / np.abs(self.grid.nodes).max()).T
        turned = self.grid.nodes @ np.array([[0.6, 0.8], [-0.8, 0.6]]) - self.grid.nodes
        bent = np.column_stack([x * y, y**2 - 0.5 * x**2])
        self.shape = turned + 0.3 * bent + np.random.default_rng(0).normal(0, 0.02, (len(x), 2))
        return self.at(self.shape)

    def at(self, shape):
        return contact.CrackFaces(self.grid).turned(self.loading, shape)

    def slopes(self, quantity, direction, step=1e-5):
        """Central difference."""
        ahead, behind = (quantity(self.at(self.shape + k * step * direction)) for k in (1, -1))
        return (ahead - behind) / (2 * step)

    def directions(self):
        rng = np.random.default_rng(1)
        return [rng.normal(size=self.shape.shape) for _ in range(3)]

    def test_forces_are_the_derivative_of_the_openings(self, faces):
        for v in self.directions():
            exact = faces.push.T @ v.ravel()
            found = self.slopes(lambda f: f.opening, v)
            np.testing.assert_allclose(exact, found, rtol=0, atol=1e-7 * np.abs(exact).max())

    def test_a_rigid_motion_changes_nothing(self, faces):
        """No opening; contact forces have no resultant and no moment."""
        turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
        at = self.grid.nodes + self.shape
        moved = at @ np.array([[-0.28, 0.96], [-0.96, -0.28]]) + [3.0, -7.0] - self.grid.nodes
        np.testing.assert_allclose(self.at(moved).opening, faces.opening, rtol=0, atol=1e-11)
        force = faces.force(np.random.default_rng(2).random(len(faces.opening)))
        assert np.abs(force.sum(axis=0)).max() < 1e-12 * np.abs(force).sum()
        assert abs(np.sum(force * (at @ turn))) < 1e-12 * np.sum(np.abs(force) * np.abs(at))

    def test_stiffness_is_the_derivative_of_the_forces(self, faces):
        pressed = np.random.default_rng(2).random(len(faces.opening))
        K = 1e3 * eye_array(self.shape.size).tocsr()
        factor = solvers.select(K.shape[0], "superlu").factor(csr_array(K))
        stiffness = contact.TurningStiffness(factor, faces, self.free, pressed)
        for v in self.directions():
            force = K @ v.ravel() - self.slopes(lambda f: f.push @ pressed, v)
            found = stiffness.solve(force).x
            np.testing.assert_allclose(found, v.ravel(), rtol=0, atol=1e-8)

    def test_faces_that_slide_away_are_no_stable_state(self, faces):
        K = eye_array(self.shape.size).tocsr()
        factor = solvers.select(K.shape[0], "superlu").factor(csr_array(K))
        pressed = np.full(len(faces.opening), 1e3)
        with pytest.raises(SolveError, match="closed crack faces slide off"):
            contact.TurningStiffness(factor, faces, self.free, pressed)

    def test_at_rest_they_are_those_of_small_strain(self, faces):
        turned = self.at(np.zeros_like(self.shape))
        rest = contact.CrackFaces(self.grid).at_rest(self.loading)
        np.testing.assert_allclose(turned.push.toarray(), rest.push.toarray(), atol=1e-15)
        assert not turned.opening.any()
