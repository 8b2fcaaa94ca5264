"""Every warning names tips, steps, size and an action, which removes the warning."""

from __future__ import annotations

import json
import re
from typing import Any, ClassVar

import numpy as np
import pytest
import xarray as xr

import cfmpm
from cfmpm.output.warnings.doubt import SIZE, Doubt, Doubts
from cfmpm.scene import scene_from_dict

OUTLINE = [
    {"at": [0, 0], "edge": "bottom"},
    {"at": [60, 0], "edge": "right"},
    {"at": [60, 60], "edge": "top"},
    {"at": [0, 60], "edge": "left"},
]
PULL = [{"edge": "bottom", "traction": [0, -1]}, {"edge": "top", "traction": [0, 1]}]


def plate(**changes: Any) -> dict[str, Any]:
    """A plate in tension with an edge crack of 10 mm."""
    return {
        "name": "plate",
        "geometry": {"outline": OUTLINE, "cracks": [{"points": [[0, 30], [10, 30]]}]},
        "material": {"E": 3000.0, "nu": 0.3, "g_c": 0.1},
        "loads": PULL,
        "mesh": {"size": 6},
    } | changes


def solved(scene: dict[str, Any]) -> xr.Dataset:
    return cfmpm.run(scene_from_dict(scene)).history


def warnings_of(scene: dict[str, Any]) -> list[str]:
    found: list[str] = json.loads(solved(scene).attrs["warnings"])
    return found


def the_warning(scene: dict[str, Any], part: str) -> str:
    (text,) = (text for text in warnings_of(scene) if part in text)
    return text


def number_behind(text: str, words: str) -> float:
    found = re.search(rf"{re.escape(words)} ([\d.e+-]*\d)", text)
    assert found is not None, text
    return float(found[1])


def gone(scene: dict[str, Any], part: str) -> bool:
    return not any(part in text for text in warnings_of(scene))


class TestStepsAndSizes:
    def test_steps_of_a_doubt_and_its_largest_size(self) -> None:
        doubts = Doubts()
        for step, size in ((2, 0.5), (3, 0.75), (5, 0.25)):
            doubts.add(step, [Doubt(f"it is off by {SIZE} %", "crack_1", size)])
        assert doubts.said() == ["crack_1: in 3 of the steps 2 to 5 it is off by 0.75 %"]
        assert Doubts(json.loads(json.dumps(doubts.listed()))).said() == doubts.said()

    def test_of_the_whole_body_and_before_any_step(self) -> None:
        assert Doubt("it is off").said([4]) == "in step 4 it is off"
        assert Doubt("it is off", "crack_1").said() == "crack_1: it is off"


class TestElementsAtTips:
    """The recommended element size removes the warning, for any grading."""

    @pytest.mark.parametrize("grading", ["uniform", {"tip_size": 2.5}])
    def test_j_and_g_differ(self, grading: Any) -> None:
        coarse = plate(mesh={"size": 6, "element": "T3", "grading": grading})
        part = "J and G from K_I and K_II differ"
        text = the_warning(coarse, part)
        assert text.startswith("crack_1: in step 1 J and G")
        assert re.search(r"differ by up to [\d.]+ % of the larger one", text)
        assert "mesh.size" not in text
        for _ in range(4):
            size = number_behind(text, "set mesh.grading.tip_size to at most")
            finer = coarse | {"mesh": coarse["mesh"] | {"grading": {"tip_size": size}}}
            if gone(finer, part):
                break
            text = the_warning(finer, part)
        assert gone(finer, part)

    @pytest.mark.parametrize("radii", [[0.5], [6.0]])
    def test_a_domain_of_few_elements(self, radii: list[float]) -> None:
        mesh = {"size": 6, "grading": {"tip_size": 2.0}}
        scene = plate(mesh=mesh, fracture={"radii": radii})
        part = "below 4 element sizes"
        text = the_warning(scene, part)
        assert text.startswith(f"crack_1: in step 1 the largest domain radius is {radii[0]:.3g} mm")
        size = number_behind(text, "set mesh.grading.tip_size to at most")
        # The size of the triangles of a grid differs from that asked for.
        finer = mesh | {"grading": {"tip_size": 0.8 * size}}
        assert gone(scene | {"mesh": finer}, part)

    def test_reduced_radii(self) -> None:
        scene = plate(fracture={"radii": [15.0]})
        text = the_warning(scene, "requested domain radii were reduced")
        assert text.startswith("crack_1: in step 1 ")
        radius = number_behind(text, "up to that, here")
        kept = scene | {"fracture": {"radii": [radius]}}
        assert gone(kept, "requested domain radii")
        np.testing.assert_allclose(solved(kept)["domain_radius"], radius)


class TestDependenceOnTheDomain:
    def rubber(self, law: str, tip_size: float) -> dict[str, Any]:
        return plate(
            material={"E": 10.0, "nu": 0.3, "law": law},
            kinematics="finite",
            load_steps=2,
            loads=[
                {"edge": "bottom", "displacement": {"x": 0, "y": 0}},
                {"edge": "top", "displacement": {"x": 0, "y": 25}},
            ],
            mesh={"size": 6, "element": "T3", "grading": {"tip_size": tip_size}},
            fracture={"radii": [2.0, 6.0]},
        )

    def test_of_hencky_s_law_is_no_matter_of_the_grid(self) -> None:
        part = "J depends on the domain"
        text = the_warning(self.rubber("hencky", 2.0), part)
        assert text.startswith("crack_1: in step")
        assert re.search(r"differs by up to [\d.]+ % between the domain radii", text)
        assert "tip_size" not in text
        assert "material.law: ciarlet" in text
        assert gone(self.rubber("ciarlet", 2.0), part)
        unstable = [solved(self.rubber("hencky", h))["unstable_points"].max() for h in (2.0, 0.5)]
        assert unstable[1] > unstable[0] > 0

    def test_ellipticity(self) -> None:
        text = the_warning(self.rubber("hencky", 2.0), "have lost ellipticity (unstable_points)")
        assert re.match(r"in steps? [\d to]+ up to \d+ material points have lost", text)
        assert gone(self.rubber("ciarlet", 2.0), "ellipticity")


class TestGrowth:
    def crossing(self, **changes: Any) -> dict[str, Any]:
        return plate(
            growth={"control": "crack", "increments": 16},
            mesh={"size": 4, "grading": {"tip_size": 0.3}},
            **changes,
        )

    def test_a_tip_that_leaves_the_refined_grid(self) -> None:
        part = "has left the refined part"
        text = the_warning(self.crossing(), part)
        assert text.startswith("crack_1: in steps ")
        refine = number_behind(text, "fracture.refine:")
        assert gone(self.crossing(fracture={"refine": refine}), part)

    def test_elements_that_the_user_has_chosen_are_no_doubt(self) -> None:
        scene = self.crossing(fracture={"refine": 3.0})
        history = solved(scene)
        assert history["tip_size"].max() > 3.0 * history["tip_size"][0, 0]
        assert "has left the refined part" not in history.attrs["warnings"]

    def test_little_clearance(self) -> None:
        """A crack that passes a hole at a distance of less than three elements."""
        scene = plate(growth={"control": "crack", "increments": 14}, mesh={"size": 8})
        scene["geometry"] = {
            "outline": OUTLINE,
            "cracks": [{"points": [[0, 30], [10, 30]]}],
            "holes": [{"circle": {"centre": [20, 39], "radius": 4}}],
        }
        scene["mesh"] = {"size": 3, "grading": "uniform"}
        part = "the direction of growth is inaccurate"
        text = the_warning(scene, part)
        assert re.match(r"crack_1: in steps? [\d to]+ the clearance is down to [\d.]+ mm", text)
        assert "mesh.hole_size" not in text
        refine = number_behind(text, "set fracture.refine to at most")
        scene["growth"]["increments"] = 60
        assert gone(scene | {"fracture": {"refine": refine}}, part)


class TestLoads:
    def test_a_traction_on_a_support(self) -> None:
        bottom = {"edge": "bottom", "displacement": {"x": 0, "y": 0}}
        grip = {"name": "grip", "box": [[0, 59], [15, 61]], "displacement": {"y": 0.1}}
        pull = {"edge": "top", "traction": [0, 1]}
        text = the_warning(plate(loads=[bottom, grip, pull]), "carried by that support alone")
        share = re.match(r"loads\[2\].traction: ([\d.]+) % of top acts where u_y is", text)
        assert share is not None
        assert float(share[1]) == pytest.approx(25.0, abs=5.0)
        assert text.endswith("take it off there, or leave u_y free there")
        rest = {"name": "rest", "box": [[15.1, 59], [61, 61]], "traction": [0, 1]}
        assert gone(plate(loads=[bottom, grip, rest]), "that support")
        free = grip | {"displacement": {"x": 0}}
        assert gone(plate(loads=[bottom, free, pull]), "that support")

    def test_no_load(self) -> None:
        part = "the body has no load"
        nothing = [{"edge": "bottom", "displacement": {"x": 0, "y": 0}}]
        assert "add a traction" in the_warning(plate(loads=nothing), part)
        assert gone(plate(loads=[*nothing, PULL[1]]), part)

    @pytest.mark.parametrize(("key", "value"), [("E", 210e9), ("g_c", 1e5)])
    def test_other_units(self, key: str, value: float) -> None:
        scene = plate()
        usual = scene["material"]
        scene["material"] = usual | {key: value}
        assert the_warning(scene, "usual range").startswith(f"material.{key}: {value:g} ")
        assert gone(scene | {"material": usual}, "usual range")


SOFT = {"kinematics": "finite", "load_steps": 2, "material": {"E": 100.0, "nu": 0.3}}
PUSH = [{"edge": "bottom", "traction": [0, 1]}, {"edge": "top", "traction": [0, -1]}]
SHEAR = [
    {"edge": "bottom", "traction": [-1, 0]},
    {"edge": "top", "traction": [1, 0]},
    {"edge": "left", "traction": [0, -1]},
    {"edge": "right", "traction": [0, 1]},
]


class TestMomentOnTheDeformedBody:
    @pytest.mark.parametrize("loads", [PUSH, SHEAR])
    def test_a_support_takes_the_moment(self, loads: list[Any]) -> None:
        scene = plate(loads=loads, **SOFT)
        part = "have a moment on the deformed body"
        text = the_warning(scene, part)
        assert text.startswith("in steps 1 to 2 the loads have a moment")
        assert "compress" not in text
        held = [{"edge": "bottom", "displacement": {"x": 0, "y": 0}}, *loads[1:]]
        assert gone(scene | {"loads": held}, part)

    def test_tension_has_none(self) -> None:
        assert gone(plate(**SOFT), "moment")


class TestWork:
    STEEL: ClassVar = {"E": 1000.0, "nu": 0.3, "law": "j2", "yield_stress": 10, "hardening": 10}

    def drawn(self, **changes: Any) -> dict[str, Any]:
        mesh = {"size": 8, "element": "T3", "grading": "uniform"}
        bottom = {"edge": "bottom", "displacement": {"x": 0, "y": 0}}
        return plate(
            loads=[bottom, {"edge": "top", "traction": [0, 40]}],
            material=self.STEEL,
            kinematics="finite",
            **({"mesh": mesh} | changes),
        )

    def test_few_load_steps(self) -> None:
        part = "differs from the strain energy and plastic work by up to"
        text = the_warning(self.drawn(), part)
        assert text.startswith("in step 1 the external work")
        assert text.endswith("by up to 1.1 % (external_work): increase load_steps")
        assert gone(self.drawn(load_steps=10), part)

    def test_linear_triangles_in_plastic_flow(self) -> None:
        part = "linear triangles (T3) are too stiff"
        assert "use mesh.element: T6" in the_warning(self.drawn(), part)
        assert gone(self.drawn(mesh={"size": 8, "grading": "uniform"}), part)


class TestPaper:
    def test_triangles_without_a_point(self) -> None:
        scene = plate(
            mesh={"size": 3, "element": "T3", "grading": "uniform"},
            loads=[{"edge": "bottom", "displacement": {"x": 0, "y": 0}}, PULL[1]],
        )
        growth = {"control": "crack", "increments": 8}
        part = "triangles without a material point"
        text = the_warning(scene | {"growth": growth | {"transfer": "paper"}}, part)
        assert re.match(r"in steps? [\d to]+ growth.transfer: paper left up to \d+ tri", text)
        assert gone(scene | {"growth": growth | {"transfer": "domains"}}, part)


def test_faces_that_supports_push_through_each_other() -> None:
    """The left side is supported above and below the crack mouth."""
    outline = [
        *OUTLINE,
        {"at": [0, 40], "edge": "upper"},
        {"at": [0, 30], "edge": "lower"},
        {"at": [0, 20], "edge": "rest"},
    ]

    def moved(shift: float) -> dict[str, Any]:
        parts = {"top": 0.1, "lower": 0.03, "upper": 0.03 + shift}
        loads = [{"edge": edge, "displacement": {"y": y}} for edge, y in parts.items()]
        return plate(
            geometry={"outline": outline, "cracks": [{"points": [[0, 30], [10, 30]]}]},
            loads=[{"edge": "bottom", "displacement": {"x": 0, "y": 0}}, *loads],
        )

    part = "its faces overlap by up to"
    text = the_warning(moved(-0.02), part)
    assert text.startswith("crack_1: in step 1 its faces overlap by up to 0.02 mm where supports")
    assert "prescribe a displacement that leaves them apart" in text
    assert gone(moved(0.02), part)


class TestReleases:
    def kinked(self, **changes: Any) -> dict[str, Any]:
        """A crack that approaches the upper side at an angle, where no node may move."""
        return plate(
            geometry={"outline": OUTLINE, "cracks": [{"points": [[0, 30], [8, 38]]}]},
            growth={"control": "crack", "increments": 6},
            **changes,
        )

    def test_j_and_g_of_a_growing_tip(self) -> None:
        part = "J and G from K_I and K_II differ"
        coarse = self.kinked(mesh={"size": 6, "element": "T3", "grading": "uniform"})
        text = the_warning(coarse, part)
        assert re.match(
            r"crack_1: in (\d+ of the )?steps? [\d to]+ J and G from K_I and K_II differ by up",
            text,
        )
        assert "around the growing tip" in text
        size = number_behind(text, "set fracture.refine to at most")

        def largest(scene: dict[str, Any]) -> float:
            history = solved(scene)
            return float(np.nanmax(np.abs(history["J"] / history["G"] - 1.0)[[0, 3, 4, 5, 6]]))

        finer = coarse | {"mesh": {"size": 6, "element": "T3"}, "fracture": {"refine": size}}
        assert largest(finer) < 0.5 * largest(coarse)
