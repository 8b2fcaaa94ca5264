"""Only the product of load and load factor matters."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr

import cfmpm
from cfmpm.equilibrium.newton import RESIDUAL
from cfmpm.fracture.finite_effect import NEGLIGIBLE
from cfmpm.output.fields import build_fields
from cfmpm.scene.reading import scene_from_dict

# Not functions of the product alone: the factor itself, what is measured in it, wall times.
OF_THE_FACTOR = ["load_factor", "critical_load_factor", "wall_time", "force_imbalance"]
# Powers of two multiply without round-off.
EQUIVALENT = [(2.0, 1.0), (1.0, 2.0), (0.5, 4.0), (4.0, 0.5)]

PLATE: dict[str, Any] = {
    "name": "plate",
    "family": {
        "kind": "single_edge",
        "width": 50,
        "height": 80,
        "crack_length": 12,
        "traction": 1,
    },
    "material": {"E": 1e4, "nu": 0.3, "g_c": 0.01},
    "mesh": {"element": "T3", "size": 8},
}


def pulled(load: float, **changes: Any) -> dict[str, Any]:
    """The plate under a traction."""
    return PLATE | {"family": PLATE["family"] | {"traction": load}} | changes


def mixed(load: float, **changes: Any) -> dict[str, Any]:
    """The plate under shear, compression, displacement and weight; its crack closes in part."""
    loads = [
        {"edge": "bottom", "displacement": {"x": 0, "y": 0}},
        {"edge": "top", "displacement": {"x": 0.01 * load}},
        {"edge": "top", "traction": [0, -2 * load]},
        {"edge": "right", "traction": [0.3 * load, load]},
        {"body_force": [1e-3 * load, 2e-3 * load]},
    ]
    family = {name: value for name, value in PLATE["family"].items() if name != "traction"}
    return PLATE | {"family": family, "loads": loads} | changes


def run(scene: dict[str, Any]) -> cfmpm.simulation.Result:
    return cfmpm.run(scene_from_dict(scene))


def assert_same(found: xr.Dataset, expected: xr.Dataset, rtol: float = 1e-12) -> None:
    """Compare all numbers of two datasets, each variable relative to its largest value."""
    kept = [dataset.drop_vars(OF_THE_FACTOR, errors="ignore") for dataset in (found, expected)]
    assert set(kept[0].variables) == set(kept[1].variables)
    for name, values in kept[1].variables.items():
        if values.dtype.kind in "fi":
            atol = rtol * np.abs(values.values[np.isfinite(values.values)]).max(initial=0.0)
            np.testing.assert_allclose(kept[0][name], values, rtol=0.0, atol=atol, err_msg=name)


@pytest.mark.parametrize("scene", [pulled, mixed])
@pytest.mark.parametrize("steps", [[1.0], [0.25, 1.0, 0.5]], ids=["one_step", "three_steps"])
def test_at_small_strain(scene: Any, steps: list[float]) -> None:
    results = [
        run(scene(load, load_steps=[factor * part for part in steps]))
        for load, factor in EQUIVALENT
    ]
    for result, (load, _) in zip(results, EQUIVALENT, strict=True):
        assert float(result.history.substeps[-1]) == 0
        assert_same(result.history, results[0].history)
        assert_same(build_fields(result), build_fields(results[0]))
        assert result.history.attrs["warnings"] == results[0].history.attrs["warnings"]
        np.testing.assert_allclose(
            load * result.history.critical_load_factor,
            2.0 * results[0].history.critical_load_factor,
            rtol=1e-12,
        )
    if scene is mixed:
        assert float(results[0].history.contact_pairs[-1]) > 0


@pytest.mark.parametrize("scene", [pulled, mixed])
def test_at_finite_deformation(scene: Any) -> None:
    """The load may also be reversed: minus the load times minus the factor."""
    material = {"E": 1e3, "nu": 0.3, "law": "ciarlet"}
    results = [
        run(
            scene(
                10.0 * load,
                kinematics="finite",
                material=material,
                load_steps=[0.5 * factor, factor],
            )
        )
        for load, factor in [*EQUIVALENT, (-2.0, -1.0), (-0.5, -4.0)]
    ]
    # Newton's method leaves up to RESIDUAL of the forces unbalanced: what is left of that, and of
    # the overlap of pressed faces, is no number to compare.
    left = ["residual_norm", "min_opening"]
    first, *others = (result.history.drop_vars(left) for result in results)
    for result, history in zip(results[1:], others, strict=True):
        assert_same(history, first, 100 * RESIDUAL)
        assert_same(build_fields(result), build_fields(results[0]), 100 * RESIDUAL)


def test_at_which_cracks_run() -> None:
    """Equal under load control; under crack control the load factor adapts."""
    for control, level in (("load", [0.5, 1.0]), ("crack", [1.0])):
        histories = []
        for load, factor in EQUIVALENT:
            steps = [factor * part for part in level] if control == "load" else 1
            growth = {"control": control, "increments": 2}
            histories.append(run(pulled(5.0 * load, growth=growth, load_steps=steps)).history)
        for history, (load, _) in zip(histories, EQUIVALENT, strict=True):
            first = histories[0]
            assert first.sizes["step"] > 2
            np.testing.assert_allclose(
                load * history.load_factor, 2.0 * first.load_factor, rtol=1e-12
            )
            assert_same(history, first)


class TestWarningOfFiniteDeformation:
    """The warning depends on the load that is reached, in any notation."""

    SAID = "finite deformation is neglected, which would change the strain energy"
    OF_J = "finite deformation is neglected, which would change J"

    @pytest.mark.parametrize(("load", "factor"), [(load / 2, f) for load, f in EQUIVALENT])
    @pytest.mark.parametrize(
        ("stress", "warned", "of_J"),
        [(15.0, False, False), (80.0, False, True), (240.0, *2 * [True])],
    )
    def test_of_load_steps(
        self, load: float, factor: float, stress: float, warned: bool, of_J: bool
    ) -> None:
        scene = pulled(stress * load, plane="stress", load_steps=[0.5 * factor, factor])
        history = run(scene).history
        assert (float(history.finite_effect.max()) > NEGLIGIBLE) == warned
        assert (self.SAID in history.attrs["warnings"]) == warned
        assert (float(abs(history.finite_effect_J).max()) > NEGLIGIBLE) == of_J
        assert (self.OF_J in history.attrs["warnings"]) == of_J

    @pytest.mark.parametrize("load", [1.0, 1000.0])
    @pytest.mark.parametrize(("g_c", "warned"), [(1e-3, False), (400.0, True)])
    def test_of_the_load_at_which_a_crack_runs(self, load: float, g_c: float, warned: bool) -> None:
        material = PLATE["material"] | {"g_c": g_c}
        growth = {"control": "crack", "increments": 1}
        history = run(pulled(load, material=material, growth=growth)).history
        assert (float(history.finite_effect.max()) > NEGLIGIBLE) == warned
        assert (self.SAID in history.attrs["warnings"]) == warned
        assert (self.OF_J in history.attrs["warnings"]) == warned

    @pytest.mark.parametrize(("load", "factor"), [(load / 2, f) for load, f in EQUIVALENT])
    def test_auto_chooses_by_the_largest_load(self, load: float, factor: float) -> None:
        for stress, finite in ((15.0, False), (30.0, True)):
            steps = [0.25 * factor, factor, 0.5 * factor]
            history = run(pulled(stress * load, load_steps=steps)).history
            assert (float(history.substeps[-1]) > 0) == finite
