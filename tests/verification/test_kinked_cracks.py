"""Kinked cracks, open and closed, against the theory of kinks; growing wing cracks."""

from __future__ import annotations

import numpy as np
import pytest

import cfmpm
from cfmpm.fracture.criteria.kinked_factors import kinked_factors
from cfmpm.output.analysis import parts_of_gap
from cfmpm.scene import scene_from_dict

C = 20.0  # half length [mm]


def kinked(traction, kink, wing, *, T3=False):
    """A crack at 45 degrees in a wide plate, with equal wings at both ends."""
    along = np.array([1.0, 1.0]) / np.sqrt(2)
    turned = np.pi / 4 + np.radians(kink)
    ahead = wing * np.array([np.cos(turned), np.sin(turned)])
    points = [-C * along - ahead, -C * along, C * along, C * along + ahead]
    side = 20 * C
    return scene_from_dict(
        {
            "name": "kinked",
            "geometry": {
                "outline": [
                    {"at": [-side, -side], "edge": "bottom"},
                    {"at": [side, -side], "edge": "right"},
                    {"at": [side, side], "edge": "top"},
                    {"at": [-side, side], "edge": "left"},
                ],
                "cracks": [{"points": [point.tolist() for point in points]}],
            },
            "material": {"E": 70e3, "nu": 0.33, "g_c": 1e9},
            "loads": [
                {"edge": "bottom", "traction": [0, -traction]},
                {"edge": "top", "traction": [0, traction]},
            ],
            "mesh": {
                "element": "T3" if T3 else "T6",
                "size": 60,
                "grading": {"tip_size": wing / 25, "growth": 0.1 if T3 else 0.2},
            },
            # Inside the wing, and far beyond the kink.
            "fracture": {"radii": [0.8 * wing, 2 * wing, 5 * wing]},
            "growth": {"control": "load"},
        }
    )


@pytest.mark.parametrize(("traction", "kink"), [(10, -30.0), (10, -53.0), (-10, 70.5)])
def test_a_ring_may_hold_the_kink(traction, kink):
    """K and T are equal for rings of 0.8 and of 5 times the wing length."""
    history = cfmpm.run(kinked(traction, kink, 1.0)).history
    found = {name: history[f"{name}_radius"].values[0] for name in ("K_I", "K_II", "T_stress")}
    np.testing.assert_allclose(found["K_I"], found["K_I"][:, :1] * np.ones(3), rtol=3e-4)
    np.testing.assert_allclose(
        found["K_II"], found["K_II"][:, :1] * np.ones(3), atol=5e-4 * found["K_I"].max()
    )
    np.testing.assert_allclose(found["T_stress"], found["T_stress"][:, :1] * np.ones(3), rtol=3e-3)
    np.testing.assert_allclose(history.J_radius, history.G_radius, rtol=2e-3)


def test_rings_hold_the_kink_on_linear_triangles_too():
    history = cfmpm.run(kinked(-10, 70.5, 1.0, T3=True)).history
    k_1, k_2 = (history[name].values[0] for name in ("K_I_radius", "K_II_radius"))
    np.testing.assert_allclose(k_1, k_1[:, :1] * np.ones(3), rtol=0.01)
    np.testing.assert_allclose(k_2, k_2[:, :1] * np.ones(3), atol=0.01 * k_1.max())


@pytest.mark.parametrize(("traction", "kink", "allowed"), [(10, -30.0, 0.01), (-10, 70.5, 0.03)])
def test_short_wings_have_the_factors_of_the_kink(traction, kink, allowed):
    """Amestoy and Leblond (1992): K = F K0, plus a term with the root of the length.

    Closed without friction, K0 is pure shear, -sigma sin cos (pi c)^0.5; their crack is
    open, so that their factors do not contain contact beside the kink.
    """
    k_0 = 0.5 * np.sqrt(np.pi * C) * abs(traction)
    before = (k_0, k_0) if traction > 0 else (0.0, -k_0)
    lengths = C * np.array([0.0025, 0.01])
    found = []
    for wing in lengths:
        history = cfmpm.run(kinked(traction, kink, wing)).history
        found.append([float(history[name][0, 1]) for name in ("K_I", "K_II")])
    near, far = np.array(found)
    limit = near - (far - near) / (np.sqrt(lengths[1] / lengths[0]) - 1.0)
    np.testing.assert_allclose(limit, kinked_factors(*before, kink), atol=allowed * k_0)


@pytest.mark.parametrize(("wing", "allowed"), [(0.02, 0.02), (0.1, 0.03), (0.5, 0.09), (1.0, 0.05)])
def test_wings_of_a_crack_under_pressure(wing, allowed):
    """K_I against 2 c tau sin(theta) / (pi (l + 0.27 c))^0.5 - p (pi l)^0.5.

    tau is the shear on the closed crack, p the pressure across the wing: the approximation of
    Horii and Nemat-Nasser (1986, Phil. Trans. R. Soc. A 319, 337-374), good for short wings. The
    differences are parts of K_II before the kink.
    """
    history = cfmpm.run(kinked(-10, 70.5, wing * C)).history
    length, shear = wing * C, 5.0
    pressure = 10.0 * np.sin(np.radians(70.5 - 45.0)) ** 2
    approximate = 2 * C * shear * np.sin(np.radians(70.5)) / np.sqrt(np.pi * (length + 0.27 * C))
    approximate -= pressure * np.sqrt(np.pi * length)
    assert float(history.K_I[0, 0]) == pytest.approx(
        approximate, abs=allowed * shear * np.sqrt(np.pi * C)
    )


def test_wings_turn_to_the_load_and_need_more_and_more_of_it():
    """A crack at 45 degrees in compression: kink 70.5 degrees, then K_II near zero."""
    size = 1.0
    scene = {
        "name": "wing",
        "family": {
            "kind": "centre_crack",
            "width": 200,
            "height": 200,
            "crack_length": 2 * C,
            "crack_angle": 45,
            "traction": -10,
        },
        "material": {"E": 70e3, "nu": 0.33, "g_c": 0.01},
        "mesh": {"element": "T6", "grading": {"tip_size": size, "growth": 0.3}},
        "fracture": {"refine": size},
        # Both wings grow in each increment, to 0.9 of the half length of the crack.
        "growth": {"control": "crack", "increments": 20},
    }
    history = cfmpm.run(scene_from_dict(scene)).history
    assert float(abs(history.kink_angle[0]).min()) == pytest.approx(70.5, abs=0.3)
    ran = history.tip_status.values[:, 0] == 0
    k_1, k_2 = (history[name].values[ran, 0] for name in ("K_I", "K_II"))
    wing = np.hypot(history.tip_x - history.tip_x[0], history.tip_y - history.tip_y[0])
    far = wing.values[ran, 0] > 5 * size
    assert far.sum() > 8
    assert np.abs(k_2[far] / k_1[far]).max() < 0.06
    assert np.abs(k_2[far] / k_1[far]).mean() < 0.02
    assert (k_1[1:] > 0.0).all()
    # K_I per load falls as the wing gets longer.
    assert (np.diff((k_1 / history.load_factor.values[ran])[far]) < 0.0).all()
    path = np.column_stack([history.tip_x.values[:, 0], history.tip_y.values[:, 0]])
    steps = np.diff(path, axis=0)
    steps = steps[np.hypot(*steps.T) > 0.0]
    angle = np.degrees(np.arctan2(-steps[:, 1], -steps[:, 0]))
    # From 45 + 70.5 degrees on to the axis of the load, without a saw-tooth.
    assert np.abs(angle[-4:]).max() == pytest.approx(90.0, abs=20.0)
    # While the wing has but a few elements its direction is that of the grid to 10 degrees or so.
    assert np.abs(np.diff(angle[8:])).max() < 5.0


def test_wings_on_a_coarse_grid_are_told_by_their_energy():
    """In compression most work is stored; the gap is compared with the fracture energy."""
    at = C / 2 / np.sqrt(2)
    scene = {
        "name": "coarse",
        "geometry": {
            "outline": [
                {"at": [-100, -100], "edge": "bottom"},
                [100, -100],
                {"at": [100, 100], "edge": "top"},
                [-100, 100],
            ],
            "cracks": [{"points": [[-at, -at], [at, at]]}],
        },
        "material": {"E": 70e3, "nu": 0.3, "g_c": 5.0},
        "loads": [
            {"edge": "bottom", "traction": [0, 100]},
            {"edge": "top", "traction": [0, -100]},
        ],
        "mesh": {"size": 15},
        "growth": {"control": "crack", "increments": 12},
    }
    open_by = {}
    for refine in (None, 0.3):
        fracture = {} if refine is None else {"refine": refine}
        history = cfmpm.run(scene_from_dict(scene | {"fracture": fracture})).history
        of_work, of_crack = parts_of_gap(history)
        assert of_work < 1e-3
        open_by[refine] = of_crack
        told = "the energy balance has a gap" in history.attrs["warnings"]
        assert told == (of_crack > 0.05)
    assert open_by[None] > 0.05 > open_by[0.3]
