from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from structured import rectangle

from cfmpm.body.grid import build_grid, regions_ahead, signed_areas


def euler_characteristic(grid):
    edges = (grid.twins < 0).sum() + (grid.twins >= 0).sum() // 2
    return grid.n_corners - edges + len(grid.twins)


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_edge_crack_doubles_all_but_the_tip(element):
    triangulation = rectangle(6, 4, crack=(2, 0, 3), shake=0.3)
    grid = build_grid(triangulation, element)
    assert grid.n_corners == len(triangulation.nodes) + 3
    assert euler_characteristic(grid) == 1
    (tip,) = grid.tips
    assert tip.name == "crack_1"
    np.testing.assert_allclose(grid.nodes[tip.node], [0.5, 0.5])
    np.testing.assert_allclose(tip.tangent, [1, 0], atol=1e-15)
    left, right = grid.crack_faces["crack_1"].T
    upper, lower = grid.edge_nodes(left), grid.edge_nodes(right)
    # The faces coincide, run against each other and share nothing but the tip.
    np.testing.assert_array_equal(grid.nodes[upper[:, :2]], grid.nodes[lower[:, [1, 0]]])
    assert set(upper.ravel()) & set(lower.ravel()) == {tip.node}


def test_inner_crack_has_two_tips_and_opens_a_ring():
    grid = build_grid(rectangle(6, 4, crack=(2, 2, 4)), "T3")
    assert [tip.name for tip in grid.tips] == ["crack_1_start", "crack_1_end"]
    np.testing.assert_allclose([tip.tangent for tip in grid.tips], [[-1, 0], [1, 0]], atol=1e-15)
    assert euler_characteristic(grid) == 0


def test_inner_crack_of_one_edge_opens_only_between_its_ends():
    three = build_grid(rectangle(6, 4, crack=(2, 2, 3)), "T3")
    six = build_grid(rectangle(6, 4, crack=(2, 2, 3)), "T6")
    assert three.n_corners == 7 * 5
    faces = six.edge_nodes(six.crack_faces["crack_1"].ravel())
    assert faces[0, 2] != faces[1, 2]
    assert set(faces[0, :2]) == set(faces[1, :2])


def test_an_end_of_a_crack_is_a_tip_inside_the_grid_whatever_edges_are_named():
    edge = rectangle(6, 4, crack=(2, 0, 3), shake=0.3)
    inner = rectangle(6, 4, crack=(2, 2, 4), shake=0.3)
    # As in a grid with a margin: the mouth is on no named edge, and a tip may be on one.
    unnamed = replace(edge, edges={"elsewhere": np.array([[edge.end_of("crack_1", -1)] * 2])})
    for mesh, expected in ((edge, [False, True]), (inner, [True, True]), (unnamed, [False, True])):
        assert [mesh.is_tip("crack_1", end) for end in (0, -1)] == expected
        assert [mesh.is_inside(mesh.end_of("crack_1", end)) for end in (0, -1)] == expected
    # Where two crack lines meet there is no tip.
    met = replace(inner, cracks=inner.cracks | {"crack_2": inner.cracks["crack_1"][1:, ::-1]})
    assert [met.is_tip("crack_1", end) for end in (0, -1)] == [True, False]


@pytest.mark.parametrize("crack", [(2, 0, 3), (2, 2, 4)])
def test_length_of_a_crack_is_that_of_its_line_from_each_tip(crack):
    mesh = rectangle(6, 4, crack=crack)
    mesh.nodes[mesh.cracks["crack_1"][1, 0], 1] += 0.1
    pairs = mesh.nodes[mesh.cracks["crack_1"]]
    expected = np.hypot(*(pairs[:, 1] - pairs[:, 0]).T).sum()
    assert mesh.crack_lengths == {"crack_1": pytest.approx(expected, rel=1e-14)}
    for tip in build_grid(mesh, "T3").tips:
        assert tip.crack_length == pytest.approx(expected, rel=1e-14)


def test_named_edges_take_the_nodes_of_their_own_side_of_the_crack():
    grid = build_grid(rectangle(6, 4, crack=(2, 0, 3)), "T6")
    left = grid.edges["left"]
    assert left.shape == (4, 3)
    mouth = [node for node in left[:, :2].ravel() if np.allclose(grid.nodes[node], [0, 0.5])]
    assert len(set(mouth)) == 2
    np.testing.assert_allclose(
        grid.nodes[left[:, 2]], grid.nodes[left[:, :2]].mean(axis=1), atol=1e-15
    )


def test_t6_numbers_each_inner_edge_once():
    grid = build_grid(rectangle(5, 3, shake=0.4), "T6")
    edges = 5 * 4 + 6 * 3 + 15
    assert len(grid.nodes) == 24 + edges
    assert len(np.unique(grid.elements)) == len(grid.nodes)
    middle = grid.nodes[grid.elements[:, 3:]]
    ends = grid.nodes[grid.triangles], grid.nodes[np.roll(grid.triangles, -1, axis=1)]
    np.testing.assert_allclose(middle, 0.5 * (ends[0] + ends[1]), atol=1e-15)


@settings(max_examples=40)
@given(
    nx=st.integers(3, 9),
    ny=st.integers(2, 7),
    shake=st.floats(0, 0.45),
    seed=st.integers(0, 999),
    data=st.data(),
)
def test_opening_a_crack_keeps_area_twins_and_connection(nx, ny, shake, seed, data):
    row = data.draw(st.integers(1, ny - 1))
    first = data.draw(st.integers(0, nx - 2))
    last = data.draw(st.integers(first + 1, nx - 1))
    triangulation = rectangle(nx, ny, shake=shake, seed=seed, crack=(row, first, last))
    grid = build_grid(triangulation, "T6")
    assert grid.areas.sum() == pytest.approx(1.0, rel=1e-13)
    assert grid.areas.min() > 0
    element, side = np.nonzero(grid.twins >= 0)
    twin = grid.twins[element, side]
    assert (grid.twins[twin // 3, twin % 3] == 3 * element + side).all()
    # Both ends of an edge are the same nodes seen from either triangle.
    assert (grid.edge_nodes(3 * element + side)[:, [1, 0, 2]] == grid.edge_nodes(twin)).all()
    opened = last - first - (first > 0)
    assert grid.n_corners == (nx + 1) * (ny + 1) + opened


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("degrees", [0.0, 17.0, 130.0, -75.0])
def test_regions_ahead_are_two_along_their_border_and_else_one(degrees, swapped):
    """A direction within round-off of the border counts as along it; 1e-6 rad off does not."""
    flat = build_grid(rectangle(6, 4, crack=(2, 0, 3)), "T3")
    centre = flat.nodes[flat.triangles].mean(axis=1)
    above = (centre[:, 1] > 0.5).astype(int)
    turn = np.exp(1j * np.radians(degrees))
    turned = turn * (flat.nodes @ [1.0, 1.0j])
    grid = replace(
        flat,
        nodes=np.column_stack([turned.real, turned.imag]),
        regions=1 - above if swapped else above,
        region_names=("below", "above"),
    )
    upper, lower = (0, 1) if swapped else (1, 0)
    for off, regions in ((0.0, [0, 1]), (1e-13, [0, 1]), (1e-6, [upper]), (-1e-6, [lower])):
        way = turn * np.exp(1j * off)
        found = regions_ahead(grid, grid.tips[0], np.array([way.real, way.imag]))
        assert found == regions, off
    for off, region in ((0.7, upper), (-0.7, lower), (1.5, upper), (-1.5, lower)):
        way = turn * np.exp(1j * off)
        assert regions_ahead(grid, grid.tips[0], np.array([way.real, way.imag])) == [region]


def test_signed_areas():
    corners = np.array([[[1e6, 0], [1e6 + 4, 0], [1e6, 3]], [[0, 0], [0, 3], [4, 0]]], float)
    assert signed_areas(corners).tolist() == [6.0, -6.0]
