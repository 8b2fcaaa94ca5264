"""Closed tips: K of the exact solution on coarse grids, and no growth."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import cfmpm
from cfmpm.output import summary
from cfmpm.output.warnings import of_history
from cfmpm.scene import scene_from_dict

P, E, NU = 10.0, 210e3, 0.3
LENGTH = 20.0
MODULUS = E / (1.0 - NU**2)
SCALE = P * np.sqrt(0.5 * np.pi * LENGTH)
SIDE = 60.0


def kinked(angle, x=20.0):
    turn = np.radians(angle)
    ahead = 0.5 * LENGTH * np.array([np.cos(turn), np.sin(turn)])
    return [[x, 30.0], [x + 0.5 * LENGTH, 30.0], [x + 0.5 * LENGTH + ahead[0], 30.0 + ahead[1]]]


CRACKS = {
    "two tips": [[20.0, 30.0], [40.0, 30.0]],
    "edge": [[0.0, 30.0], [20.0, 30.0]],
    "kink of 10": kinked(10.0),
    "kink of 30": kinked(30.0),
    "kink of 60": kinked(60.0),
    "kink at an edge": kinked(40.0, 0.0),
    "bends": [[30 + 10 * math.cos(t), 22 + 10 * math.sin(t)] for t in np.linspace(0.4, 2.4, 8)],
}
FATIGUE = {"C": 1e-12, "m": 3.0}


def pressed(crack, elements, element="T6", *, across=P, along=0.0, g_c=1.0, **more):
    """A square under pressure on all four sides, on a uniform grid."""
    return scene_from_dict(
        {
            "name": "pressed",
            "geometry": {
                "outline": [
                    {"at": [0, 0], "edge": "bottom"},
                    {"at": [SIDE, 0], "edge": "right"},
                    {"at": [SIDE, SIDE], "edge": "top"},
                    {"at": [0, SIDE], "edge": "left"},
                ],
                "cracks": [{"points": crack}],
            },
            "material": {"E": E, "nu": NU, "g_c": g_c},
            "kinematics": "small",
            "loads": [
                {"edge": "bottom", "traction": [0, across]},
                {"edge": "top", "traction": [0, -across]},
                {"edge": "left", "traction": [along, 0]},
                {"edge": "right", "traction": [-along, 0]},
            ],
            "mesh": {"element": element, "size": LENGTH / elements, "grading": "uniform"},
        }
        | more
    )


def assert_without_stress_intensity(history):
    first = history.isel(step=0)
    assert float(first.contact_pairs) > 0
    for name in ("K_I", "K_II", "K_I_radius", "K_II_radius"):
        assert float(abs(first[name]).max()) <= 1e-9 * SCALE, name
    for name in ("J", "G", "J_radius", "G_radius"):
        assert float(abs(first[name]).max()) <= 1e-12 * SCALE**2 / MODULUS, name
    np.testing.assert_allclose(first.contact_pressure, P, rtol=1e-9)
    assert np.isnan(first.critical_load_factor).all()
    assert "J and G" not in history.attrs["warnings"]


@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize(
    "elements", [3, 5, 10, *(pytest.param(n, marks=pytest.mark.slow) for n in (20, 40))]
)
@pytest.mark.parametrize("crack", CRACKS)
def test_pressure_from_all_sides_leaves_no_stress_intensity(crack, elements, element):
    """As in the same body without a crack."""
    scene = pressed(CRACKS[crack], elements, element, along=P)
    assert_without_stress_intensity(cfmpm.run(scene).history)


@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("elements", [3, 5, 10])
@pytest.mark.parametrize("crack", ["two tips", "edge"])
def test_grips_that_press_leave_none_but_by_the_error_of_the_method(crack, elements, element):
    """Non-uniform pressure: K is zero by symmetry of the plate, without symmetry of the grid."""
    loads = [
        {"edge": "bottom", "displacement": {"x": 0, "y": 0}},
        {"edge": "top", "displacement": {"x": 0, "y": -0.003}},
    ]
    history = cfmpm.run(pressed(CRACKS[crack], elements, element, loads=loads)).history
    first = history.isel(step=0)
    assert float(first.contact_pressure.min()) > 5.0
    assert not first.K_I.values.any()
    assert not first.K_II.values.any()
    assert (abs(first.J) < first.G_floor).all()
    assert "J and G" not in history.attrs["warnings"]


@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("elements", [3, 5, 10, 40])
@pytest.mark.parametrize("beta", [15, 45, 75])
def test_inclined_cracks_are_sheared(beta, elements, element):
    """K_II = p sin(b) cos(b) (pi a)^0.5 and K_I = 0 in an infinite plate, b from the load."""
    length = 4.0
    scene = scene_from_dict(
        {
            "name": "inclined",
            "family": {
                "kind": "centre_crack",
                "width": 100,
                "height": 100,
                "crack_length": length,
                "crack_angle": 90 - beta,
                "traction": -P,
            },
            "material": {"E": E, "nu": NU},
            "kinematics": "small",
            "mesh": {
                "element": element,
                "size": 10,
                "grading": {"tip_size": length / elements, "growth": 0.2},
            },
        }
    )
    history = cfmpm.run(scene).history.isel(step=0)
    angle = np.radians(beta)
    exact = P * np.sin(angle) * np.cos(angle) * np.sqrt(0.5 * np.pi * length)
    assert not history.K_I.values.any()
    allowed = {"T3": 0.16, "T6": 0.06}[element] / elements + 0.005
    np.testing.assert_allclose(abs(history.K_II), exact, rtol=allowed)
    assert (history.contact_pressure > 0.0).all()


@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("angle", [30.0, 90.0, -60.0])
def test_a_corner_bears_the_pressure_of_each_of_its_sides(angle, element):
    """The normal traction differs on both sides of the corner under a uniform stress.

    The stress has no shear on either side.
    """
    turn = np.radians(angle)
    crack = kinked(angle)
    # Normal stresses along and across the first side are principal; the second one is free of
    # shear where they are equal, or where it is perpendicular.
    along = 0.0 if angle == 90.0 else P
    history = cfmpm.run(pressed(crack, 8, element, along=along)).history.isel(step=0)
    second = P * np.cos(turn) ** 2 + along * np.sin(turn) ** 2
    np.testing.assert_allclose(history.contact_pressure, [P, second], rtol=1e-9, atol=1e-9 * P)
    assert not history.K_I.values.any()
    assert not history.K_II.values.any()
    assert float(abs(history.J).max()) < 1e-12 * SCALE**2 / MODULUS


@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("crack", ["two tips", "edge", "kink of 60"])
@pytest.mark.parametrize(
    ("growth", "word"),
    [
        ({"control": "crack"}, "stopped"),
        ({"control": "crack", "criterion": "cf_norm", "direction": "cf"}, "stopped"),
        ({"control": "crack", "direction": "max_energy"}, "stopped"),
        ({"control": "load"}, "stopped"),
        ({"control": "load", "criterion": "cf_norm", "direction": "cf"}, "stopped"),
        ({"control": "fatigue"}, "arrested"),
    ],
)
def test_a_crack_that_is_pressed_shut_never_grows(growth, word, crack, element):
    """At any load: g_c is far below any round-off of the driving force."""
    tough = 1.0 if growth["control"] != "load" else 1e-9
    more = {"fatigue": FATIGUE} if growth["control"] == "fatigue" else {}
    scene = pressed(CRACKS[crack], 6, element, along=P, g_c=tough, growth=growth, **more)
    history = cfmpm.run(scene).history
    assert history.attrs["run_status"] == word
    assert "pressed shut: crack_1" in history.attrs["ending"]
    assert history.sizes["step"] == 1
    assert_without_stress_intensity(history)
    if growth["control"] == "fatigue":
        assert float(history.cycles[-1]) == 0.0
        assert not history.delta_K.values.any()


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_uneven_pressure_of_two_materials_does_not_make_it_grow(element):
    """Symmetric about the crack: any shear is an error of the grid."""
    soft = {"E": 20e3, "nu": 0.3, "g_c": 1.0}
    corners = [[42, 0], [SIDE, 0], [SIDE, SIDE], [42, SIDE]]
    scene = pressed([[0.0, 30.0], [24.0, 30.0]], 6, element, growth={"control": "crack"})
    document = scene.model_dump(mode="json", exclude_unset=True)
    document["mesh"] = {"element": element, "size": 6}
    document["geometry"]["regions"] = [{"name": "soft", "material": soft, "polygon": corners}]
    history = cfmpm.run(scene_from_dict(document)).history
    assert history.attrs["run_status"] == "stopped"
    assert history.sizes["step"] == 1
    assert float(history.contact_pressure[0, 0]) != pytest.approx(P, rel=0.01)
    assert not history.K_II.values.any()


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_at_finite_deformation_it_does_not_grow_either(element):
    growth = {"control": "load", "criterion": "cf_norm", "direction": "cf"}
    scene = pressed(
        CRACKS["edge"], 6, element, along=P, g_c=1e-9, growth=growth, kinematics="finite"
    )
    history = cfmpm.run(scene).history
    assert history.attrs["run_status"] == "stopped"
    assert history.sizes["step"] == 1
    assert float(history.contact_pressure[0, 0]) == pytest.approx(P, rel=1e-3)
    assert abs(float(history.J[0, 0])) < float(history.G_floor[0, 0])


@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("load", [P, -P])
def test_a_crack_along_the_stress_has_no_stress_intensity(load, element):
    """Open, without tension and shear: the T-stress alone must not cause growth."""
    growth = {"control": "crack"}
    scene = pressed([[30.0, 20.0], [30.0, 40.0]], 8, element, across=load, growth=growth)
    history = cfmpm.run(scene).history
    assert history.attrs["run_status"] == "stopped"
    assert history.sizes["step"] == 1
    assert not history.K_I.values.any()
    assert not history.K_II.values.any()
    np.testing.assert_allclose(history.T_stress[0], -load, rtol=1e-9)


def sheared_by(x, y, shear):
    """Tractions of a uniform stress on all sides of the square."""
    return [
        {"edge": "bottom", "traction": [-shear, -y]},
        {"edge": "top", "traction": [shear, y]},
        {"edge": "left", "traction": [-x, -shear]},
        {"edge": "right", "traction": [x, shear]},
    ]


@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("x", [1e3, 1e5])
@pytest.mark.parametrize(("y", "shear", "mode"), [(1.0, 0.0, "K_I"), (-1.0, 1.0, "K_II")])
def test_stress_along_the_crack_takes_no_stress_intensity_away(y, shear, mode, x, element):
    """K depends on the normal and shear stress of the crack only, for any T-stress."""
    crack = CRACKS["two tips"]

    def solved(along):
        return cfmpm.run(
            pressed(crack, 10, element, loads=sheared_by(along, y, shear), g_c=1.0)
        ).history.isel(step=0)

    alone, history = solved(0.0), solved(math.copysign(x, y))
    assert float(abs(alone[mode]).min()) > 5.0
    np.testing.assert_allclose(history[mode], alone[mode], rtol=2e-3)
    np.testing.assert_allclose(history.J, alone.J, rtol=2e-3)
    np.testing.assert_allclose(history.critical_load_factor, alone.critical_load_factor, rtol=2e-3)


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_a_sheared_tip_under_high_pressure_grows_at_finite_deformation(element):
    """J is far above g_c and above the error of the shear."""
    growth = {"control": "load", "criterion": "cf_norm", "direction": "cf", "increments": 1}
    scene = pressed(
        CRACKS["two tips"],
        8,
        element,
        loads=sheared_by(-500.0, -500.0, 10.0),
        g_c=1e-3,
        growth=growth,
        kinematics="finite",
    )
    history = cfmpm.run(scene).history
    assert history.sizes["step"] == 2
    assert (history.J[0] > 5.0 * history.G_floor[0]).all()
    assert (history.contact_pressure[0] > 400.0).all()


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_the_first_segment_of_a_wing_is_open(element):
    """On a closed sheared crack: contact behind the kink does not close the tip."""
    scene = pressed(
        [[23.0, 23.0], [37.0, 37.0]], 20, element, growth={"control": "crack", "increments": 1}
    )
    history = cfmpm.run(scene).history
    assert not history.K_I[0].values.any()
    assert (history.contact_pressure[0] > 0.0).all()
    ran = np.hypot(*(history[name][1] - history[name][0] for name in ("tip_x", "tip_y"))) > 0.0
    assert ran.any()
    # That of an infinitesimal kink of pure shear is 1.15 K_II.
    sheared = abs(history.K_II[0] / history.load_factor[0])
    opened = (history.K_I[1] / history.load_factor[1]).values[ran]
    np.testing.assert_allclose(opened, sheared.values[ran], rtol=0.2)
    assert not history.contact_pressure[1].values[ran].any()


class TestJAndG:
    """A difference gives the first warning of the result, and its action helps."""

    @staticmethod
    def result(elements):
        """Result of T3 for a sheared closed crack."""
        crack = [[25.0, 25.0], [35.0, 35.0]]
        return cfmpm.run(
            pressed(
                crack,
                10,
                "T3",
                mesh={
                    "element": "T3",
                    "size": 10,
                    "grading": {"tip_size": 14.0 / elements, "growth": 0.2},
                },
            )
        )

    def test_said_at_the_top(self):
        result = self.result(4)
        history = result.history
        apart = abs(history.J - history.G) / np.maximum(abs(history.J), history.G)
        assert float(apart.max()) > 0.2
        told = json.loads(history.attrs["warnings"])
        for text, name in zip(told, ("crack_1_start", "crack_1_end"), strict=False):
            largest = 100 * float(apart.sel(tip=name)[0])
            assert text.startswith(f"{name}: in step 1 J and G from K_I and K_II differ by up to ")
            assert f"{largest:.2g} %" in text
            assert "mesh.grading.tip_size" in text
        lines = summary.of_run(result, []).splitlines()
        assert lines[0] == "pressed"
        assert lines[2].startswith("crack_1_start: in step 1 J and G")
        table = next(i for i, line in enumerate(lines) if line.startswith("tip [mm]"))
        assert table > max(i for i, line in enumerate(lines) if "J and G" in line)

    def test_said_where_k_was_set_to_zero(self):
        result = self.result(4)
        history = result.history.copy(deep=True)
        for name in ("K_I", "K_II", "G"):
            history[name][:] = 0.0
        scene = result.scene
        told = of_history.doubts_of_release_rates(history, scene)
        assert len(told) == history.sizes["tip"]
        size = float(history.J.sel(tip="crack_1_start")[0])
        assert told[0].startswith(f"crack_1_start: in step 1 J is up to {size:.3g} N/mm")
        history["G_floor"][:] = 2.0 * history["J"].max()
        assert not of_history.doubts_of_release_rates(history, scene)

    def test_said_where_a_tip_with_j_above_the_toughness_is_held_back(self):
        result = self.result(4)
        history = result.history.copy(deep=True)
        scene = result.scene.model_copy(
            update={"material": result.scene.material.model_copy(update={"g_c": 1e-6})}
        )
        history["K_I"][:] = np.nan
        assert not of_history.doubts_of_held_tips(history, scene)
        history["G_floor"][:] = 2.0 * history["J"].max()
        told = of_history.doubts_of_held_tips(history, scene)
        assert len(told) == history.sizes["tip"]
        assert told[0].startswith("crack_1_start: in step 1 J is up to ")
        assert not of_history.doubts_of_held_tips(history, result.scene)

    def test_the_advice_helps(self):
        assert "J and G" not in self.result(140).history.attrs["warnings"]

    def test_nothing_is_said_of_a_closed_tip_without_shear(self):
        result = cfmpm.run(pressed(CRACKS["two tips"], 5, along=P))
        lines = summary.of_run(result, []).splitlines()
        (told,) = (line for line in lines if line.startswith("J / G - 1"))
        assert told.split()[-2:] == ["-", "-"]
