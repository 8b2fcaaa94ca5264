"""Severed bodies: a free part carries only contact forces in equilibrium."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from posed import balanced, elastic, pose
from structured import rectangle

import cfmpm
from cfmpm.body.crack_faces import smallest_openings
from cfmpm.body.grid import Triangulation, build_grid
from cfmpm.body.loads import apply_loads
from cfmpm.body.points import seed
from cfmpm.equilibrium import stepping
from cfmpm.scene import scene_from_dict
from cfmpm.scene.loads import Load
from cfmpm.state import Result

SQUARE = [[0, 0], [10, 0], [10, 10], [0, 10]]


def run(loads: Any, cracks: Any, outline: Any = SQUARE, **more: Any) -> Result:
    scene = {
        "name": "apart",
        "geometry": {"outline": outline, "cracks": [{"points": points} for points in cracks]},
        "material": {"E": 1e4, "nu": 0.3, "g_c": 1e-3},
        "loads": loads,
        "mesh": {"element": "T6", "size": 1.0, "grading": "uniform"},
    }
    return cfmpm.run(scene_from_dict(scene | more))


def resultant(history: Any) -> np.ndarray:
    """Resultant of all forces on the body, relative to the largest force, by step."""
    forces = np.stack([history.reaction_x.values, history.reaction_y.values], axis=-1)
    forces = forces[np.isfinite(forces).all(axis=(1, 2))]
    return np.abs(forces.sum(axis=1)).max(axis=1) / np.abs(forces).max(axis=(1, 2))


@pytest.mark.parametrize("mesh", [{"element": "T6", "size": 1}, {"element": "T3", "size": 0.6}])
def test_a_corner_that_a_crack_cuts_off_is_pushed_away(mesh: dict[str, Any]) -> None:
    """Supported at the top, pressed from below; the crack grows out of the left side."""
    result = run(
        [
            {"edge": "edge_3", "displacement": {"x": 0, "y": 0}},
            {"edge": "edge_1", "traction": [0, 1]},
        ],
        [[[0, 2], [3, 4]]],
        mesh=mesh | {"grading": "uniform"},
        growth={"control": "crack", "direction": "max_energy"},
    )
    history = result.history
    assert history.attrs["run_status"] == "arrived"
    assert resultant(history).max() < 1e-9
    assert history.free_parts.values[-1] == 1
    # At a load that does not change, a longer crack stores more and sets energy free.
    assert history.load_factor.values[-1] == history.load_factor.values[-2]
    assert history.strain_energy.values[-1] > history.strain_energy.values[-2]
    assert (history.released_energy.values[1:] > 0.0).all()
    (part,) = result.loading.holds.free_parts
    inside = np.isin(result.grid.elements, part.nodes).all(axis=1)[result.body.integration.element]
    points = result.balance.points
    assert points.energy[inside].max() < 1e-20 * points.energy.max()
    # It has gone to where nothing overlaps.
    assert np.abs(result.displacement[part.nodes]).max() > 0.0
    largest = np.abs(result.displacement).max()
    assert min(smallest_openings(result.grid, result.displacement).values()) > -1e-9 * largest
    said = json.loads(history.attrs["warnings"])
    x, y = part.centre
    last = history.sizes["step"]
    assert any(
        text.startswith(f"from step {last} on the part of the body around ({x:.4g}, {y:.4g})")
        for text in said
    )


def on_grid(mesh: Triangulation, element: str, loads: list[dict[str, Any]], kinematics: str):
    """Solve on a grid in separate parts, which a scene cannot describe."""
    grid = build_grid(mesh, element)
    points = seed(grid)
    named = [Load.model_validate({"name": f"load_{i}", **load}) for i, load in enumerate(loads)]
    problem = pose(grid, apply_loads(named, {}, grid, points), elastic(6e3, 4e3), points)
    if kinematics == "finite":
        return problem, stepping.from_rest(problem, 1.0)
    return problem, balanced(problem)


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_a_block_that_is_cut_out_all_around_carries_a_pressure(element) -> None:
    """Hydrostatic pressure passes through the cracks; only contact holds the block."""
    mesh = rectangle(6, 6, 6.0, 6.0)
    corner = np.array([[2, 2], [3, 2], [4, 2], [4, 3], [4, 4], [3, 4], [2, 4], [2, 3], [2, 2]])
    loop = corner[:, 0] * 7 + corner[:, 1]
    mesh = replace(mesh, cracks={"loop": np.column_stack([loop[:-1], loop[1:]])})
    sides = {"bottom": [0, 10], "right": [-10, 0], "top": [0, -10], "left": [10, 0]}
    loads = [{"edge": edge, "traction": traction} for edge, traction in sides.items()]
    problem, state = on_grid(mesh, element, loads, "small")
    np.testing.assert_allclose(state.points.stress[:, :2], -10.0, rtol=1e-6)
    np.testing.assert_allclose(state.points.stress[:, 2], 0.0, atol=1e-5)
    holds = problem.loading.holds
    assert len(holds.free_parts) == 2
    for part in holds.free_parts:
        exchanged = state.contact_force[part.nodes].sum(axis=0)
        assert np.abs(exchanged).max() < 1e-9 * np.abs(state.contact_force).max()
    left = state.internal_force - state.contact_force - problem.loading.at(1.0).force
    assert np.abs(left[tuple(holds.places.T)]).max() < 1e-8 * np.abs(state.internal_force).max()


@pytest.mark.parametrize("kinematics", ["small", "finite"])
@pytest.mark.parametrize("element", ["T3", "T6"])
def test_a_half_that_nothing_holds_moves_on_with_the_one_that_is_driven(
    kinematics, element
) -> None:
    """The free half moves as a rigid body."""
    loads = [{"edge": "bottom", "displacement": {"x": 0, "y": 0.2}}]
    mesh = rectangle(4, 4, 4.0, 4.0, crack=(2, 0, 4))
    problem, state = on_grid(mesh, element, loads, kinematics)
    (part,) = problem.loading.holds.free_parts
    assert np.abs(state.points.stress).max() < 1e-10 * 1e4
    assert np.abs(state.contact_force).max() < 1e-10 * 1e4
    np.testing.assert_allclose(state.displacement[part.nodes, 1], 0.2, rtol=1e-5)
    assert min(smallest_openings(problem.grid, state.displacement).values()) > -1e-9
    assert np.abs(state.internal_force).max() < 1e-10 * 1e4


@pytest.mark.parametrize("mesh", [{"element": "T6", "size": 3}, {"element": "T3", "size": 2}])
def test_halves_of_a_bent_beam_do_not_press_on_what_no_support_holds(mesh) -> None:
    """A punch moves down: the right half rests on a roller and slides away."""
    history = run(
        [
            {"point": [10, 0], "displacement": {"x": 0, "y": 0}},
            {"point": [90, 0], "displacement": {"y": 0}},
            {"name": "punch", "box": [[47, 19.9], [53, 20.1]], "displacement": {"y": -0.1}},
        ],
        [[[50, 0], [50, 8]]],
        [[0, 0], [100, 0], [100, 20], [0, 20]],
        mesh=mesh,
        growth={"control": "crack", "direction": "max_hoop", "increments": 200},
        material={"E": 1e4, "nu": 0.3, "g_c": 0.1},
    ).history
    assert history.attrs["run_status"] == "arrived"
    assert history.contact_pairs.values[-1] == 0
    assert resultant(history).max() < 1e-9
    # At held grips a body that comes apart keeps less energy, not a hundred times as much.
    assert 0.0 < history.strain_energy.values[-1] < history.strain_energy.values[-2]
    assert history.released_energy.values[-1] > 0.0


@pytest.mark.parametrize("direction", ["cf", "max_hoop", "max_energy"])
def test_tips_in_a_part_that_carries_nothing_have_no_values(direction) -> None:
    """Values are nan instead of round-off: a grip moves its half away as a whole."""
    history = run(
        [
            {"edge": "edge_3", "displacement": {"x": 0, "y": 0.02}},
            {"edge": "edge_1", "displacement": {"x": 0, "y": 0}},
        ],
        [[[0, 4], [5, 4]], [[10, 8], [9, 8]]],
        growth={"control": "crack", "direction": direction, "tips": "largest"},
    ).history
    assert history.attrs["run_status"] == "stopped"
    last = history.isel(step=-1)
    for name in ("J", "G", "K_I", "K_II", "T_stress", "cf_norm", "G_kink", "critical_load_factor"):
        assert np.isnan(last[name]).all(), name
    assert np.isfinite(history.K_I.values[0]).all()
    assert not np.abs(last.reaction_y).any()
    said = json.loads(history.attrs["warnings"])
    assert not any("crack_2" in text and "J and G" in text for text in said)


def between_two_cracks(load: Any) -> Any:
    """A plate that the longer crack cuts in two, while the other one has not grown."""
    scene = {
        "name": "cut",
        "geometry": {
            "outline": [[0, 0], [60, 0], [60, 60], [0, 60]],
            "cracks": [
                {"name": "lower", "points": [[0, 20], [25, 20]]},
                {"name": "upper", "points": [[60, 40], [50, 40]]},
            ],
        },
        "material": {"E": 210e3, "nu": 0.3, "g_c": 2.5},
        "loads": [
            {"edge": "edge_3", **load},
            {"edge": "edge_1", "displacement": {"x": 0, "y": 0}},
        ],
        "mesh": {"element": "T3", "size": 4},
        "growth": {"control": "crack", "increments": 2000, "tips": "largest"},
    }
    return scene_from_dict(scene)


def statuses(history: Any) -> list[list[str]]:
    """Of all tips, by step."""
    names = history.tip_status.attrs["flag_meanings"].split()
    return [[names[int(value)] for value in step] for step in history.tip_status.values]


def test_an_ending_says_which_crack_has_cut_off_what() -> None:
    """A tip in one of the parts is not counted as arrested."""
    history = cfmpm.run(between_two_cracks({"traction": [0, 60]})).history
    assert statuses(history)[-1] == ["arrived_boundary", "severed"]
    assert "severed" not in {word for step in statuses(history)[:-1] for word in step}
    found = re.fullmatch(
        r"severed: the part of the body around \((.*), (.*)\) is severed, and no support holds it "
        "against the loads; severed by lower",
        history.attrs["ending"],
    )
    assert found is not None
    x, y = map(float, found.groups())
    assert 0 < x < 60
    assert 20 < y < 60


def test_tips_in_a_part_that_carries_nothing_stop() -> None:
    """A body cut in two between its grips: values at remaining tips are round-off."""
    pulled = between_two_cracks({"displacement": {"x": 0, "y": 0.02}})
    history = cfmpm.run(pulled).history
    assert history.attrs["ending"] == "stopped: no tip meets the criterion at any load"
    assert statuses(history)[-1][0] == "arrived_boundary"
    # The last state is that of the load of the one before: no load drives what is left.
    assert history.load_factor.values[-1] == history.load_factor.values[-2] < 1e3
