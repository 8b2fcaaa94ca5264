"""Record of a run: work, kind of growth, arrivals, end."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr
from outlines import named_rectangle

import cfmpm
from cfmpm.fracture.stability import STABILITY, classify
from cfmpm.output.variables import TIP_STATUS
from cfmpm.scene import scene_from_dict

HELD = {"edge": "bottom", "displacement": {"x": 0, "y": 0}}
LOADS: dict[str, list[dict[str, Any]]] = {
    "traction": [HELD, {"edge": "top", "traction": [0, 10]}],
    "grip": [HELD, {"edge": "top", "displacement": {"y": 0.05}}],
    # The corner of top and right is both pulled and held.
    "both": [
        HELD,
        {"edge": "top", "displacement": {"y": 0.05}},
        {"edge": "right", "traction": [0.3, 0.2]},
    ],
}


def plate(loads: list[dict[str, Any]], **changes: Any) -> dict[str, Any]:
    """A plate whose left crack arrives at a hole, and whose right one grows towards it."""
    return {
        "name": "plate",
        "geometry": {
            "outline": named_rectangle(30, 40),
            "cracks": [
                {"name": "left", "points": [[0, 20], [6, 20]]},
                {"name": "right", "points": [[30, 20], [26, 20]]},
            ],
            "holes": [{"name": "hole", "circle": {"centre": [11, 20], "radius": 2}}],
        },
        "material": {"E": 1e4, "nu": 0.3, "g_c": 1.0},
        "loads": loads,
        "mesh": {"element": "T3", "size": 1.5, "grading": "uniform"},
        "growth": {"control": "crack", "increments": 9},
    } | changes


@pytest.fixture(scope="module", params=LOADS)
def grown(request: pytest.FixtureRequest) -> xr.Dataset:
    history = cfmpm.run(scene_from_dict(plate(LOADS[request.param]))).history
    assert history.jump.values.sum() >= 1.0
    return history.assign_attrs(loads=request.param)


def forces_and_motions(history: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Force on each loaded part, and its mean displacement, (step, boundary, 2)."""
    return tuple(
        np.stack([history[f"{name}_{axis}"].values for axis in "xy"], axis=2)
        for name in ("reaction", "displacement")
    )


def test_work_is_that_of_the_forces_on_the_way_that_the_parts_move(grown: xr.Dataset) -> None:
    """Trapezoidal rule; a ligament breaks at constant load, then the load changes."""
    force, motion = forces_and_motions(grown)
    load = grown.load_factor.values
    path = [(np.zeros_like(force[0]), np.zeros_like(motion[0]))]
    expected, work = [], 0.0
    for step, jumped in enumerate(grown.jump.values > 0.0):
        states = [(force[step], motion[step])]
        if jumped:
            part = load[step - 1] / load[step]
            states.insert(0, (part * force[step], part * motion[step]))
        for state in states:
            work += 0.5 * ((path[-1][0] + state[0]) * (state[1] - path[-1][1])).sum()
            path.append(state)
        expected.append(work)
    np.testing.assert_allclose(grown.external_work, expected, rtol=1e-10)


def test_the_first_state_holds_the_work_of_its_loads(grown: xr.Dataset) -> None:
    """Clapeyron's theorem, before growth."""
    first = grown.isel(step=0)
    assert float(first.external_work) == pytest.approx(float(first.strain_energy), rel=1e-10)
    assert abs(float(first.energy_gap)) < 1e-10 * float(first.external_work)


def test_gap_is_what_neither_stored_nor_spent_energy_explains(grown: xr.Dataset) -> None:
    left = grown.external_work - grown.strain_energy - grown.fracture_energy
    assert float(grown.fracture_energy[-1]) > 0.05 * float(grown.external_work[-1])
    np.testing.assert_allclose(
        grown.energy_gap, left, rtol=0, atol=1e-12 * float(grown.external_work.max())
    )


def test_kind_of_growth_is_that_of_the_path(grown: xr.Dataset) -> None:
    """With grips only by force and displacement, otherwise by load and its displacement."""
    force, motion = forces_and_motions(grown)
    load, names = grown.load_factor.values, list(grown.boundary.values)
    top = force[:, names.index("top"), 1], motion[:, names.index("top"), 1]
    if grown.attrs["loads"] == "grip":
        path = top
    elif grown.attrs["loads"] == "traction":
        path = load, top[1]
    else:
        right = names.index("right")
        path = load, (force[:, right] * motion[:, right]).sum(axis=1) / load
    expected = classify(*path)
    # What a ligament does that breaks by itself is no growth at balance.
    expected[:-1][grown.jump.values[1:] > 0.0] = STABILITY.index("undefined")
    np.testing.assert_array_equal(grown.stability, expected)
    assert {"undefined", "snap_back"} <= {STABILITY[flag] for flag in expected}


@pytest.mark.slow
def test_a_run_that_ends_at_a_point_keeps_its_kinds_of_growth() -> None:
    """The last position of the crack has no equilibrium, and therefore no load and force."""
    geometry = plate([])["geometry"]
    geometry = geometry | {"holes": [], "cracks": [{"points": [[0, 20], [6, 20]]}]}
    loads = [*LOADS["grip"], {"name": "rivet", "point": [10, 20], "displacement": {"x": 0.0}}]
    mesh = {"element": "T6", "size": 1.0, "grading": "uniform"}
    scene = plate(loads, geometry=geometry, mesh=mesh)
    history = cfmpm.run(scene_from_dict(scene)).history
    assert history.attrs["run_status"] == "met_point"
    assert np.isnan(history.load_factor[-1])
    top = history.sel(boundary="top")
    expected = classify(top.reaction_y.values, top.displacement_y.values)
    assert STABILITY.index("snap_back") in expected
    np.testing.assert_array_equal(history.stability, expected)


def test_forces_on_grips_leave_out_what_crack_faces_exert_on_each_other() -> None:
    """A crack mouth at the end of a grip, which holds one of the two nodes of the mouth."""
    geometry = {
        "outline": [
            {"at": [0, 0], "edge": "bottom"},
            [30, 0],
            [30, 40],
            {"at": [14, 40], "edge": "grip"},
            [0, 40],
        ],
        "cracks": [{"points": [[14, 40], [16, 30]]}],
    }
    loads = [HELD, {"edge": "grip", "displacement": {"x": 0.02, "y": -0.01}}]
    history = cfmpm.run(scene_from_dict(plate(loads, geometry=geometry, growth=None))).history
    assert int(history.contact_pairs[0]) > 2
    stored = float(history.strain_energy[0])
    force, motion = forces_and_motions(history)
    assert 0.5 * (force * motion).sum() == pytest.approx(stored, rel=1e-9)
    assert float(history.external_work[0]) == pytest.approx(stored, rel=1e-9)
    # All forces on the body are in balance.
    np.testing.assert_allclose(force[0].sum(axis=0), 0.0, atol=1e-9 * np.abs(force).max())


def test_each_tip_has_the_clearance_and_the_element_size_of_its_own(grown: xr.Dataset) -> None:
    """The left tip is 3 mm from the hole, the right one 4 mm from the other end of its
    crack.
    """
    np.testing.assert_allclose(grown.clearance[0], [3.0, 4.0], rtol=1e-12)
    (jump,) = np.flatnonzero(grown.jump.values)
    for name in ("clearance", "tip_size"):
        assert np.isnan(grown[name].values[jump:, 0]).all()
        assert np.isfinite(grown[name].values[:jump]).all()
    reach = np.minimum(5.0 * grown.tip_size.values, 0.9 * grown.clearance.values)
    np.testing.assert_allclose(grown.domain_radius.values[:, :, 0], reach, rtol=1e-12)


def test_radii_are_named_by_the_tip_with_the_most_room() -> None:
    geometry = plate([])["geometry"] | {"holes": []}
    mesh = {"element": "T3", "size": 3, "grading": {"tip_size": 0.5, "growth": 0.4}}
    scene = plate(LOADS["traction"], geometry=geometry, mesh=mesh, growth=None)
    history = cfmpm.run(scene_from_dict(scene | {"fracture": {"radii": 3}})).history
    used = history.domain_radius.values[0]
    # The cracks are 6 and 4 mm long.
    assert used[0, -1] == pytest.approx(0.9 * 6.0, rel=1e-9)
    assert used[1, -1] == pytest.approx(0.9 * 4.0, rel=1e-9)
    np.testing.assert_array_equal(history.radius, used[0])


def statuses(history: xr.Dataset) -> list[list[str]]:
    """Status of each tip by step."""
    return [[TIP_STATUS[flag] for flag in flags] for flags in history.tip_status.values]


def test_only_what_arrives_in_the_last_step_has_cut_the_body(grown: xr.Dataset) -> None:
    """A tip that arrived earlier keeps its status, as do growing and stopped tips."""
    words = statuses(grown)
    (jump,) = np.flatnonzero(grown.jump.values)
    arrived = [words[step][0] == "arrived_hole" for step in range(len(words))]
    assert arrived == [step >= jump for step in range(len(words))]
    assert words[0] == ["growing", "stopped"]
    assert words[jump] == ["arrived_hole", "growing"]
    assert words[-1] == ["arrived_hole", "growing"]
    assert np.isnan(grown.K_I.values[jump:, 0]).all()
    assert np.isfinite(grown.K_I.values[:jump, 0]).all()


@pytest.mark.slow
def test_a_crack_that_arrived_before_is_not_said_to_have_cut_off_a_part() -> None:
    """The left crack arrived at the hole many steps before the right one leaves the body."""
    scene = plate(LOADS["traction"], growth={"control": "crack"})
    history = cfmpm.run(scene_from_dict(scene)).history
    assert history.attrs["run_status"] == "severed"
    assert history.attrs["ending"].endswith("severed by right")
    assert statuses(history)[-1] == ["arrived_hole", "arrived_boundary"]
    assert np.isnan(history.load_factor[-1])
    assert np.isnan(history.energy_gap[-1])
    assert float(history.crack_length[-1, 1]) > float(history.crack_length[-2, 1])


def test_cycles_go_on_to_the_last_position_of_a_fatigue_crack() -> None:
    """The last segment, to the boundary, grows at the rate of the previous state."""
    geometry = plate([])["geometry"]
    geometry = geometry | {"holes": [], "cracks": [{"points": [[0, 20], [20, 20]]}]}
    fatigue = {
        "material": {"E": 1e4, "nu": 0.3},
        "growth": {"control": "fatigue"},
        "fatigue": {"C": 1e-12, "m": 3},
    }
    history = cfmpm.run(
        scene_from_dict(plate(LOADS["traction"], geometry=geometry, **fatigue))
    ).history
    assert history.attrs["run_status"] == "severed"
    segment = np.hypot(np.diff(history.tip_x[-2:, 0]), np.diff(history.tip_y[-2:, 0]))[0]
    growth = float(history.cycles[-1] - history.cycles[-2]) * float(history.da_dN[-2, 0])
    # The only tip is the leader, so that it has no pending advance.
    assert growth == pytest.approx(segment, rel=1e-9)
    assert np.isnan(history.da_dN[-1, 0])
    # There is no fracture energy under fatigue.
    assert np.isnan(history.fracture_energy).all()
    assert np.isnan(history.energy_gap).all()
    words = [word for (word,) in statuses(history)]
    assert set(words[:-1]) == {"growing"}
    assert words[-1] == "arrived_boundary"


def test_a_tip_that_waits_for_its_segment_grows_all_the_same() -> None:
    """Two edge cracks of unequal length in fatigue: the shorter one releases every other time."""
    geometry = plate([])["geometry"]
    cracks = [
        {"name": "short", "points": [[0, 10], [5, 10]]},
        {"name": "long", "points": [[0, 30], [8, 30]]},
    ]
    fatigue = {
        "material": {"E": 1e4, "nu": 0.3},
        "growth": {"control": "fatigue", "increments": 4},
        "fatigue": {"C": 1e-12, "m": 3},
    }
    geometry = geometry | {"holes": [], "cracks": cracks}
    history = cfmpm.run(
        scene_from_dict(plate(LOADS["traction"], geometry=geometry, **fatigue))
    ).history
    waits = np.diff(history.crack_length[:, 0].values) == 0.0
    assert waits.any()
    assert {word for words in statuses(history)[:-1] for word in words} == {"growing"}
    assert (history.da_dN[:, 0] > 0.0).all()


def test_work_at_finite_deformation_is_summed_over_the_steps_in_between() -> None:
    """One recorded step with several solver steps: the work is closer to the energy."""
    geometry = plate([])["geometry"] | {"holes": [], "cracks": []}
    loads = [
        {"edge": "left", "displacement": {"x": 0}},
        {"point": [0, 0], "displacement": {"y": 0}},
        {"edge": "right", "displacement": {"x": 30}},
    ]
    scene = plate(loads, geometry=geometry, kinematics="finite", growth=None)
    history = cfmpm.run(scene_from_dict(scene | {"mesh": {"element": "T3", "size": 10}})).history
    assert history.sizes["step"] == 1
    assert int(history.substeps[0]) > 2
    force, motion = forces_and_motions(history)
    stored, work = float(history.strain_energy[0]), float(history.external_work[0])
    at_once = 0.5 * float((force * motion).sum())
    assert abs(work / stored - 1.0) < 0.3 * abs(at_once / stored - 1.0)
