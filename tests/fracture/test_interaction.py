"""Interaction integrals under body force do not depend on the domain or the axes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from structured import rectangle

import cfmpm
from cfmpm.body.grid import build_grid
from cfmpm.body.materials import material_table
from cfmpm.body.points import seed
from cfmpm.fracture import cf
from cfmpm.fracture.interaction import IntensityFactors, intensity_factors
from cfmpm.kernels import eshelby
from cfmpm.scene.reading import scene_from_dict

CRACKS = {
    "from the left": [[0, 55], [40, 55]],
    "inclined": [[0, 40], [40, 60]],
    # Its tip is the first point, and looks to the left.
    "from the right": [[55, 50], [100, 70]],
}
# By which the cracks open [N/mm^3]: one component alone, and both.
FORCES = {"along": [0.02, 0.0], "across": [0.0, 0.02], "both": [0.01, 0.03]}


def hung(crack, force):
    """A plate on its bottom edge under a body force; ring quantities at its tip."""
    outline = [{"at": [0, 0], "edge": "bottom"}, [100, 0], [100, 120], [0, 120]]
    scene = {
        "name": "hung",
        "geometry": {"outline": outline, "cracks": [{"points": crack}]},
        "material": {"E": 1000.0, "nu": 0.25},
        "kinematics": "small",
        "loads": [
            {"edge": "bottom", "displacement": {"x": 0, "y": 0}},
            {"body_force": force},
        ],
        "mesh": {"element": "T6", "size": 5, "grading": {"tip_size": 0.05, "growth": 0.2}},
        "fracture": {"radii": [4, 12, 30]},
    }
    return cfmpm.run(scene_from_dict(scene)).history.isel(step=0, tip=0)


@pytest.mark.parametrize("force", FORCES)
@pytest.mark.parametrize("crack", CRACKS)
def test_factors_under_body_force_are_those_of_any_domain(crack, force):
    """Mixed mode, cracks in several directions."""
    x, y = FORCES[force]
    history = hung(CRACKS[crack], [-x if crack == "from the right" else x, y])
    assert float(history.contact_pairs) == 0
    k_1, k_2 = float(history.K_I), float(history.K_II)
    scale = np.hypot(k_1, k_2)
    assert min(abs(k_1), abs(k_2)) > 0.03 * scale
    # What is left is the error of the stress and of the quadrature.
    for name in ("K_I", "K_II"):
        np.testing.assert_allclose(
            history[f"{name}_radius"], history[name], rtol=0, atol=1e-5 * scale
        )
    np.testing.assert_allclose(history.T_stress_radius, history.T_stress, rtol=0, atol=1e-3)
    np.testing.assert_allclose(history.J_radius, history.J, rtol=1e-5)
    np.testing.assert_allclose(history.G_radius, history.J, rtol=3e-4)


@pytest.mark.parametrize("density", [(0.3, 0.0), (0.0, -0.7), (0.3, -0.7)])
@pytest.mark.parametrize("element", ["T3", "T6"])
def test_body_force_enters_by_its_work_on_the_auxiliary_fields(element, density):
    """- int b_i a_i,1 q dA, point by point, in the frame of the tip."""
    grid = build_grid(rectangle(10, 10, 10.0, 10.0, shake=0.3, crack=(5, 0, 5)), element)
    (tip,) = grid.tips
    angle = 0.7
    t = np.array([np.cos(angle), np.sin(angle)])
    tip = replace(tip, tangent=t)
    points = seed(grid).at_rest()
    q = cf.ring_weight(grid, tip, 4.0)
    away = points.position - grid.nodes[tip.node]
    frame = np.array([t, [-t[1], t[0]]])
    along, across = frame @ away.T
    r, theta = np.hypot(along, across), np.arctan2(across, along)
    lam, mu = 1.3, 0.9
    integrals = [
        eshelby.interaction_integrals(
            grid.nodes,
            grid.elements,
            points.element,
            points.position,
            grid.basis_gradients(points.element, points.position),
            points.volume,
            points.displacement_gradient,
            points.stress,
            q,
            r,
            theta,
            t,
            lam,
            mu,
            np.array(force),
            0.0,
        )
        for force in (density, (0.0, 0.0))
    ]
    # Middle nodes have the mean of their ends: linear in each triangle.
    values = grid.basis_values(points.element, points.position)
    q_here = np.einsum("pk,pk->p", values, q[grid.elements[points.element]])
    assert 0.0 < q_here[(q_here > 0.0) & (q_here < 1.0)].sum() < q_here.sum()
    b = frame @ density
    expected = np.zeros(3)
    for mode in range(3):
        for p in np.flatnonzero(q_here > 0.0):
            a11, _, a21, _ = eshelby.auxiliary_gradient(mode, r[p], theta[p], lam, mu)
            expected[mode] -= points.volume[p] * q_here[p] * (b[0] * a11 + b[1] * a21)
    assert not integrals[1].any()
    np.testing.assert_allclose(integrals[0], expected, rtol=1e-12)


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_a_rotation_of_the_body_has_no_factors(element):
    """In slender bodies it is much larger than the strain and must not enter by quadrature."""
    grid = build_grid(rectangle(10, 10, 10.0, 10.0, shake=0.3, crack=(5, 0, 5)), element)
    (tip,) = grid.tips
    points = seed(grid)
    rotation = np.tile([[0.0, -0.1], [0.1, 0.0]], (len(points), 1, 1))
    points = points.deformed(rotation, np.zeros((len(points), 3)), np.zeros(len(points)))
    material = material_table([{"E": 1000.0, "nu": 0.25}], "strain")
    gradients = grid.basis_gradients(points.element, points.position)
    for angle in (0.0, 1.9):
        turned = replace(tip, tangent=np.array([np.cos(angle), np.sin(angle)]))
        q = cf.ring_weight(grid, turned, 4.0)
        found = intensity_factors(grid, points, gradients, material, turned, q, np.zeros(2))
        # Of 100 N/mm^2 that it would be taken for.
        assert abs(found.K_I) + abs(found.K_II) + abs(found.T_stress) < 1e-10


@pytest.mark.parametrize(
    ("k_2", "j", "kept"),
    [
        (0.5, 0.25, True),
        (0.5, 0.35, True),
        (0.5, 0.8, False),
        (0.5, -0.1, False),
    ],
)
@pytest.mark.parametrize("pressure", [0.0, 1.0])
def test_a_faint_factor_needs_j_to_confirm_it(k_2, j, kept, pressure):
    """With E' = 1."""
    found = IntensityFactors(0.0, k_2, 0.0, k_2**2, pressure=pressure, faint=True)
    told = found.confirmed(j)
    assert (told == found) is kept
    if not kept:
        assert (told.K_II, told.G) == (0.0, 0.0)


def test_noise_is_none_of_a_closed_tip_whatever_j_is():
    found = IntensityFactors(0.0, 0.5, 0.0, 0.25, pressure=1.0, faint=True, noise=True)
    assert found.confirmed(0.25).K_II == 0.0
    opened = replace(found, pressure=0.0)
    assert opened.confirmed(0.25) == opened


@pytest.mark.parametrize("pressure", [0.0, 1.0])
def test_what_is_not_faint_is_not_doubted(pressure):
    found = IntensityFactors(0.5, 0.0, 0.0, 0.25, pressure=pressure)
    assert found.confirmed(100.0) == found
