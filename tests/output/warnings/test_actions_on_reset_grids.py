"""Warnings about a grid that is reset, and about its separation from the material."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from warned import gone, number_behind, solved, the_warning

pytestmark = pytest.mark.slow


def pulled(by: float, steps: int, **updated: Any) -> dict[str, Any]:
    """A plate with an edge crack, with a grid that is reset or without, pulled by a length."""
    scene = {
        "name": "plate",
        "family": {"kind": "single_edge", "width": 500, "height": 1000, "crack_length": 100},
        "material": {"E": 210e3, "nu": 0.3, "law": "neo_hookean"},
        "kinematics": "finite",
        "loads": [
            {"edge": "bottom", "displacement": {"y": -by}},
            {"edge": "top", "displacement": {"y": by}},
        ],
        "load_steps": steps,
        "mesh": {"element": "T3", "size": 60, "grading": {"tip_size": 12}},
        "fracture": {"radii": [50]},
    }
    return scene | ({"formulation": "updated", "updated": updated} if updated else {})


def test_faces_that_overlap_on_a_fixed_grid() -> None:
    part = "its faces overlap by up to"
    text = the_warning(pulled(-20, 4, grid="fixed"), part)
    # As far as the ends are pressed together: nothing resists it.
    assert re.match(r"crack_1: in steps 1 to 4 its faces overlap by up to 2\d mm", text)
    assert "updated.grid: following has it" in text
    following = solved(pulled(-20, 4, grid="following"))
    assert part not in following.attrs["warnings"]
    assert float(following["min_opening"].min()) > -1e-9
    # What is left of the force at closed faces is round-off, and its parts may differ.
    assert "cf_norm_grid" not in following.attrs["warnings"]


def test_triangles_without_a_point() -> None:
    part = "have lost material points (empty_elements)"
    text = the_warning(pulled(100, 8, grid="fixed"), part)
    assert re.match(r"in steps 2 to 8 up to \d+ triangles inside the body have lost", text)
    assert "updated.integration: domains avoids them" in text
    assert gone(pulled(100, 8, grid="fixed", integration="domains"), part)


def test_a_tip_that_drifts() -> None:
    part = "(tip_drift)"
    text = the_warning(pulled(100, 8, grid="fixed"), part)
    assert text.startswith("crack_1: in steps 7 to 8 the crack tip of the grid is up to 1.")
    following = solved(pulled(100, 8, grid="following"))
    assert part not in following.attrs["warnings"]
    assert float(following["tip_drift"].max()) < 1e-9


def test_forces_on_grid_and_material_that_differ() -> None:
    """Without resets the force at the tip is J, as it is where the grid follows."""
    part = "(cf_norm_grid)"
    text = the_warning(pulled(100, 8, grid="fixed"), part)
    assert text.startswith("crack_1: in steps 3 to 7 the configurational force on the grid")
    apart = number_behind(text, "from that on the material by up to")
    assert 5.0 < apart < 20.0
    assert "formulation: total does not reset the grid" in text
    total = solved(pulled(100, 8))
    assert part not in total.attrs["warnings"]
    np.testing.assert_allclose(total["cf_norm"], total["J"], rtol=0.03)


def test_triangles_that_are_nearly_empty() -> None:
    """With the ghost the run goes to its end, and advises it no longer."""
    part = "(least_fill)"
    options = {"grid": "fixed", "integration": "domains"}
    history = solved(pulled(200, 8, **options))
    assert history.attrs["run_status"] == "unstable"
    text = the_warning(pulled(200, 8, **options), part)
    assert re.match(r"in steps? [\d to]+ up to 9\d % of a triangle inside the body is empty", text)
    assert "updated.ghost: 0.1 stabilises it" in text
    ghost = solved(pulled(200, 8, **options, ghost=0.1))
    assert ghost.attrs["run_status"] == "solved"
    assert float(ghost["least_fill"].min()) < 0.1
    assert part not in ghost.attrs["warnings"]


def test_points_that_are_crushed() -> None:
    """Between walls, so that all of the body is pressed to three quarters of its volume."""
    walls = [{"edge": side, "displacement": {"x": 0}} for side in ("left", "right")]

    def pressed(**updated: Any) -> dict[str, Any]:
        scene = pulled(-125, 8, **updated)
        return scene | {"loads": [*scene["loads"], *walls]}

    part = "(min_det_F)"
    text = the_warning(pressed(grid="fixed"), part)
    assert re.match(r"in steps 7 to 8 a material point has lost up to 5\d % of its volume", text)
    assert "formulation: total, which does not reset the grid, shows which" in text
    total = solved(pressed())
    assert total.attrs["run_status"] == "solved"
    np.testing.assert_allclose(total["min_det_F"][-1], 0.75, rtol=1e-8)
