"""Warnings about growth name tips, steps, size and an action, which removes the warning."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import posed
import pytest
from warned import OUTLINE, PULL, gone, number_behind, plate, solved, the_warning, until_gone

from cfmpm import mechanics
from cfmpm.body.body import Grown
from cfmpm.build import build
from cfmpm.output.warnings import of_state
from cfmpm.scene import scene_from_dict
from cfmpm.scene.growth import Growth

pytestmark = pytest.mark.slow


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

    @pytest.mark.parametrize("obstacle", ["hole", "interface"])
    def test_a_tip_that_runs_at_an_object_is_no_doubt(self, obstacle: str) -> None:
        """There smaller elements would be asked for without end."""
        scene = plate(growth={"control": "crack", "increments": 40}, mesh={"size": 3})
        scene["mesh"]["grading"] = "uniform"
        disc = {"circle": {"centre": [30, 30], "radius": 5}}
        alike = {"name": "alike", "material": scene["material"], **disc}
        scene["geometry"] = {
            "outline": OUTLINE,
            "cracks": [{"points": [[0, 30], [12, 30]]}],
            "holes": [disc] if obstacle == "hole" else [],
            "regions": [alike] if obstacle == "interface" else [],
        }
        history = solved(scene)
        close = history["clearance"].values < 3.0 * history["tip_size"].values
        assert close.any()
        assert "the direction of growth is inaccurate" not in history.attrs["warnings"]

    def test_little_clearance_before_growth(self) -> None:
        """The grid of the start is that of mesh.grading, whatever fracture.refine is."""
        part = "the direction of growth is inaccurate"
        scene = plate(
            growth={"control": "crack", "increments": 1},
            mesh={"size": 4, "element": "T3", "grading": "uniform"},
            fracture={"refine": 0.3},
        )
        text = the_warning(scene, part)
        assert text.startswith("crack_1: in step 1 the clearance is down to 10 mm")
        assert "fracture.refine" not in text
        until_gone(scene, part, "mesh.grading.tip_size")

    def test_the_default_number_of_increments(self, monkeypatch: pytest.MonkeyPatch) -> None:
        part = "the default of growth.increments"
        monkeypatch.setattr(Growth.model_fields["increments"], "default", 2)
        growth = {"control": "crack", "increments": 2}
        scene = plate(growth=growth, mesh={"size": 6, "grading": "uniform"})
        text = the_warning(scene, part)
        assert text.startswith("the run ended after 2 increments")
        assert "increase growth.increments to follow it to its end" in text
        history = solved(scene | {"growth": growth | {"increments": 100}})
        assert history.attrs["run_status"] == "severed"
        assert part not in history.attrs["warnings"]

    def inclusion(self) -> dict[str, Any]:
        """A crack that runs past a hard inclusion."""
        disc = {"centre": [30, 36], "radius": 8}
        hard = {"name": "hard", "circle": disc, "material": {"E": 3e4, "nu": 0.3, "g_c": 0.1}}
        scene = plate(
            growth={"control": "crack", "increments": 60},
            mesh={"size": 4, "element": "T3", "grading": "uniform"},
        )
        scene["geometry"] = scene["geometry"] | {"regions": [hard]}
        return scene

    def test_a_segment_beside_the_direction_of_growth(self) -> None:
        part = "from the direction of growth"
        text = the_warning(self.inclusion(), part)
        assert re.match(r"crack_1: in step \d+ a segment deviates by up to [\d.]+ deg", text)
        assert "a smaller fracture.refine makes such a detour shorter" in text
        finer = solved(self.inclusion() | {"fracture": {"refine": 0.5}})
        assert part not in finer.attrs["warnings"]
        assert finer["tip_x"].values[-1, 0] > 28.0  # past the place

    def test_only_tips_whose_segments_deviate_are_named(self) -> None:
        scene = scene_from_dict(plate())
        body = build(scene)
        grown = Grown(segments={"one": 1.0, "two": 1.0}, deviations={"one": 2.0, "two": 20.0})
        body = replace(body, grown=grown)
        problem = mechanics.problem_of(*mechanics.locate(body))
        found = list(of_state.doubts(scene, body, posed.balanced(problem)))
        (doubt,) = (doubt for doubt in found if "from the direction of growth" in doubt.text)
        assert (doubt.about, doubt.size) == ("two", 20.0)

    def test_a_gap_of_the_energy_balance(self) -> None:
        part = "the energy balance has a gap"
        scene = plate(
            growth={"control": "crack", "increments": 100}, mesh={"size": 6, "grading": "uniform"}
        )
        text = the_warning(scene, part)
        of_crack = number_behind(text, "has a gap of")
        assert 5.0 < of_crack < 10.0
        until_gone(scene, part, "fracture.refine", times=1)

    @pytest.mark.parametrize("size", [0.77, 2.0, 3.0])
    @pytest.mark.parametrize("nu", [0.49, 0.49999])
    def test_no_segment_takes_energy(self, nu: float, size: float) -> None:
        """Patches over which the change of volume is averaged stay where the crack is not."""
        scene = plate(
            geometry={
                "outline": [[0, 0], [10, 0], [10, 8.62], [0, 8.62]],
                "cracks": [{"points": [[0, 5.758562179606234], [1.538531768791, 4.32018316401]]}],
            },
            material={"E": 1000.0, "nu": nu, "g_c": 1e-12},
            loads=[
                {"edge": "edge_4", "displacement": {"x": 0, "y": 0}},
                {"edge": "edge_1", "traction": [-1, 2]},
            ],
            mesh={"size": size, "element": "T3", "grading": "uniform"},
            fracture={"refine": 0.3},
            growth={"increments": 4},
        )
        assert (solved(scene)["released_energy"].values[1:] > 0.0).all()

    def test_a_body_that_has_come_apart_has_no_residual(self) -> None:
        """What is left between grips is round-off, and no reason to change the scene."""
        scene = plate(
            geometry={
                "outline": [[0, 0], [10, 0], [10, 10], [0, 10]],
                "cracks": [{"points": [[0, 5], [7, 5]]}],
            },
            material={"E": 1e3, "nu": 0.3, "g_c": 1e-9},
            loads=[
                {"edge": "edge_1", "displacement": {"x": 0, "y": 0}},
                {"edge": "edge_3", "displacement": {"x": 0, "y": 0.01}},
            ],
            mesh={"size": 1, "element": "T3", "grading": "uniform"},
            growth={"increments": 20},
        )
        history = solved(scene)
        residual = history["residual_norm"].values
        assert history.attrs["run_status"] == "arrived"
        assert np.isnan(residual[-1])
        assert (residual[:-1] < 1e-8).all()
        assert "residual_norm" not in history.attrs["warnings"]

    def test_a_closed_tip_that_is_held_back(self) -> None:
        scene = plate(
            geometry={"outline": OUTLINE, "cracks": [{"points": [[0, 30], [8, 30], [10, 34]]}]},
            material={"E": 3000.0, "nu": 0.3, "g_c": 1e-4},
            loads=[
                {"edge": "bottom", "traction": [-1, 1]},
                {"edge": "top", "traction": [1, -1]},
                {"edge": "left", "traction": [0, -1]},
                {"edge": "right", "traction": [0, 1]},
            ],
            kinematics="finite",
            growth={"direction": "cf", "increments": 1},
            mesh={"size": 6, "grading": {"tip_size": 2.0}},
        )
        part = "so that it does not grow"
        text = the_warning(scene, part)
        assert re.match(r"crack_1: in step 1 J is up to [\d.]+ N/mm, not less than g_c", text)
        finer = until_gone(scene, part, "mesh.grading.tip_size")
        before, after = (solved(one)["crack_length"].values[-1, 0] for one in (scene, finer))
        assert after > before

    def test_a_part_that_comes_off(self) -> None:
        scene = plate(
            geometry={
                "outline": [[0, 0], [10, 0], [10, 10], [0, 10]],
                "cracks": [{"points": [[0, 2], [3, 4]]}],
            },
            material={"E": 1e4, "nu": 0.3, "g_c": 1e-3},
            loads=[
                {"edge": "edge_3", "displacement": {"x": 0, "y": 0}},
                {"edge": "edge_1", "traction": [0, 1]},
            ],
            mesh={"size": 1.0, "grading": "uniform"},
            growth={"control": "crack", "direction": "max_energy"},
        )
        part = "is cut off, and no support holds all its motions"
        text = the_warning(scene, part)
        assert re.match(r"from step \d+ on the part of the body around \(1.\d+, 5.\d+\), of", text)
        step = int(number_behind(text, "from step"))
        # Between the edge, the crack of the start and about what it has grown.
        assert 8.0 < number_behind(text, ", of") < 16.0
        assert text.endswith("a smaller growth.increments ends the run before")
        before = solved(scene | {"growth": scene["growth"] | {"increments": step - 2}})
        assert part not in before.attrs["warnings"]
        assert float(before["free_parts"].max()) == 0.0


class TestInterface:
    def layered(self, corners: list[Any], crack: list[Any], **changes: Any) -> dict[str, Any]:
        other = {
            "name": "other",
            "polygon": corners,
            "material": {"E": 9000, "nu": 0.3, "g_c": 0.1},
        }
        geometry = {"outline": OUTLINE, "cracks": [{"points": crack}], "regions": [other]}
        growth = {"control": "crack", "increments": 12}
        mesh = {"size": 3, "grading": "uniform"}
        return plate(**({"geometry": geometry, "growth": growth, "mesh": mesh} | changes))

    PART = "the tip lies on the interface of two materials"

    def test_of_a_crack_that_crosses_it(self) -> None:
        """Askew, so that straight ahead is not the direction of growth."""
        right = [[18, 0], [60, 0], [60, 60], [28, 60]]
        scene = self.layered(right, [[0, 30], [10, 30]])
        text = the_warning(scene, self.PART)
        found = re.match(rf"crack_1: in step (\d+) {self.PART}", text)
        assert found is not None
        size = number_behind(text, "by one segment, of up to")
        history = solved(scene)
        step = int(found[1]) - 1
        assert np.isnan(history["K_I"].values[step, 0])
        assert size == pytest.approx(float(history["tip_size"][step, 0]), rel=0.02)
        finer = scene | {
            "fracture": {"refine": 0.5},
            "growth": scene["growth"] | {"increments": 45},
        }
        shorter = number_behind(the_warning(finer, self.PART), "by one segment, of up to")
        assert shorter < 0.25 * size

    def test_of_a_crack_that_runs_along_it(self) -> None:
        upper = [[0, 30], [60, 30], [60, 60], [0, 60]]
        crack = [[0, 30], [10, 30]]
        text = the_warning(self.layered(upper, crack), self.PART)
        assert re.match(r"crack_1: in (\d+ of the )?steps 1 to 1\d the tip", text)
        assert "move the border of the region off its path by a few elements" in text
        raised = [[x, y if y == 60 else 38] for x, y in upper]
        history = solved(self.layered(raised, crack))
        assert self.PART not in history.attrs["warnings"]
        assert np.isfinite(history["K_I"].values[:4]).all()


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
