"""Every warning names tips, steps, size and an action, which removes the warning."""

from __future__ import annotations

import json
import re
from typing import Any, ClassVar

import numpy as np
import pytest
import yaml
from warned import OUTLINE, PULL, gone, number_behind, plate, solved, the_warning, until_gone

from cfmpm.output.warnings.doubt import SIZE, Doubt, Doubts

SOFT = {
    "kinematics": "finite",
    "load_steps": 2,
    "material": {"E": 100.0, "nu": 0.3},
    "mesh": {"size": 10, "element": "T3"},
}
PUSH = [{"edge": "bottom", "traction": [0, 1]}, {"edge": "top", "traction": [0, -1]}]
SHEAR = [
    {"edge": "bottom", "traction": [-1, 0]},
    {"edge": "top", "traction": [1, 0]},
    {"edge": "left", "traction": [0, -1]},
    {"edge": "right", "traction": [0, 1]},
]


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
        until_gone(coarse, part, "mesh.grading.tip_size")

    def test_no_factors_at_a_tip_that_has_j(self) -> None:
        """One end of a crack that is pressed shut by a grip on the side of an L."""
        outline = [[0, 0], [10, 0], [10, 4.36], [4.34, 4.36], [4.34, 10], [0, 10]]
        scene = plate(
            geometry={"outline": outline, "cracks": [{"points": [[6.95, 2.52], [3.13, 3.31]]}]},
            material={"E": 1000.0, "nu": 0.3, "g_c": 0.001},
            loads=[
                {"edge": "edge_1", "displacement": {"x": 0, "y": 0}},
                {"edge": "edge_4", "displacement": {"x": -0.01, "y": -0.02}},
            ],
            mesh={"size": 1.1, "element": "T6", "grading": "uniform"},
            kinematics="small",
        )
        part = "K_I and K_II are too small"
        text = the_warning(scene, part)
        assert re.match(r"crack_1_end: in step 1 J is up to [\d.]+ N/mm, more than its error", text)
        until_gone(scene, part, "mesh.grading.tip_size")

    @pytest.mark.parametrize("radii", [[0.5], [6.0]])
    def test_a_domain_of_few_elements(self, radii: list[float]) -> None:
        mesh = {"size": 6, "grading": {"tip_size": 2.0}}
        scene = plate(mesh=mesh, fracture={"radii": radii})
        part = "below 4 element sizes"
        text = the_warning(scene, part)
        assert text.startswith(f"crack_1: in step 1 the largest domain radius is {radii[0]:.3g} mm")
        size = number_behind(text, "set mesh.grading.tip_size to at most")
        finer = mesh | {"grading": {"tip_size": size}}
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

    def kinked(self, loads: list[Any]) -> dict[str, Any]:
        """A kinked crack whose faces are in contact, with a domain up to its kink."""
        return plate(
            geometry={"outline": OUTLINE, "cracks": [{"points": [[0, 30], [8, 30], [10, 34]]}]},
            loads=loads,
            kinematics="small",
            mesh={"size": 6, "element": "T3", "grading": {"tip_size": 3.0}},
            fracture={"radii": [1.0, 4.0]},
        )

    def test_of_the_grid(self) -> None:
        part = "J depends on the domain"
        text = the_warning(self.kinked(PUSH), part)
        assert re.match(r"crack_1: in step 1 J differs by up to \d+ % between", text)
        until_gone(self.kinked(PUSH), part, "mesh.grading.tip_size")

    def test_of_the_grid_and_the_radius_where_faces_are_in_contact(self) -> None:
        part = "J depends on the domain"
        scene = self.kinked(SHEAR)
        text = the_warning(scene, part)
        assert text.endswith(
            "mm, and give smaller fracture.radii, since crack faces are in contact"
        )
        scene["mesh"]["grading"]["tip_size"] = 0.15
        assert not gone(scene, part)
        assert gone(scene | {"fracture": {"radii": [1.0, 2.0]}}, part)

    def test_ellipticity(self) -> None:
        text = the_warning(self.rubber("hencky", 2.0), "have lost ellipticity (unstable_points)")
        assert re.match(r"in steps? [\d to]+ up to \d+ material points have lost", text)
        assert gone(self.rubber("ciarlet", 2.0), "ellipticity")


class TestNotch:
    def test_taken_out_and_made_a_crack(self) -> None:
        wedge = [[0, 31], {"at": [12, 30], "edge": "root"}, [0, 29]]
        notched = plate(geometry={"outline": [*OUTLINE, *wedge]})
        text = the_warning(notched, "sharp notch")
        assert "with its root at (12, 30) and an angle of 9.53 deg" in text
        (advised,) = re.findall(r"add geometry.cracks: (.*)$", text)
        cracked = plate(geometry={"outline": OUTLINE, "cracks": yaml.safe_load(advised)})
        assert gone(cracked, "sharp notch")
        assert np.isfinite(solved(cracked)["K_I"]).all()


class TestRoundOff:
    def hard(self, contrast: float) -> dict[str, Any]:
        """A hard inclusion."""
        scene = plate(mesh={"size": 6, "element": "T3"})
        hard = {"E": 3000.0 * contrast, "nu": 0.3, "g_c": 0.1}
        disc = {"centre": [35, 30], "radius": 6}
        scene["geometry"] |= {"regions": [{"name": "hard", "material": hard, "circle": disc}]}
        return scene

    def soft(self, nu: float) -> dict[str, Any]:
        """Hardly compressible, and clamped."""
        loads = [{"edge": "bottom", "displacement": {"x": 0, "y": 0}}, PULL[1]]
        material = {"E": 3000.0, "nu": nu, "g_c": 0.1}
        return plate(material=material, loads=loads, kinematics="small")

    def cut(self, ligament: float) -> dict[str, Any]:
        crack = {"points": [[0, 30], [60 - ligament, 30]]}
        mesh = {"size": 6, "element": "T3"}
        geometry = {"outline": OUTLINE, "cracks": [crack]}
        return plate(geometry=geometry, mesh=mesh, kinematics="small")

    def test_unbalanced_force(self) -> None:
        part = "above the tolerance, limited by round-off"
        cases = [
            (self.hard(1e7), self.hard(1e5), "bring material.E of the regions closer together"),
            (self.soft(0.4999999), self.soft(0.4999), "lower material.nu"),
            (self.cut(0.1), self.cut(1.0), "leave a wider ligament"),
        ]
        for scene, advised, action in cases:
            text = the_warning(scene, part)
            found = re.match(r"in step 1 the unbalanced force is up to (\S+) of the largest", text)
            assert found is not None
            assert 1e-9 < float(found[1]) < 1e-5
            assert action in text
            assert gone(advised, part)

    def test_forces_out_of_balance(self) -> None:
        part = "loads and reactions are out of balance"
        hard = self.hard(1e9)
        hard |= {"loads": self.soft(0.3)["loads"], "kinematics": "small"}
        cases = [
            (self.soft(0.4999999), self.soft(0.4999), "lower material.nu"),
            (hard, self.hard(1e5), "bring material.E of the regions closer together"),
        ]
        for scene, advised, action in cases:
            text = the_warning(scene, part)
            assert text.startswith(f"in step 1 {part} by up to ")
            assert 1e-9 < number_behind(text, "by up to") < 1e-7
            assert action in text
            assert gone(advised | {"loads": scene["loads"]}, part)


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


class TestMomentOnTheDeformedBody:
    PINS: ClassVar = [
        {"point": [0, 0], "displacement": {"x": 0, "y": 0}},
        {"point": [60, 0], "displacement": {"y": 0}},
    ]

    @pytest.mark.parametrize("loads", [PUSH, SHEAR])
    def test_a_support_takes_the_moment(self, loads: list[Any]) -> None:
        scene = plate(loads=loads, **SOFT)
        part = "have a moment on the deformed body"
        text = the_warning(scene, part)
        assert text.startswith("in steps 1 to 2 the loads have a moment")
        assert "compress" not in text
        share = number_behind(text, "with a reaction moment, by up to")
        assert 0.001 < share < 10.0
        assert gone(scene | {"loads": [*loads, *self.PINS]}, part)
        held = [{"edge": "bottom", "displacement": {"x": 0, "y": 0}}, *loads[1:]]
        assert gone(scene | {"loads": held}, part)

    @pytest.mark.parametrize("mesh", [{"size": 6}, {"size": 10, "element": "T3"}])
    def test_its_hold_beside_a_support_is_no_fault_of_the_solver(self, mesh: Any) -> None:
        """The support takes what the hold of the rotation exerts across the loads, or another one.

        On the two grids the program holds different components.
        """
        pin = {"point": [0, 0], "displacement": {"x": 0}}
        for loads in ([*PUSH, pin], PUSH):
            scene = plate(loads=loads, **SOFT | {"mesh": mesh})
            assert the_warning(scene, "with a reaction moment")
            assert gone(scene, "out of balance")

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
