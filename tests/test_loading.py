from __future__ import annotations

import numpy as np
import pytest
from structured import rectangle

from cfmpm.errors import SceneError
from cfmpm.grid import build_grid
from cfmpm.loading import apply_loads
from cfmpm.points import seed
from cfmpm.scene.model import Scene


def load(loads, grid=None, element="T3"):
    grid = grid or build_grid(rectangle(4, 2, 4.0, 2.0, crack=(1, 0, 2)), element)
    scene = Scene.model_construct(
        name="x",
        loads=_loads(loads),
    )
    return grid, apply_loads(scene, grid, seed(grid))


def _loads(loads):
    from cfmpm.scene.model import Load

    return [
        Load.model_validate({"name": item.get("edge", f"load_{i}"), **item})
        for i, item in enumerate(loads, 1)
    ]


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_traction_has_its_resultant_and_moment(element):
    grid, loading = load(
        [
            {"edge": "top", "traction": [0.5, 3.0]},
            {"edge": "bottom", "displacement": {"x": 0, "y": 0}},
        ],
        element=element,
    )
    np.testing.assert_allclose(loading.force.sum(axis=0), [2.0, 12.0], rtol=1e-14)
    x = grid.nodes - [2.0, 2.0]
    moment = x[:, 0] * loading.force[:, 1] - x[:, 1] * loading.force[:, 0]
    assert moment.sum() == pytest.approx(0.0, abs=1e-13)
    corner = loading.force[np.all(grid.nodes == [0, 2], axis=1)][0]
    # One half of an edge for the linear basis, one sixth for the quadratic.
    np.testing.assert_allclose(corner, np.array([0.5, 3.0]) / (2 if element == "T3" else 6))


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_body_force_is_shared_out_in_full(element):
    _, loading = load(
        [
            {"body_force": [0.1, -0.3]},
            {"edge": "left", "displacement": {"x": 0, "y": 0}},
        ],
        element=element,
    )
    np.testing.assert_allclose(loading.own_weight.sum(axis=0), [0.8, -2.4], rtol=1e-13)


def test_a_box_takes_the_boundary_inside_it():
    grid, loading = load(
        [
            {"box": [[-1, -1], [0.5, 0.5]], "displacement": {"x": 0, "y": 0}},
            {"box": [[3, 1.9], [9, 9]], "traction": [0, 1.0]},
            {"edge": "bottom", "displacement": {"y": 0}},
        ]
    )
    assert loading.boundaries["load_1"].nodes.tolist() == [
        int(np.flatnonzero(np.all(grid.nodes == [0, 0], axis=1))[0])
    ]
    np.testing.assert_allclose(loading.force.sum(axis=0), [0, 1.0])


@pytest.mark.parametrize(
    ("loads", "text"),
    [
        (
            [
                {"edge": "left", "displacement": {"x": 0, "y": 0}},
                {"edge": "bottom", "displacement": {"x": 0.1}},
            ],
            "u_x = 0.1 mm where loads[0] prescribes 0 mm, at (0, 0)",
        ),
        (
            [
                {"edge": "top", "displacement": {"y": 1}},
                {"edge": "right", "displacement": {"x": 0, "y": 2}},
            ],
            "u_y = 2 mm",
        ),
        (
            [
                {"edge": "left", "displacement": {"x": 0, "y": 0}},
                {"box": [[9, 9], [10, 10]], "displacement": {"x": 0}},
            ],
            "no part of the boundary lies in the box",
        ),
        (
            [
                {"edge": "left", "displacement": {"x": 0, "y": 0}},
                {"box": [[-1, 1.9], [0.5, 3]], "traction": [1, 0]},
            ],
            "no edge lies wholly in the box",
        ),
        ([{"edge": "top", "traction": [0, 1]}], "resultant (0, 4) N/mm"),
        (
            [{"edge": "top", "traction": [1, 0]}, {"edge": "bottom", "traction": [-1, 0]}],
            "moment",
        ),
        (
            [{"edge": "bottom", "displacement": {"y": 0}}, {"edge": "top", "traction": [1, 0]}],
            "out of balance",
        ),
        ([{"body_force": [0, 1]}], "out of balance"),
    ],
)
def test_what_makes_no_sense_on_the_grid_is_refused(loads, text):
    with pytest.raises(SceneError) as error:
        load(loads)
    assert text in str(error.value)


@pytest.mark.parametrize(
    ("loads", "held"),
    [
        ([{"edge": "top", "traction": [0, 1]}, {"edge": "bottom", "traction": [0, -1]}], 3),
        ([{"edge": "bottom", "displacement": {"y": 0}}, {"edge": "top", "traction": [0, 1]}], 1),
        ([{"edge": "bottom", "displacement": {"x": 0, "y": 0}}], 0),
        ([{"edge": "left", "displacement": {"x": 0}}, {"edge": "right", "traction": [1, 0]}], 1),
    ],
)
def test_motions_that_no_load_drives_are_held(loads, held):
    _, loading = load(loads)
    assert loading.held == held


def test_a_part_cut_off_by_a_crack_must_be_held_too():
    """Two plates in one: the right one is cut off and only pulled."""
    severed = build_grid(rectangle(4, 2, 4.0, 2.0, crack=(1, 0, 4)), "T3")
    with pytest.raises(SceneError, match="out of balance"):
        load(
            [
                {"edge": "bottom", "displacement": {"x": 0, "y": 0}},
                {"edge": "top", "traction": [0, 1]},
            ],
            severed,
        )
    _, loading = load(
        [
            {"edge": "bottom", "displacement": {"x": 0, "y": 0}},
            {"edge": "top", "displacement": {"y": 1}},
        ],
        severed,
    )
    assert loading.held == 1
