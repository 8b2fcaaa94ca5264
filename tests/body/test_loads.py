from __future__ import annotations

import numpy as np
import pytest
from structured import rectangle

from cfmpm.body.grid import build_grid
from cfmpm.body.loads import apply_loads
from cfmpm.body.points import seed
from cfmpm.build import true_sides
from cfmpm.errors import SceneError
from cfmpm.meshing import triangulate
from cfmpm.scene import expand
from cfmpm.scene.reading import scene_from_dict


def load(loads, grid=None, element="T3", fixed=()):
    grid = grid or build_grid(rectangle(4, 2, 4.0, 2.0, crack=(1, 0, 2)), element)
    return grid, apply_loads(_loads(loads), {}, grid, seed(grid), fixed)


def _loads(loads):
    from cfmpm.scene.loads import Load

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
    np.testing.assert_allclose(loading.proportional.force.sum(axis=0), [2.0, 12.0], rtol=1e-14)
    x = grid.nodes - [2.0, 2.0]
    moment = x[:, 0] * loading.proportional.force[:, 1] - x[:, 1] * loading.proportional.force[:, 0]
    assert moment.sum() == pytest.approx(0.0, abs=1e-13)
    corner = loading.proportional.force[np.all(grid.nodes == [0, 2], axis=1)][0]
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
    np.testing.assert_allclose(loading.proportional.own_weight.sum(axis=0), [0.8, -2.4], rtol=1e-13)


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
    # One of the top and a tenth of the right.
    np.testing.assert_allclose(loading.proportional.force.sum(axis=0), [0, 1.1], rtol=1e-14)


@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("cells", [(4, 2), (7, 5), (1, 1)])
def test_a_traction_is_cut_at_the_border_of_its_box(cells, element):
    """As in a mesh file, the grid has no nodes at the border of the box: edges are cut."""
    grid, loading = load(
        [
            {"box": [[0.3, 1.3], [1.7, 5]], "traction": [1.0, 2.0]},
            {"box": [[4, 0.21], [4, 0.37]], "traction": [5.0, 0.0], "name": "within_an_edge"},
            {"edge": "bottom", "displacement": {"x": 0, "y": 0}},
        ],
        build_grid(rectangle(*cells, 4.0, 2.0), element),
    )
    np.testing.assert_allclose(loading.proportional.force.sum(axis=0), [1.4 + 0.8, 2.8], rtol=1e-13)
    np.testing.assert_allclose(
        moment(grid, loading.proportional.force), 2.8 - 2.8 - 0.8 * 0.29, rtol=1e-12
    )


def moment(grid, force):
    """About the origin."""
    return (grid.nodes[:, 0] * force[:, 1] - grid.nodes[:, 1] * force[:, 0]).sum()


def meshed(size, element, loads):
    """A plate with a hole, which has nodes where boxes cut its boundary."""
    scene = scene_from_dict(
        {
            "name": "plate",
            "geometry": {
                "outline": [
                    {"at": [0, 0], "edge": "bottom"},
                    {"at": [100, 0]},
                    {"at": [100, 60], "edge": "top"},
                    {"at": [0, 60], "through": [-30, 30], "edge": "left"},
                ],
                "holes": [{"name": "hole", "circle": {"centre": [50, 30], "radius": 9}}],
            },
            "material": {"E": 1000.0, "nu": 0.3},
            "loads": loads,
            "mesh": {"size": size, "grading": "uniform"},
        }
    )
    grid = build_grid(triangulate(scene), element)
    full = expand(scene)
    return grid, apply_loads(full.loads, true_sides(full), grid, seed(grid))


BOXED = [
    {"name": "support", "box": [[20, -1], [33.3, 7]], "displacement": {"x": 0, "y": 0}},
    {"name": "pull", "box": [[61.7, 47], [100.01, 61]], "traction": [1, 2]},
    {"name": "arc", "box": [[44, 20], [57, 60]], "traction": [0.3, 1]},
    {"name": "left", "edge": "left", "traction": [0, 1]},
    {"name": "hole", "edge": "hole", "traction": [-3, 1]},
]


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_what_lies_in_a_box_does_not_depend_on_the_grid(element):
    found = []
    for size in (3, 7, 11.3, 23):
        grid, loading = meshed(size, element, BOXED)
        support = grid.nodes[loading.boundaries["support"].nodes]
        assert support.min(axis=0).tolist() == [20, 0]
        assert support.max(axis=0).tolist() == [33.3, 0]
        pull, arc = loading.boundaries["pull"], loading.boundaries["arc"]
        np.testing.assert_allclose(
            pull.force.sum(axis=0), np.array([1, 2]) * (38.3 + 13), rtol=1e-12
        )
        # The top and, of the circle, what is above and below the border of the box.
        arcs = 2 * 9 * (np.arcsin(7 / 9) + np.arcsin(6 / 9))
        np.testing.assert_allclose(
            arc.force.sum(axis=0), np.array([0.3, 1]) * (13 + arcs), rtol=1e-9
        )
        force = np.zeros_like(grid.nodes)
        force[pull.nodes] += pull.force
        found.append(moment(grid, force))
    np.testing.assert_allclose(found, found[0], rtol=1e-12)


@pytest.mark.parametrize("size", [3, 23])
def test_a_traction_on_an_arc_acts_on_its_true_length(size):
    grid, loading = meshed(size, "T6", BOXED)
    radius = 30.0
    left, hole = loading.boundaries["left"], loading.boundaries["hole"]
    np.testing.assert_allclose(left.force.sum(axis=0), [0, np.pi * radius], rtol=1e-9)
    np.testing.assert_allclose(hole.force.sum(axis=0), np.array([-3, 1]) * 2 * np.pi * 9, rtol=1e-9)
    # A uniform traction on a circle acts at its centre; chords of unequal length miss it a little.
    np.testing.assert_allclose(hole.weights @ grid.nodes[hole.nodes], [50, 30], atol=4e-3)


def test_a_margin_of_a_box_makes_no_small_elements():
    nodes = [
        len(
            meshed(23, "T3", [{"box": [[-m, -m], [100 + m, m]], "displacement": {"y": 0}}])[0].nodes
        )
        for m in (1e-3, 0.05)
    ]
    assert nodes[0] == nodes[1]


def test_a_traction_that_a_support_takes_up_is_told():
    """A corner that both share is no reason for a warning."""
    support = {"name": "held", "edge": "bottom", "displacement": {"x": 0, "y": 0}}
    _, loading = load([support, {"edge": "left", "traction": [1, 1]}])
    assert loading.warnings == ()
    across = {"name": "across", "box": [[1, -1], [9, 1]], "traction": [0, 1]}
    _, loading = load([support, across])
    assert loading.warnings == (
        "loads[1].traction: 75 % of across acts where u_y is prescribed, and is carried by "
        "that support alone: take it off there, or leave u_y free there",
    )
    _, loading = load(
        [support | {"displacement": {"x": 0}}, support | {"name": "b", "edge": "left"}, across]
    )
    assert loading.warnings == ()


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
                {"box": [[0.2, 1.9], [0.5, 3]], "displacement": {"x": 0}},
            ],
            "no node of the boundary lies in the box: the grid is too coarse for it",
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
    """A plate whose right part is cut off by a crack and carries a traction only."""
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


@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("support", [{}, {"x": 0}, {"y": 0}])
def test_a_displacement_at_rest_has_no_motion_that_nothing_holds(element, support):
    pull = [{"edge": "left", "traction": [-1, 0]}, {"edge": "right", "traction": [1, 0]}]
    loads = [{"edge": "bottom", "displacement": support}] if support else pull
    grid, loading = load(loads, element=element)
    x, y = grid.nodes.T
    # The motions that the supports let pass, and a strain on top.
    rigid = [np.column_stack([0 * x, 0 * x + 1])] if "y" not in support else []
    rigid += [np.column_stack([0 * x + 1, 0 * x])] if "x" not in support else []
    rigid += [np.column_stack([-y, x])] if "y" not in support else []
    assert len(loading.loose) == len(rigid)
    strain = np.column_stack([x * y, x**2])
    moved = strain + sum(k * motion for k, motion in enumerate(rigid, 2))
    found = loading.at_rest(moved)
    np.testing.assert_allclose(found, loading.at_rest(strain), atol=1e-12)
    for motion in rigid:  # its mean over the body along each of them is zero
        assert (loading.node_area * motion * found).sum() == pytest.approx(0.0, abs=1e-11)
    assert loading.node_area.sum() == pytest.approx(8.0)
    for axis in support:
        held = y == 0.0, "xy".index(axis)
        np.testing.assert_array_equal(found[held], moved[held])


HELD = {"edge": "bottom", "displacement": {"x": 0, "y": 0}}
BOTH = [
    HELD,
    {"name": "weight", "body_force": [0.1, -0.3]},
    {"name": "grip", "edge": "left", "displacement": {"x": 0}},
    {"name": "fixed_pull", "edge": "top", "traction": [0.5, 3.0]},
    {"name": "pull", "edge": "top", "traction": [1.0, 2.0]},
]


@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("factor", [0.0, 1.0, -2.5])
def test_fixed_loads_act_in_full_at_every_factor(element, factor):
    fixed = {"weight", "fixed_pull"}
    _, loading = load(BOTH, element=element, fixed=fixed)
    _, alone = load([part for part in BOTH if part.get("name") != "pull"], element=element)
    _, others = load([part for part in BOTH if part.get("name") not in fixed], element=element)
    at = loading.at(factor)
    expected = alone.proportional.plus(others.proportional.times(factor))
    np.testing.assert_allclose(at.force, expected.force, atol=1e-14)
    np.testing.assert_allclose(at.own_weight, expected.own_weight, atol=1e-14)
    np.testing.assert_allclose(at.body_force, [0.1, -0.3], rtol=1e-15)
    assert not loading.is_proportional
    assert loading.fixed_names == fixed
    np.testing.assert_array_equal(loading.prescribed, alone.prescribed)
    parts = loading.boundaries["fixed_pull"], loading.boundaries["pull"]
    for part, expected in zip(parts, ([2.0, 12.0], [4.0 * factor, 8.0 * factor]), strict=True):
        np.testing.assert_allclose(part.force_at(factor).sum(axis=0), expected, atol=1e-13)


def test_a_fixed_displacement_adds_to_a_proportional_one():
    """Displacements of one part (fixed or proportional) must agree; those of both parts add up."""
    grip = [
        {"name": "set", "edge": "top", "displacement": {"y": 0.1}},
        {"name": "driven", "edge": "top", "displacement": {"y": 0.3}},
    ]
    with pytest.raises(SceneError, match=r"u_y = 0.3 mm where loads\[1\] prescribes 0.1 mm"):
        load([HELD, *grip])
    grid, loading = load([HELD, *grip], fixed={"set"})
    top = np.unique(grid.edges["top"])
    np.testing.assert_allclose(loading.at(2.0).displacement[top, 1], 0.7, rtol=1e-15)
    # The force there is reported once, at the part that came first.
    assert loading.boundaries["set"].holds[:, 1].all()
    assert not loading.boundaries["driven"].holds.any()


def test_each_part_has_to_be_in_balance():
    """The resultants cancel at load factor one only."""
    loads = [
        {"name": "up", "edge": "top", "traction": [0, 1]},
        {"name": "down", "edge": "bottom", "traction": [0, -1]},
    ]
    assert load(loads)[1].held == 3
    for fixed in ({"up"}, {"down"}):
        with pytest.raises(SceneError, match="out of balance"):
            load(loads, fixed=fixed)
    assert load(loads, fixed={"up", "down"})[1].held == 3


def test_nothing_fixed_is_proportional():
    zero = {"name": "zero", "edge": "top", "traction": [0, 0]}
    _, loading = load([HELD, zero], fixed={"zero"})
    assert loading.is_proportional
    assert not loading.any
    assert not loading.fixed_alone().any
