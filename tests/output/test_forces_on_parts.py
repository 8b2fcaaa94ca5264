"""Forces of loaded parts in a record, with crack faces in contact."""

from __future__ import annotations

import numpy as np
import pytest

import cfmpm
from cfmpm.scene.reading import scene_from_dict

E, NU = 1000.0, 0.25


def pressed(lower: float, upper: float, top: float, right: float, element: str):
    """A plate whose crack opens at a corner of its outline, between two grips along x."""
    scene = {
        "name": "pressed",
        "geometry": {
            "outline": [
                {"at": [0, 0], "edge": "bottom"},
                {"at": [60, 0], "edge": "right"},
                {"at": [60, 50], "edge": "top"},
                {"at": [0, 50], "edge": "upper"},
                {"at": [0, 20], "edge": "lower"},
            ],
            "cracks": [{"points": [[0, 20], [25, 35]]}],
        },
        "material": {"E": E, "nu": NU},
        "kinematics": "small",
        "loads": [
            {"edge": "lower", "displacement": {"x": lower}},
            {"edge": "upper", "displacement": {"x": upper}},
            {"edge": "bottom", "displacement": {"y": 0}},
            {"edge": "top", "displacement": {"y": top}},
            {"edge": "right", "displacement": {"x": right}},
        ],
        "mesh": {"element": element, "size": 5, "grading": "uniform"},
    }
    history = cfmpm.run(scene_from_dict(scene)).history.isel(step=0)
    assert float(history.contact_pairs) > 3
    return history


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_what_faces_do_to_each_other_is_no_force_of_a_grip(element: str) -> None:
    """Uniform pressure: the force of each part is pressure times length, up to the mouth."""
    strain = -1e-3
    history = pressed(0.0, 0.0, 50 * strain, 60 * strain, element)
    pressure = -strain * E / ((1 + NU) * (1 - 2 * NU))
    forces = {"lower": 20, "upper": 30, "right": -50}
    for part, length in forces.items():
        assert float(history.reaction_x.sel(boundary=part)) == pytest.approx(
            pressure * length, rel=1e-9
        )
    assert float(history.reaction_y.sel(boundary="top")) == pytest.approx(-60 * pressure, rel=1e-9)


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_closed_faces_do_no_work_where_grips_slide_them(element: str) -> None:
    """The grips on both sides of the mouth move apart along x while the faces stay closed."""
    history = pressed(-0.02, 0.03, -0.2, 0.0, element)
    assert float(history.external_work) == pytest.approx(float(history.strain_energy), rel=1e-11)
    assert abs(float(history.reaction_x.sum())) < 1e-9 * np.abs(history.reaction_y).max()
