"""Williams' crack tip field with known K_I, K_II and T, imposed on a body, is recovered."""

from __future__ import annotations

import numpy as np
import pytest

from cfmpm.body.tip_domains import choose_domains
from cfmpm.fracture import cf
from cfmpm.fracture.criteria.max_hoop import max_hoop_angle
from cfmpm.fracture.interaction import intensity_factors

E, NU = 210e3, 0.3
CENTRE = np.array([50.0, 50.0])
MOUTHS = {
    "left": [0.0, 42.0],
    "right": [100.0, 63.0],
    "bottom": [55.0, 0.0],
    "top": [31.0, 100.0],
    "left level": [0.0, 50.0],
}


def williams(x, side, tangent, k_1, k_2, t, plane="strain"):
    """Displacement of the first terms of Williams' series (Anderson 2005, table 2.2), (k, 2).

    Independent of the kernels: polar angle from complex numbers, displacement instead
    of its gradient, T-stress by Hooke's law.
    """
    mu = E / (2 * (1 + NU))
    kappa = 3 - 4 * NU if plane == "strain" else (3 - NU) / (1 + NU)
    turn = tangent[0] - 1j * tangent[1]
    z = (x - CENTRE) @ [1, 1j] * turn
    lean = ((side - CENTRE) @ [1, 1j] * turn).imag
    theta = np.angle(z)
    on_crack = np.abs(np.abs(theta) - np.pi) < 1e-9
    theta = np.where(on_crack, np.pi * np.sign(lean), theta)
    root = np.sqrt(np.abs(z) / (2 * np.pi)) / (2 * mu)
    c, s, cos = np.cos(theta / 2), np.sin(theta / 2), np.cos(theta)
    u = root * (k_1 * c * (kappa - cos) + k_2 * s * (kappa + 2 + cos))
    v = root * (k_1 * s * (kappa - cos) - k_2 * c * (kappa - 2 + cos))
    modulus = E / (1 - NU**2) if plane == "strain" else E
    ratio = NU / (1 - NU) if plane == "strain" else NU
    u = u + t / modulus * z.real
    v = v - ratio * t / modulus * z.imag
    turned = (u + 1j * v) / turn
    return np.column_stack([turned.real, turned.imag])


def body(mouth, plane="strain", element="T6"):
    return {
        "geometry": {
            "outline": [[0, 0], [100, 0], [100, 100], [0, 100]],
            "cracks": [{"points": [mouth, CENTRE.tolist()]}],
        },
        "material": {"E": E, "nu": NU},
        "plane": plane,
        "loads": [{"edge": "edge_1", "traction": [0, 0]}],
        "mesh": {"element": element, "size": 8, "grading": {"tip_size": 0.05, "growth": 0.2}},
    }


@pytest.mark.parametrize("mouth", MOUTHS)
@pytest.mark.parametrize(
    "factors",
    [(100, 0, 0), (0, 100, 0), (100, 60, -8), (70, -90, 5), (0, -100, 6)],
    ids=str,
)
def test_factors_are_recovered_on_every_side(solve_prescribed, mouth, factors):
    mouth = MOUTHS[mouth]
    tangent = (CENTRE - mouth) / np.linalg.norm(CENTRE - mouth)
    solved = solve_prescribed(body(mouth), lambda x, side: williams(x, side, tangent, *factors))
    (tip,) = solved.grid.tips
    np.testing.assert_allclose(tip.tangent, tangent, atol=1e-9)
    scale = np.hypot(factors[0], factors[1])
    g = scale**2 * (1 - NU**2) / E
    for radius in choose_domains(solved.grid, tip, 3).radii:
        q = cf.ring_weight(solved.grid, tip, radius)
        k = intensity_factors(
            solved.grid, solved.points, solved.gradients, solved.materials, tip, q, np.zeros(2)
        )
        assert pytest.approx(factors[0], abs=3e-4 * scale) == k.K_I
        assert pytest.approx(factors[1], abs=3e-4 * scale) == k.K_II
        # The singular stress on the ring is what T has to be told from.
        singular = scale / np.sqrt(2 * np.pi * radius / 2)
        assert k.T_stress == pytest.approx(factors[2], abs=3e-4 * singular)
        assert pytest.approx(g, rel=7e-4) == k.G
        assert cf.j_integral(solved.nodal, np.outer(q, tip.tangent)) == pytest.approx(g, rel=7e-4)
        assert max_hoop_angle(k.K_I, k.K_II) == pytest.approx(
            max_hoop_angle(*factors[:2]), abs=2e-3
        )


def test_plane_stress(solve_prescribed):
    mouth = [0.0, 42.0]
    tangent = (CENTRE - mouth) / np.linalg.norm(CENTRE - mouth)
    solved = solve_prescribed(
        body(mouth, "stress"),
        lambda x, side: williams(x, side, tangent, 100, -60, 4, "stress"),
    )
    (tip,) = solved.grid.tips
    q = cf.ring_weight(solved.grid, tip, 30.0)
    k = intensity_factors(
        solved.grid, solved.points, solved.gradients, solved.materials, tip, q, np.zeros(2)
    )
    np.testing.assert_allclose([k.K_I, k.K_II], [100, -60], rtol=4e-4)
    assert k.T_stress == pytest.approx(4, abs=3e-3)
    assert pytest.approx((100**2 + 60**2) / E, rel=7e-4) == k.G


def test_configurational_force_turns_with_the_second_mode(solve_prescribed):
    """J_1 = (K_I^2 + K_II^2) / E', J_2 = -2 K_I K_II / E' (Budiansky and Rice 1973)."""
    mouth = MOUTHS["left level"]
    for k_2 in (30.0, -30.0):
        solved = solve_prescribed(
            body(mouth), lambda x, side, k_2=k_2: williams(x, side, np.array([1.0, 0]), 100, k_2, 0)
        )
        (tip,) = solved.grid.tips
        force = cf.domain_force(solved.grid, solved.nodal, tip, 2.0)
        expected = np.array([100**2 + k_2**2, -2 * 100 * k_2]) * (1 - NU**2) / E
        np.testing.assert_allclose(force, expected, rtol=6e-4)
        assert cf.angle(force, tip) == pytest.approx(
            np.degrees(np.arctan2(expected[1], expected[0])), abs=0.01
        )


def test_uniform_stress_along_the_crack_has_no_intensity(solve_prescribed):
    tangent = np.array([1.0, 0.0])
    solved = solve_prescribed(
        body(MOUTHS["left level"]), lambda x, side: williams(x, side, tangent, 0, 0, 7.0)
    )
    (tip,) = solved.grid.tips
    q = cf.ring_weight(solved.grid, tip, 20.0)
    k = intensity_factors(
        solved.grid, solved.points, solved.gradients, solved.materials, tip, q, np.zeros(2)
    )
    # Exact in T6: what is left is the quadrature of the auxiliary field.
    assert k.T_stress == pytest.approx(7.0, rel=2e-6)
    assert abs(k.K_I) + abs(k.K_II) < 3e-6 * 7.0 * np.sqrt(20.0)
    assert abs(cf.j_integral(solved.nodal, np.outer(q, tip.tangent))) < 1e-15
