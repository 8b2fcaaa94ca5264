"""What finite deformation is said to change, against runs at finite deformation."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import posed
import pytest
import xarray as xr
from outlines import named_rectangle

import cfmpm
from cfmpm import mechanics, simulation, steps
from cfmpm.build import build
from cfmpm.equilibrium import correction
from cfmpm.fracture import finite_effect
from cfmpm.fracture.finite_effect import NEGLIGIBLE
from cfmpm.output.checkpoint import Start
from cfmpm.output.record import Record
from cfmpm.registry.laws import LAWS
from cfmpm.scene import expand, load_scene, scene_from_dict

STEEL = {"E": 2e5, "nu": 0.3}


def family(kind: str, size: float = 5.0, **keys: Any) -> dict[str, Any]:
    """A specimen of steel."""
    return {"family": {"kind": kind, **keys}, "material": STEEL, "mesh": {"size": size}}


def body(
    width: float, height: float, crack: list[list[float]], loads: list[Any], size: float = 5.0
) -> dict[str, Any]:
    """A rectangle of steel with one crack."""
    return {
        "geometry": {"outline": named_rectangle(width, height), "cracks": [{"points": crack}]},
        "loads": loads,
        "material": STEEL,
        "mesh": {"size": size},
    }


def single_edge(a: float, traction: float, height: float = 3.0) -> dict[str, Any]:
    """An edge-cracked plate by crack length and height over a width of 50 mm."""
    lengths = {"width": 50, "height": 50 * height, "crack_length": 50 * a}
    return family("single_edge", **lengths, traction=traction)


CLAMPED = {"edge": "bottom", "displacement": {"x": 0, "y": 0}}
ALL_ROUND = [
    {"edge": edge, "traction": [1e3 * x, 1e3 * y]}
    for edge, (x, y) in {"top": (0, 1), "bottom": (0, -1), "left": (-1, 0), "right": (1, 0)}.items()
]
APART = [
    {"name": "up", "point": [0, 10], "displacement": {"x": 0, "y": 1}},
    {"name": "down", "point": [0, 0], "displacement": {"x": 0, "y": -1}},
]
ARCH = [[30, 50], [36, 55], [44, 59], [50, 60], [56, 59], [64, 55], [70, 50]]
SCENES = {
    "long_crack": single_edge(0.9, 3.0),
    "half_cracked": single_edge(0.5, 100.0),
    # The effect on the energy is below 0.1 %.
    "short_crack": single_edge(0.24, 250.0),
    "centre_crack": family("centre_crack", 8, width=100, height=200, crack_length=40, traction=800),
    "slanted": family(
        "centre_crack", 8, width=100, height=200, crack_length=40, crack_angle=45, traction=1000
    ),
    "compact_tension": family("compact_tension", width=50, crack_length=25, force=3000),
    "bend": family(
        "three_point_bend",
        2,
        length=20,
        height=8,
        span=18,
        crack_length=1.5,
        crack_offset=-5,
        force=3e3,
    ),
    "biaxial": body(100, 100, [[35, 50], [65, 50]], ALL_ROUND, 8),
    "sheared": body(
        100, 100, [[0, 50], [50, 50]], [CLAMPED, {"edge": "top", "traction": [100, 0]}]
    ),
    "gripped": body(
        50, 100, [[0, 50], [25, 50]], [CLAMPED, {"edge": "top", "displacement": {"x": 0, "y": 1}}]
    ),
    "double_cantilever": body(100, 10, [[0, 5], [60, 5]], APART, 2.5),
    "heavy": body(
        50,
        150,
        [[0, 75], [20, 75]],
        [{"edge": "top", "displacement": {"x": 0, "y": 0}}, {"body_force": [0, -5]}],
    ),
    "closed_arch": body(100, 100, ARCH, [CLAMPED, {"edge": "top", "traction": [50, -100]}]),
}


def run(scene: dict[str, Any], **changes: Any) -> xr.Dataset:
    return cfmpm.run(scene_from_dict({"name": "scene", **scene, **changes})).history


def changed(scene: dict[str, Any], small: xr.Dataset) -> Any:
    """What finite deformation does change."""
    return run(scene, kinematics="finite").J.values[-1] / small.J.values[-1] - 1.0


@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("name", SCENES)
def test_the_estimate_is_the_change_of_j(name: str, element: str) -> None:
    scene = SCENES[name] | {"mesh": SCENES[name]["mesh"] | {"element": element}}
    small = run(scene, kinematics="small")
    change = changed(scene, small)
    assert 2e-3 < np.abs(change).max() < 0.1
    # What is left is of second order.
    np.testing.assert_allclose(small.finite_effect_J.values[-1], change, rtol=0.15)


ARM = {"edge": "left", "displacement": {"x": 0, "y": 0}}


def cantilever(length: float, traction: float, **steel: Any) -> dict[str, Any]:
    """A beam of 5 mm height that a shear traction bends."""
    return {
        "geometry": {"outline": named_rectangle(length, 5)},
        "loads": [ARM, {"edge": "right", "traction": [0, traction]}],
        "material": STEEL | steel,
        "mesh": {"size": 2.5},
    }


def beams(opening: float) -> dict[str, Any]:
    """Two slender arms, 140 mm long and 5 mm high, pulled apart to each side."""
    apart = [load | {"displacement": {"x": 0, "y": y}} for load, y in zip(APART, (1, -1), strict=1)]
    for load in apart:
        load["displacement"]["y"] *= opening
    return body(200, 10, [[0, 5], [140, 5]], apart, 2.5)


def block(nu: float, **law: Any) -> dict[str, Any]:
    """A block of 20 mm that is pressed, 4 % of E."""
    return {
        "geometry": {"outline": named_rectangle(20, 20)},
        "loads": [CLAMPED, {"edge": "top", "traction": [0, -40]}],
        "material": {"E": 1e3, "nu": nu} | law,
        "mesh": {"size": 3},
    }


BEND = {"length": 220, "height": 20, "span": 200, "crack_length": 5}
# Largest changes of the energy and of J: where bodies bend, the work that small strain leaves
# unbalanced is up to 1e4 times as large.
LARGE = {
    "cantilever": cantilever(200, 1),
    "cantilever_far": cantilever(200, 10),
    "long_cantilever": cantilever(400, 0.5),
    "beams": beams(2),
    "beams_far": beams(20),
    "bend": family("three_point_bend", 5, **BEND, force=800),
    "bend_far": family("three_point_bend", 5, **BEND, force=3000),
    "nearly_incompressible": block(0.4999999),
    "incompressible_to_a_thousandth": block(0.499),
    "ligament": single_edge(0.9, 30),
    "plate": single_edge(0.3, 1500),
    "sheared": body(
        100, 100, [[0, 50], [50, 50]], [CLAMPED, {"edge": "top", "traction": [400, 0]}]
    ),
    "pressed": body(
        100, 100, [[0, 50], [50, 50]], [CLAMPED, {"edge": "top", "traction": [500, -500]}]
    ),
    "closed_far": body(100, 100, ARCH, [CLAMPED, {"edge": "top", "traction": [300, -600]}]),
    # Its faces are closed by the bend, which turns them.
    "closed_beam": body(
        200, 10, [[100, 10], [100, 6]], [ARM, {"edge": "right", "traction": [0, 1]}], 2.5
    ),
}
LAWS_OF = {
    f"{name}_{law}": {**scene, "material": scene["material"] | {"law": law}}
    for law in LAWS
    if not LAWS[law].plastic
    for name, scene in {
        "plate": single_edge(0.3, 800),
        "ligament": single_edge(0.9, 10),
        "cantilever": cantilever(200, 1),
        "block": block(0.4999999),
    }.items()
}


# A crack from hole to hole, without a tip, whose faces press on each other.
_HOLES = [{"circle": {"centre": [x, 50], "radius": 8}} for x in (30, 70)]
LARGE["without_tips"] = body(
    100, 100, [[38, 50], [62, 50]], [CLAMPED, {"edge": "top", "displacement": {"x": 0, "y": -3}}]
)
LARGE["without_tips"]["geometry"]["holes"] = _HOLES


@pytest.mark.slow
@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("scene", (LARGE | LAWS_OF).values(), ids=LARGE | LAWS_OF)
def test_a_large_change_is_told_by_its_size(scene: dict[str, Any], element: str) -> None:
    scene = scene | {"mesh": scene["mesh"] | {"element": element}}
    small, finite = (run(scene, kinematics=kinematics) for kinematics in ("small", "finite"))
    change = float(finite.strain_energy[-1] / small.strain_energy[-1]) - 1.0
    # Below a thousandth no size is needed.
    assert float(small.finite_effect[-1]) == pytest.approx(abs(change), rel=0.03, abs=3e-5)
    np.testing.assert_allclose(
        small.finite_effect_J.values[-1],
        finite.J.values[-1] / small.J.values[-1] - 1.0,
        rtol=0.03,
        atol=3e-5,
    )


def test_between_loads_the_change_is_interpolated() -> None:
    """By its slope at zero and its size at the largest load."""
    plate, steps = single_edge(0.3, 1500), [0.1, 0.25, 0.5, 0.75, 1.0]
    small, finite = (run(plate, kinematics=k, load_steps=steps) for k in ("small", "finite"))
    change = finite.J.values[:, 0] / small.J.values[:, 0] - 1.0
    np.testing.assert_allclose(small.finite_effect_J.values[:, 0], change, rtol=0.05)


def test_plane_stress_is_compared_with_its_equivalent() -> None:
    """Plane strain with the same stiffness in the plane has another Poisson's ratio."""
    plate = single_edge(0.5, 200)
    E, nu = STEEL["E"], STEEL["nu"]
    alike = {"E": E * (1 + 2 * nu) / (1 + nu) ** 2, "nu": nu / (1 + nu)}
    small = run(plate, plane="stress")
    finite = run(plate | {"material": alike}, kinematics="finite")
    assert float(small.strain_energy[0]) == pytest.approx(
        run(plate | {"material": alike}, kinematics="small").strain_energy.item(), rel=1e-9
    )
    changes = (finite[name].values[0] / small[name].values[0] - 1.0 for name in ("J",))
    np.testing.assert_allclose(small.finite_effect_J.values[0], next(changes), rtol=0.01)
    assert small.finite_effect_J.values[0] < -NEGLIGIBLE


@pytest.mark.parametrize("name", ["cantilever", "beams", "bend", "nearly_incompressible"])
def test_auto_goes_by_the_size(name: str) -> None:
    """Where only the estimate is large, one linear solve is left, and nothing to tell."""
    scene = LARGE[name] | (
        {"loads": [CLAMPED, {"edge": "top", "traction": [0, -5]}]}
        if name == "nearly_incompressible"
        else {}
    )
    full = scene_from_dict({"name": "scene", **scene})
    made = mechanics.problem_of(*mechanics.locate(build(expand(full))))
    assert finite_effect.on_energy(made, posed.balanced(made))[0] > 3 * NEGLIGIBLE
    history = run(scene)
    assert not history.substeps.any()
    assert float(history.finite_effect[-1]) < NEGLIGIBLE
    assert "neglected" not in history.attrs["warnings"]


def test_growth_is_judged_by_the_load_of_growth() -> None:
    """Of a growing crack too, from the first step on, whose load is not known before."""
    plate = single_edge(0.5, 1.0) | {"material": STEEL | {"g_c": 300.0}}
    grown = run(plate | {"growth": {"control": "crack", "increments": 1}})
    first = float(grown.load_factor[0])
    small, finite = (run(single_edge(0.5, first), kinematics=k) for k in ("small", "finite"))
    change = float(finite.J[0, 0] / small.J[0, 0]) - 1.0
    assert float(grown.finite_effect_J[0, 0]) == pytest.approx(change, rel=0.02)
    assert change < -5 * NEGLIGIBLE


def test_a_change_of_j_is_told_where_that_of_the_energy_is_small() -> None:
    """The tension straightens a long plate; its energy hardly changes. The advice is what helps."""
    plate = single_edge(0.3, 80.0, height=8.0)
    small = run(plate, kinematics="small", load_steps=[0.1, 0.9, 1.0])
    assert float(small.finite_effect[-1]) < 1e-3
    effect = small.finite_effect_J.values[:, 0]
    np.testing.assert_allclose(effect, effect[-1] * small.load_factor, rtol=0.05)
    assert effect[-1] < -NEGLIGIBLE
    (said,) = (text for text in json.loads(small.warnings) if "neglected" in text)
    felt = 1 + int(np.argmax(np.abs(effect) > NEGLIGIBLE))
    assert felt == 2
    assert said == (
        "in steps 2 to 3 finite deformation is neglected, which would "
        f"change J by about {100 * effect[-1]:.2g} % (finite_effect_J) at crack_1, and K by half "
        "of that; kinematics: finite takes it into account"
    )
    advised = run(plate, kinematics="finite")
    assert advised.J.values[-1, 0] / small.J.values[-1, 0] - 1.0 == pytest.approx(effect[-1], 0.01)
    assert not any("neglected" in text for text in json.loads(advised.warnings))


def test_auto_goes_by_j_too() -> None:
    """J of this beam changes by 2 %, its energy by little more than a thousandth."""
    path = Path(__file__).parents[2] / "configs/examples/three_point_bend.yaml"
    history = cfmpm.run(load_scene(path)).history
    assert float(history.substeps[-1]) > 0
    assert float(history.finite_effect[-1]) < 2e-3
    effect = float(history.finite_effect_J[-1, 0])
    small = cfmpm.run(load_scene(path, {"kinematics": "small"})).history
    assert float(history.J[-1, 0] / small.J[-1, 0]) - 1.0 == pytest.approx(effect, rel=0.01)
    assert effect > NEGLIGIBLE
    assert f"J by about {100 * effect:.2g} % (finite_effect_J)" in history.attrs["kinematics"]
    assert np.isfinite(history.K_I.values).all()


def test_a_body_that_hardly_strains_pays_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def nothing(*arguments: Any) -> Any:
        raise AssertionError("not needed")

    monkeypatch.setattr(correction, "first_correction", nothing)
    monkeypatch.setattr(correction, "settled", nothing)
    history = run(single_edge(0.3, 5.0))
    assert np.isnan(history.finite_effect_J.values).all()
    assert 0.0 < float(history.finite_effect[-1]) < 1e-4
    growth = {"growth": {"control": "load", "increments": 2}}
    steel = {"material": STEEL | {"g_c": 1e-3}}
    assert run(single_edge(0.3, 5.0) | growth | steel).sizes["step"] == 3


def test_a_load_that_is_found_is_judged_by_the_last_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Under crack control the load of the first step is not known: there J is always looked at."""
    calls, first = [], correction.first_correction
    monkeypatch.setattr(correction, "first_correction", lambda *a: calls.append(1) or first(*a))
    monkeypatch.setattr(finite_effect, "LOOKED_AT", np.inf)
    plate = single_edge(0.3, 1.0) | {"growth": {"control": "crack", "increments": 3}}
    for g_c, looks in ((1e-3, 1), (10.0, 3)):
        calls.clear()
        history = run(plate | {"material": STEEL | {"g_c": g_c}})
        assert history.sizes["step"] == 4
        assert len(calls) == looks + (looks > 1)
        found = np.isfinite(history.finite_effect_J.values[:, 0])
        assert found.sum() == len(calls)


def test_fixed_loads_count_too() -> None:
    """The estimate of loads one of which is fixed is that of all of them together."""
    scene = single_edge(0.5, 40.0) | {"kinematics": "small", "name": "plate"}
    together = run(scene).finite_effect_J.values[-1]
    full = scene_from_dict(scene)
    stage = steps.begin(full, {"top", "bottom"})
    result = simulation.run(full, start=Start(stage, Record.of(full, stage)))
    np.testing.assert_allclose(result.history.finite_effect_J.values[-1], together, rtol=1e-9)


def test_auto_looks_at_all_loads_that_are_reached() -> None:
    """In the first step a fixed load holds the crack shut: its tip has no J then."""
    scene = single_edge(0.5, 1.0) | {"name": "plate", "load_steps": [0.05, 1.0]}
    del scene["family"]["traction"]
    pull, press = (
        [{"name": f"{edge}_{y}", "edge": edge, "traction": [0, y]} for edge, y in pair.items()]
        for pair in ({"top": 300, "bottom": -300}, {"top": -60, "bottom": 60})
    )
    full = scene_from_dict(scene | {"loads": pull + press})
    stage = steps.begin(full, {load["name"] for load in press})
    history = simulation.run(full, start=Start(stage, Record.of(full, stage))).history
    assert float(history.substeps[-1]) > 0
    asked = run(single_edge(0.5, 240.0), kinematics="small").finite_effect_J.values[-1, 0]
    assert float(history.finite_effect_J[-1, 0]) == pytest.approx(asked, rel=1e-3)


def test_a_crack_that_is_pressed_shut_has_no_j_to_change() -> None:
    """All the J of this beam, bent the other way, is an error of the grid."""
    lengths = {"length": 220, "height": 50, "span": 200, "crack_length": 25}
    shut = family("three_point_bend", 15, **lengths, force=-2000)
    history = run(shut, kinematics="small", mesh={"element": "T3", "size": 15})
    assert 0.0 < history.J.values[-1, 0] < history.G_floor.values[-1, 0]
    assert float(history.contact_pairs[-1]) > 0
    assert np.isnan(history.finite_effect_J.values).all()
    assert "change J" not in history.attrs["warnings"]
