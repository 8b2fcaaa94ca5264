"""Choice of the kinematics, and its error."""

from __future__ import annotations

import json

import numpy as np
import pytest

import cfmpm
from cfmpm import mechanics
from cfmpm.equilibrium import small_strain
from cfmpm.errors import SolveError
from cfmpm.fracture.finite_effect import NEGLIGIBLE
from cfmpm.output.analysis import by_about
from cfmpm.output.warnings import of_history
from cfmpm.scene.reading import scene_from_dict

PLATE = {
    "name": "plate",
    "family": {
        "kind": "single_edge",
        "width": 50,
        "height": 80,
        "crack_length": 12,
        "traction": 1,
    },
    "material": {"E": 1e4, "nu": 0.3, "law": "ciarlet"},
    "mesh": {"element": "T3", "size": 8},
}


def plate(**changes):
    return scene_from_dict({**PLATE, **changes})


def pulled(traction, **changes):
    return plate(family={**PLATE["family"], "traction": traction}, **changes)


def test_levels():
    assert mechanics.load_levels(plate()) == [1.0]
    assert mechanics.load_levels(plate(load_steps=4)) == [0.25, 0.5, 0.75, 1.0]
    assert mechanics.load_levels(plate(load_steps=[1, -1])) == [1.0, -1.0]


class TestAuto:
    def test_keeps_small_strain_where_the_rest_is_negligible(self):
        auto, small = (cfmpm.run(pulled(1, kinematics=k)).history for k in ("auto", "small"))
        assert float(auto.substeps[0]) == 0
        assert 0 < float(auto.finite_effect[0]) < 1e-3
        assert float(small.finite_effect[0]) == float(auto.finite_effect[0])
        for name in ("J", "K_I", "cf_x", "strain_energy", "reaction_y"):
            assert float(auto[name].values.flat[0]) == float(small[name].values.flat[0])

    def test_takes_finite_deformation_where_it_is_not(self):
        auto, finite = (cfmpm.run(pulled(300, kinematics=k)).history for k in ("auto", "finite"))
        assert float(auto.substeps[0]) > 0
        assert float(auto.J[0, 0]) == float(finite.J[0, 0])

    def test_says_what_it_chose_and_why(self):
        auto = cfmpm.run(pulled(600, load_steps=[0.5, 0.0, 1.0])).history
        asked = cfmpm.run(pulled(600, kinematics="finite")).history
        effect = auto.finite_effect.values
        assert effect[2] > effect[0] > effect[1] == 0.0
        assert effect[2] > NEGLIGIBLE
        assert "chosen by kinematics: auto since it changes" in auto.attrs["kinematics"]
        said = auto.attrs["kinematics"]
        assert f"the strain energy {by_about(effect[2], 'finite_effect')}" in said
        in_J = auto.finite_effect_J.values[:, 0]
        assert in_J[2] < in_J[0] < in_J[1] == 0.0
        assert f"J {by_about(in_J[2], 'finite_effect_J')} in a load step" in said
        assert auto.attrs["kinematics"] in auto.attrs["formulation"]
        assert "auto" not in asked.attrs["kinematics"]
        small = cfmpm.run(pulled(1)).history
        assert small.attrs["kinematics"].startswith("small strain")

    def test_says_where_k_is_lost_and_what_brings_it_back(self):
        """Such strains occur only in gels. Small strain is recommended only where it is near."""
        history = cfmpm.run(pulled(3000)).history
        assert np.isnan(history.K_I.values).all()
        (text,) = (t for t in json.loads(history.warnings) if "K_I, K_II and T" in t)
        assert text.startswith("crack_1: in step 1 no K_I, K_II and T at finite deformation")
        assert float(history.finite_effect[0]) > 0.1
        assert text.endswith("A smaller load keeps K: at this one small strain is no approximation")
        assert np.isfinite(cfmpm.run(pulled(30)).history.K_I.values).all()
        size = "a strain energy that is 2 % and a J that is 4 % off"
        assert size in of_history._way_to_k(0.02, 0.04, backwards=False)
        alone = of_history._way_to_k(0.02, np.nan, backwards=False)
        assert alone.endswith("a strain energy that is 2 % off at the largest load (finite_effect)")
        assert "sense of the load alone" in of_history._way_to_k(0.02, 0.04, backwards=True)
        advised = cfmpm.run(pulled(300, kinematics="small")).history
        assert np.isfinite(advised.K_I.values).all()
        asked = cfmpm.run(pulled(3000, kinematics="finite")).history
        assert not any("K_I, K_II and T" in t for t in json.loads(asked.warnings))

    def test_small_strain_that_is_asked_for_is_judged_too(self):
        history = cfmpm.run(pulled(600, kinematics="small", load_steps=3)).history
        texts = [t for t in json.loads(history.warnings) if "neglected" in t]
        in_J = history.finite_effect_J.values[:, 0]
        of_J = f"J {by_about(in_J[2], 'finite_effect_J')} at crack_1, and K by half of that"
        effect = history.finite_effect.values
        of_energy = f"the strain energy {by_about(effect[2], 'finite_effect')}"
        assert len(texts) == 2
        for text, change, size in zip(texts, (of_energy, of_J), (effect, -in_J), strict=True):
            felt = 1 + np.flatnonzero(size > NEGLIGIBLE)
            steps = f"in steps {felt[0]} to 3 " if felt[0] < 3 else "in step 3 "
            assert text.startswith(steps)
            assert change in text
            assert "kinematics: finite takes it into account" in text
        advised = cfmpm.run(pulled(300, kinematics="finite")).history
        assert not any("neglected" in t for t in json.loads(advised.warnings))

    def test_a_failure_of_what_auto_chose_names_the_way_without(self):
        """A ligament of a hundredth of a millimetre, which bends more than a step allows."""
        family = {
            "kind": "single_edge",
            "width": 100,
            "height": 200,
            "crack_length": 99.9,
            "traction": 100,
        }
        scene = {"family": family, "material": {"E": 210e3, "nu": 0.3}, "mesh": {}}
        with pytest.raises(SolveError, match="auto; kinematics: small does without it"):
            cfmpm.run(plate(**scene))
        advised = cfmpm.run(plate(**scene, kinematics="small")).history
        assert advised.K_I.item() == pytest.approx(6.284e7, rel=0.01)
        assert "finite deformation is neglected" in advised.attrs["warnings"]

    def test_the_estimate_is_of_the_size_of_the_effect(self):
        small = cfmpm.run(pulled(20, kinematics="small")).history
        finite = cfmpm.run(pulled(20, kinematics="finite")).history
        # Under a dead load the change of the energy is its part of second order.
        change = abs(float(finite.strain_energy[0] / small.strain_energy[0]) - 1)
        assert 0.2 < float(small.finite_effect[0]) / change < 5

    def test_grows_in_proportion_to_the_load(self):
        effects = [float(cfmpm.run(pulled(t)).history.finite_effect[0]) for t in (1, 2)]
        assert effects[1] == pytest.approx(2 * effects[0], rel=0.02)

    def test_of_a_load_above_a_limit_no_size_is_told(self):
        """Of Hencky's law no state carries this load; at a thousandth the effect is small."""
        hencky = {"E": 1e4, "nu": 0.3}
        steps = {"load_steps": [1e-3, 1.0]}
        result = cfmpm.run(pulled(5e4, plane="stress", material=hencky, **steps))
        assert np.isinf(result.history.finite_effect.values).all()
        assert np.isinf(result.history.finite_effect_J.values).all()
        text = result.history.attrs["warnings"]
        assert (
            "change the strain energy by an amount that is not found (finite_effect: inf)" in text
        )
        assert "kinematics: finite needs plane: strain; to see the size, compare" in text

    def test_growth_stays_small_and_says_so(self):
        grown = cfmpm.run(
            pulled(
                300,
                material={"E": 1e4, "nu": 0.3, "g_c": 200.0},
                growth={"increments": 1},
            )
        )
        assert float(grown.history.substeps[0]) == 0
        assert "finite deformation is neglected" in grown.history.attrs["warnings"]
        text = grown.history.attrs["warnings"]
        assert "kinematics: finite needs growth.direction: cf; to see the size, compare" in text
        assert "small and finite without growth, at the load of the step" in text


def test_small_strain_is_solved_once_for_all_load_steps(monkeypatch):
    calls = []
    solve = small_strain.solve_linear
    monkeypatch.setattr(
        small_strain, "solve_linear", lambda *a, **k: calls.append(1) or solve(*a, **k)
    )
    steps = cfmpm.run(plate(load_steps=[0.5, 0.0, 2.0])).history
    assert len(calls) == 1
    for i, factor in enumerate((0.5, 0.0, 2.0)):
        np.testing.assert_allclose(steps.J[i], factor**2 * steps.J[2] / 4, rtol=1e-14)
        np.testing.assert_allclose(steps.K_I[i], factor * steps.K_I[2] / 2, rtol=1e-14)
        np.testing.assert_allclose(
            steps.external_work[i], steps.strain_energy[i], rtol=1e-12, atol=1e-15
        )


def test_what_was_left_out_is_said():
    finite = cfmpm.run(plate(kinematics="finite")).history
    assert "K_I, K_II, T" in finite.attrs["left_out"]
    assert "Newton" in " ".join(json.loads(cfmpm.run(plate()).history.attrs["left_out"]))
    assert "finite deformation" in finite.attrs["formulation"]
