"""Fixed loads besides proportional ones: superposition on the same grid."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from histories import same
from outlines import named_rectangle
from scipy.optimize import brentq

from cfmpm import simulation, steps
from cfmpm.equilibrium.newton import RESIDUAL
from cfmpm.fracture.finite_effect import NEGLIGIBLE
from cfmpm.output.checkpoint import Start, read_checkpoint
from cfmpm.output.fields import build_fields
from cfmpm.output.record import Record
from cfmpm.output.run_folder import CHECKPOINT
from cfmpm.output.run_writer import RunWriter
from cfmpm.scene import scene_from_dict
from cfmpm.state import Result, State

WEIGHT, SIDE, GRIP, PULL = [2e-3, -4e-3], [0.8, 0.5], 4e-4, [0.0, 6.0]
FIXED = ("weight", "side", "grip")
# Of the tips, and of the whole; the load factor itself is another one.
AT_TIPS = ("K_I", "K_II", "T_stress", "J", "G", "G_kink", "cf_x", "cf_y", "cf_norm", "kink_angle")
OF_BODY = ("strain_energy", "reaction_x", "reaction_y", "displacement_x", "displacement_y")


def plate(fixed: float = 1.0, factor: float = 1.0, **changes: Any) -> dict[str, Any]:
    """A plate with an inclined edge crack: weight, traction, grip, and tension."""
    scene: dict[str, Any] = {
        "name": "plate",
        "geometry": {
            "outline": named_rectangle(40, 60),
            "cracks": [{"name": "crack", "points": [[0, 30], [10, 33]]}],
        },
        "material": {"E": 1e4, "nu": 0.3, "g_c": 0.2},
        "loads": [
            {"name": "held", "edge": "bottom", "displacement": {"x": 0, "y": 0}},
            {"name": "grip", "edge": "top", "displacement": {"x": GRIP * fixed}},
            {"name": "weight", "body_force": [fixed * part for part in WEIGHT]},
            {"name": "side", "edge": "right", "traction": [fixed * part for part in SIDE]},
            {"name": "pull", "edge": "top", "traction": [factor * part for part in PULL]},
        ],
        "kinematics": "small",
        "mesh": {"element": "T3", "size": 6},
    }
    return scene | changes


def run(scene: dict[str, Any], fixed: tuple[str, ...] = ()) -> Result:
    """Run a scene in which some loads are fixed, independent of the load factor."""
    full = scene_from_dict(scene)
    stage = steps.begin(full, fixed)
    return simulation.run(full, start=Start(stage, Record.of(full, stage)))


def assert_close(found: Any, expected: Any, rtol: float, name: str = "") -> None:
    """Compare relative to the largest value."""
    found, expected = np.asarray(found), np.asarray(expected)
    atol = rtol * np.nanmax(np.abs(expected))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=atol, err_msg=name)


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_superposition(element: str) -> None:
    """Fixed loads A and a factor times B are the one load case A + factor B."""
    mesh = {"element": element, "size": 6}
    factors = [0.25, 1.0, 3.0]
    found = run(plate(mesh=mesh, load_steps=factors), FIXED)
    np.testing.assert_array_equal(found.history.load_factor, factors)
    for step, factor in enumerate(factors):
        one = run(plate(factor=factor, mesh=mesh))
        at, expected = found.history.isel(step=step), one.history.isel(step=0)
        for name in (*AT_TIPS, *OF_BODY):
            assert_close(at[name], expected[name], 1e-11, name)
        # In one case the work of all loads that grow together.
        assert float(expected.external_work) == pytest.approx(float(expected.strain_energy))
        assert float(at.external_work) == pytest.approx(float(at.strain_energy), rel=1e-11)
    # The fields of the last step.
    fields, expected_fields = build_fields(found), build_fields(one)
    for name in ("u_x", "u_y", "sigma_xx", "sigma_yy", "sigma_xy", "cf_x", "energy_density"):
        assert_close(fields[name], expected_fields[name], 1e-11, name)


def test_contact_is_that_of_the_state_itself() -> None:
    """Fixed pressure and proportional tension: closed, then open, as in one load case."""
    press, pull = [0.0, -8.0], [0.0, 6.0]
    loads = [plate()["loads"][0], {"name": "press", "edge": "top", "traction": press}]
    pulled = {"name": "pull", "edge": "top", "traction": pull}
    factors = [0.5, 1.0, 2.0]
    found = run(plate(loads=[*loads, pulled], load_steps=factors), ("press",)).history
    assert found.contact_pairs[0] > 0
    assert found.contact_pairs[2] == 0
    for step, factor in enumerate(factors):
        scaled = {**pulled, "traction": [factor * part for part in pull]}
        expected = run(plate(loads=[*loads, scaled])).history.isel(step=0)
        at = found.isel(step=step)
        assert float(at.contact_pairs) == float(expected.contact_pairs)
        for name in ("K_I", "K_II", "T_stress", "J", "strain_energy", "reaction_y"):
            assert_close(at[name], expected[name], 1e-9, name)


@pytest.mark.parametrize("growth", [None, {"control": "crack", "increments": 3}])
def test_a_fixed_part_of_zero_is_none(growth: Any) -> None:
    steps_of = {"load_steps": [0.3, 1.7]} if growth is None else {}
    scene = plate(fixed=0.0, growth=growth, **steps_of)
    zero, none = run(scene, FIXED).history, run(scene).history
    assert set(zero.variables) == set(none.variables)
    for name in set(none.variables) - {"wall_time"}:
        np.testing.assert_array_equal(zero[name], none[name], err_msg=name)


@pytest.mark.parametrize("sheared", [0.0, 30.0])
def test_critical_load_factor(sheared: float) -> None:
    """Against bisection of scenes of one load case; K_II / K_I changes with the factor."""

    def scene(factor: float) -> dict[str, Any]:
        made = plate(fixed=1.5, factor=factor)
        made["loads"][3]["traction"] = [0.8, sheared * 0.5]
        return made

    found = run(scene(1.0), FIXED).history
    factor = float(found.critical_load_factor[0, 0])

    def drive(factor: float) -> float:
        return math.sqrt(float(run(scene(factor)).history.G_kink[0, 0]) / 0.2) - 1.0

    assert factor == pytest.approx(
        brentq(drive, 0.9 * factor, 1.1 * factor, xtol=1e-13, rtol=1e-13), rel=1e-10
    )
    for step in (0.5, 2.0):  # whatever the load at which it is asked
        again = run(scene(1.0) | {"load_steps": [step]}, FIXED).history
        assert float(again.critical_load_factor[0, 0]) == pytest.approx(factor, rel=1e-12)


def test_auto_judges_the_largest_load_beside_fixed_ones() -> None:
    """The estimate is that of the largest load in each step: fixed loads do not scale with it."""
    little = run(plate(kinematics="auto", load_steps=[0.1]), FIXED).history
    assert float(little.finite_effect[0]) < NEGLIGIBLE
    assert not little.substeps.any()
    much = run(plate(kinematics="auto", load_steps=[0.1, 60.0]), FIXED).history
    assert (much.substeps.values > 0).all()
    assert much.finite_effect[0] == much.finite_effect[1] > NEGLIGIBLE
    np.testing.assert_array_equal(much.finite_effect_J[0], much.finite_effect_J[1])


@pytest.mark.parametrize(("fixed", "g_c"), [(-1.0, 1e-4), (20.0, 1e-2)], ids=["driven", "pressed"])
def test_no_load_factor_where_there_is_none(fixed: float, g_c: float) -> None:
    """The fixed loads alone reach g_c; or they close the crack at the critical factor.

    In the second case the load of the solve opens the crack.
    """
    material = {"E": 1e4, "nu": 0.3, "g_c": g_c}
    history = run(plate(fixed=fixed, material=material, load_steps=[30.0]), FIXED).history
    assert float(history.contact_pairs[0]) == 0
    assert np.isnan(history.critical_load_factor[0, 0])
    text = "crack: in step 1 no critical_load_factor: the fixed loads"
    assert text in history.attrs["warnings"]
    less = run(plate(fixed=0.01 * fixed, material=material, load_steps=[30.0]), FIXED).history
    assert np.isfinite(less.critical_load_factor[0, 0])
    assert "no critical_load_factor" not in less.attrs["warnings"]


def test_an_infinite_load_factor_where_the_proportional_loads_close_the_crack() -> None:
    history = run(plate(factor=-1.0, load_steps=[0.01]), FIXED).history
    assert np.isinf(history.critical_load_factor[0, 0])
    assert "no critical_load_factor" not in history.attrs["warnings"]


CRITERIA = [("energy_release_rate", "max_hoop"), ("cf_norm", "cf")]


@pytest.mark.parametrize(("criterion", "direction"), CRITERIA)
def test_crack_control(criterion: str, direction: str) -> None:
    """The driving force is g_c in each step; energy is balanced as without fixed loads.

    The fixed loads are a part of the loads of a scene in which all are proportional.
    """
    growth = {
        "control": "crack",
        "criterion": criterion,
        "direction": direction,
        "increments": 6,
    }
    mesh = {"element": "T6", "size": 6}
    changes = {"growth": growth, "mesh": mesh}
    gaps = []
    for fixed in (FIXED, ()):
        history = run(plate(**changes), fixed).history
        assert history.sizes["step"] == 7
        driving = history["G_kink" if criterion == "energy_release_rate" else "cf_norm"]
        np.testing.assert_allclose(driving[:, 0], 0.2, rtol=1e-10)
        gap = history.energy_gap[-1] / history.fracture_energy[-1]
        gaps.append(abs(float(gap)))
        # Along the path the crack goes on at loads of its own.
        assert float(np.ptp(history.load_factor.values)) > 0.05 * float(history.load_factor[0])
    assert gaps[0] < max(2.0 * gaps[1], 2e-3)


@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("tip", [10, 12, 14])
def test_a_tip_that_one_part_does_not_load_is_driven_by_the_other(tip: int, element: str) -> None:
    """On an interface, where G is J: J of a stress along the crack is round-off."""
    beyond = [[tip, 0], [40, 0], [40, 60], [tip, 60]]
    same = {"E": 1e4, "nu": 0.3, "g_c": 0.3}
    scene = plate(
        geometry={
            "outline": named_rectangle(40, 60),
            "cracks": [{"name": "crack", "points": [[0, 30], [tip, 30]]}],
            "regions": [{"name": "beyond", "material": same, "polygon": beyond}],
        },
        loads=[
            {"name": "west", "edge": "left", "traction": [-5, 0]},
            {"name": "east", "edge": "right", "traction": [5, 0]},
            {"name": "top", "edge": "top", "traction": [0, 6]},
            {"name": "bottom", "edge": "bottom", "traction": [0, -6]},
        ],
        mesh={"element": element, "size": 5},
        growth={"control": "crack", "increments": 1},
    )
    history = run(scene, ("west", "east")).history
    assert np.isnan(history.K_I[0, 0])
    assert history.sizes["step"] == 2
    np.testing.assert_allclose(history.G[0], 0.3, rtol=1e-9)


@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("along", [5.0, 50.0])
def test_fixed_stress_along_the_crack_stops_no_growth(along: float, element: str) -> None:
    """Its K is an error of quadrature only; K of all loads is the sum of the parts."""
    scene = plate(
        geometry={
            "outline": named_rectangle(40, 60),
            "cracks": [{"name": "crack", "points": [[0, 30], [12, 30]]}],
        },
        loads=[
            {"name": "west", "edge": "left", "traction": [-along, 0]},
            {"name": "east", "edge": "right", "traction": [along, 0]},
            {"name": "top", "edge": "top", "traction": [0, 6]},
            {"name": "bottom", "edge": "bottom", "traction": [0, -6]},
        ],
        mesh={"element": element, "size": 5},
        growth={"control": "crack", "increments": 2},
    )
    history = run(scene, ("west", "east")).history
    assert history.sizes["step"] == 3
    np.testing.assert_allclose(history.G_kink[:, 0], 0.2, rtol=1e-9)


@pytest.mark.parametrize(
    ("changes", "status", "reason"),
    [
        (
            {"material": {"E": 1e4, "nu": 0.3, "g_c": 1e-4}, "fixed": -1.0},
            "unstable",
            "the fixed loads alone make a crack grow",
        ),
        # A stable state may follow: it is only not the sum of two.
        ({"fixed": 20.0}, "unsolvable", "crack faces are in contact, so that the states"),
    ],
)
def test_crack_control_ends_where_no_load_is_found(
    changes: dict[str, Any], status: str, reason: str
) -> None:
    history = run(plate(growth={"control": "crack", "increments": 8}, **changes), FIXED).history
    assert history.attrs["run_status"] == status
    assert reason in history.attrs["ending"]
    solved = history.critical_load_factor[:-1, 0]
    np.testing.assert_allclose(history.load_factor[:-1], solved, rtol=1e-12)
    assert np.isnan(history.critical_load_factor[-1, 0])


def test_a_run_that_was_broken_off_goes_on_with_its_fixed_loads(tmp_path: Path) -> None:
    scene = scene_from_dict(plate(growth={"control": "crack", "increments": 4}))
    stage = steps.begin(scene, FIXED)
    keeper = RunWriter(tmp_path)

    def observe(state: State, record: Record) -> None:
        if len(record.steps) < 3:
            keeper.observe(state, record)
            keeper.write("")

    whole = simulation.run(scene, observe=observe, start=Start(stage, Record.of(scene, stage)))
    start = read_checkpoint(tmp_path / CHECKPOINT)
    assert start.stage.body.loading.fixed_names == set(FIXED)
    same(simulation.run(scene, start=start).history, whole.history)


class TestFatigue:
    """The range of a cycle is that of the proportional loads."""

    def history(self, ratio: float, names: tuple[str, ...], **changes: Any) -> Any:
        scene = plate(
            growth={"control": "fatigue", "increments": 2},
            fatigue={"C": 1e-12, "m": 3.0, "load_ratio": ratio},
            **changes,
        )
        return run(scene, names).history

    def factors(self, factor: float, names: tuple[str, ...], **changes: Any) -> tuple[float, float]:
        """K_I and K_II of the same crack without growth."""
        tough = {"E": 1e4, "nu": 0.3, "g_c": 1e3}
        scene = plate(load_steps=[factor], growth={"control": "load"}, material=tough, **changes)
        found = run(scene, names).history
        return float(found.K_I[0, 0]), float(found.K_II[0, 0])

    def test_of_both_ends(self) -> None:
        ends = [self.factors(factor, FIXED) for factor in (0.25, 1.0)]
        assert ends[0][0] > 0.0
        found = float(self.history(0.25, FIXED).delta_K[0, 0])
        assert found == pytest.approx(math.dist(*ends), rel=1e-12)
        # That of the proportional part alone, as long as no end is closed.
        alone = 0.75 * math.hypot(*self.factors(1.0, (), loads=self.proportional()))
        assert found == pytest.approx(alone, rel=1e-11)

    def proportional(self) -> list[dict[str, Any]]:
        held, _, _, _, pull = plate()["loads"]
        return [held, {"name": "grip", "edge": "top", "displacement": {"x": 0}}, pull]

    def test_a_closed_end_counts_as_zero(self) -> None:
        press = {"name": "press", "edge": "top", "traction": [0, -2]}
        loads = [plate()["loads"][0], press, plate()["loads"][4]]
        found = float(self.history(0.1, ("press",), loads=loads).delta_K[0, 0])
        # Faces that press on each other leave what shear makes.
        least, greatest = (self.factors(factor, ("press",), loads=loads) for factor in (0.1, 1.0))
        assert least[0] < 1e-3 * greatest[0]
        expected = math.dist((max(least[0], 0.0), least[1]), greatest)
        assert found == pytest.approx(expected, rel=1e-12)

    @pytest.mark.parametrize("ratio", [0.0, 0.3])
    def test_without_a_fixed_part_it_is_as_ever(self, ratio: float) -> None:
        zero, none = (self.history(ratio, names, fixed=0.0) for names in (FIXED, ()))
        np.testing.assert_array_equal(zero.delta_K, none.delta_K)
        np.testing.assert_array_equal(zero.cycles, none.cycles)
        k = none.isel(step=0)
        expected = (1.0 - ratio) * math.hypot(float(k.K_I[0]), float(k.K_II[0]))
        assert float(k.delta_K[0]) == expected


class TestFiniteDeformation:
    """Fixed loads act first."""

    SOFT: ClassVar = {
        "kinematics": "finite",
        "material": {"E": 300.0, "nu": 0.3, "law": "ciarlet"},
    }

    def test_dead_loads_do_not_ask_for_the_way(self) -> None:
        found = run(plate(load_steps=[0.5, 1.0, 2.0], **self.SOFT), FIXED).history
        for step, factor in ((0, 0.5), (2, 2.0)):
            one = run(plate(factor=factor, load_steps=3, **self.SOFT)).history.isel(step=-1)
            at = found.isel(step=step)
            for name in ("J", "cf_x", "cf_y", *OF_BODY):
                assert_close(at[name], one[name], 100 * RESIDUAL, name)
            # By the trapezoidal rule over few steps.
            assert float(at.external_work) == pytest.approx(float(at.strain_energy), rel=0.05)

    def test_on_a_grid_that_follows(self) -> None:
        mesh = {"element": "T3", "size": 6, "grading": "uniform"}
        changes = {**self.SOFT, "mesh": mesh, "load_steps": [0.5, 1.0]}
        total = run(plate(**changes), FIXED).history.isel(step=-1)
        reset = {"formulation": "updated", "updated": {"grid": "following"}}
        found = run(plate(**changes, **reset), FIXED).history.isel(step=-1)
        for name in ("displacement_y", "reaction_y", "strain_energy"):
            assert_close(found[name], total[name], 2e-2, name)
