from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from structured import rectangle

from cfmpm.body.grid import Triangulation, build_grid
from cfmpm.fracture.release import advance, fixed_nodes
from cfmpm.kernels.triangles import triangle_quality

EXACT = 1e-10  # degrees

elements = pytest.mark.parametrize("element", ["T3", "T6"])
ends = pytest.mark.parametrize("end", [0, -1])


def to(angle):
    """Unit vector at an angle [deg]."""
    return np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])


def cracked(number=0, shake=0.3, crack=(4, 3, 5), n=8):
    """A square of n by n cells of size one with a horizontal crack inside."""
    return rectangle(n, n, n, n, shake=shake, crack=crack, seed=number)


def areas(mesh):
    a, b, c = (mesh.nodes[mesh.triangles[:, k]] for k in range(3))
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def halve_cell(mesh, a, b, c, d):
    """Cut the cell of four nodes along a-c, in place."""
    there = np.isin(mesh.triangles, [a, b, c, d]).all(axis=1)
    mesh.triangles[there] = [(a, b, c), (a, c, d)]


def tip_of(mesh, crack="crack_1", end=-1):
    pairs = mesh.cracks[crack]
    return int(pairs[0, 0] if end == 0 else pairs[-1, 1])


def assert_sound(before: Triangulation, after):
    """No overlap, no lost area, fixed nodes stay, `changed` lists the changed triangles."""
    mesh = after.triangulation
    assert areas(mesh).min() > 0.0
    assert areas(mesh).sum() == pytest.approx(areas(before).sum(), rel=1e-14)
    fixed = np.flatnonzero(fixed_nodes(before))
    np.testing.assert_array_equal(mesh.nodes[fixed], before.nodes[fixed])
    n = len(before.triangles)
    same = (mesh.triangles[:n] == before.triangles).all(axis=1)
    same &= (mesh.nodes[mesh.triangles[:n]] == before.nodes[before.triangles]).all(axis=(1, 2))
    expected = np.concatenate([np.flatnonzero(~same), np.arange(n, len(mesh.triangles))])
    assert np.isin(expected, after.changed).all()
    np.testing.assert_array_equal(mesh.regions[:n], before.regions)
    covered = [areas(m)[after.changed[after.changed < len(m.triangles)]] for m in (before, mesh)]
    assert covered[0].sum() == pytest.approx(covered[1].sum(), rel=1e-13)


@ends
@pytest.mark.parametrize("number", range(5))
@pytest.mark.parametrize("kink", [-99.0, -71.0, -45.0, -14.7, 0.0, 3.0, 45.0, 90.0])
def test_a_segment_points_exactly_where_it_is_told(number, kink, end):
    mesh = cracked(number)
    angle = kink + (180.0 if end == 0 else 0.0)
    after = advance(mesh, "crack_1", end, 7.0 * to(angle))
    assert after.deviation < EXACT
    segment = after.triangulation.nodes[after.end] - after.triangulation.nodes[after.start]
    assert np.degrees(abs(np.angle(complex(*segment) / complex(*to(angle))))) < EXACT
    assert after.start == tip_of(mesh, end=end)
    assert after.end == tip_of(after.triangulation, end=end)
    assert after.triangulation.is_tip("crack_1", end)
    assert len(after.triangulation.cracks["crack_1"]) == len(mesh.cracks["crack_1"]) + 1
    assert after.quality > 0.1
    assert_sound(mesh, after)


def test_a_segment_that_points_there_already_stays():
    mesh = cracked(shake=0.0)
    after = advance(mesh, "crack_1", -1, to(0.0))
    np.testing.assert_allclose(after.triangulation.nodes, mesh.nodes, atol=1e-15)
    assert after.deviation < EXACT


@pytest.mark.parametrize("kink", [101.0, 150.0, 180.0, -140.0])
def test_a_crack_does_not_turn_back(kink):
    """A direction into the crack is turned to the largest kink angle, and reported."""
    mesh = cracked()
    after = advance(mesh, "crack_1", -1, to(kink))
    assert after.deviation == pytest.approx(abs(kink) - 100.0)
    assert_sound(mesh, after)


def test_a_wide_triangle_ahead():
    """The midpoint of the side ahead may lie behind the tip."""
    nodes = np.array([[0.0, 0], [1, 0], [-9, 1], [-9, -1], [-9, 0], [-12, 4], [3, 0], [-12, -4]])
    around = [(0, 1, 2), (0, 2, 4), (0, 4, 3), (0, 3, 1)]
    outside = [(1, 6, 5), (1, 5, 2), (2, 5, 4), (4, 5, 7), (4, 7, 3), (3, 7, 1), (1, 7, 6)]
    mesh = Triangulation(
        nodes=nodes,
        triangles=np.array(around + outside),
        regions=np.zeros(11, np.int64),
        region_names=("body",),
        edges={"rim": np.array([(6, 5), (5, 7), (7, 6)])},
        cracks={"crack_1": np.array([(4, 0)])},
        points={},
    )
    assert areas(mesh).min() > 0.0
    after = advance(mesh, "crack_1", -1, to(3.0))
    assert after.deviation < EXACT
    assert_sound(mesh, after)


@pytest.mark.parametrize("place", ["edge", "corner", "crack", "tip", "point"])
def test_arrival(place):
    """Arrival follows from topology; the last node is doubled there, or shared."""
    mesh = cracked(shake=0.0, crack=(4, 2, 7))
    number = np.arange(81).reshape(9, 9)
    angle = {"edge": 10.0, "corner": 44.9}.get(place, 0.0)
    if place == "corner":
        mesh = cracked(shake=0.0, crack=(7, 2, 7))
        a, b, c, d = number[7, 7], number[8, 7], number[8, 8], number[7, 8]
        halve_cell(mesh, b, c, d, a)
        angle = 45.0
    if place in ("crack", "tip", "point"):
        mesh = cracked(shake=0.0, crack=(4, 2, 4))
        line = number[5, 2:7] if place == "crack" else number[5, 4:7]
        if place == "point":
            mesh = replace(mesh, points={"push": int(number[5, 4])})
        else:
            other = np.column_stack([line[:-1], line[1:]])
            mesh = replace(mesh, cracks={**mesh.cracks, "crack_2": other})
    for _ in range(3):
        after = advance(mesh, "crack_1", -1, to(angle))
        assert_sound(mesh, after)
        mesh = after.triangulation
        if place == "point" or not mesh.is_tip("crack_1", -1):
            break
    names = {tip.name for tip in build_grid(mesh, "T3").tips}
    expected = {
        "edge": {"crack_1"},
        "corner": {"crack_1"},
        "crack": {"crack_1", "crack_2_start", "crack_2_end"},
        "tip": {"crack_1", "crack_2"},
        "point": {"crack_1_start", "crack_1_end"},
    }
    assert names == expected[place]
    grid = build_grid(mesh, "T3")
    doubled = len(grid.nodes) - len(mesh.nodes)
    inner = {name: len(pairs) - 1 for name, pairs in mesh.cracks.items()}
    # On the boundary the mouth is one more; a crack met from the side has three parts of a node,
    # and two cracks that meet at their tips have two.
    more = {"edge": 1, "corner": 1, "crack": 1, "tip": 1, "point": 0}[place]
    assert doubled == sum(inner.values()) + more


def test_a_crack_that_comes_back_to_itself():
    mesh = cracked(shake=0.2, n=12, crack=(6, 2, 8))
    angle, releases = 0.0, 0
    while mesh.is_tip("crack_1", -1):
        angle += 50.0
        after = advance(mesh, "crack_1", -1, to(angle))
        assert_sound(mesh, after)
        mesh = after.triangulation
        releases += 1
        assert releases < 20
    line = np.append(mesh.cracks["crack_1"][:, 0], tip_of(mesh))
    assert len(np.unique(line)) == len(line) - 1
    assert [tip.end for tip in build_grid(mesh, "T6").tips] == [0]


def test_a_side_between_fixed_nodes_is_split():
    """All nodes around the tip are on an interface of materials: the side ahead is split."""
    mesh = cracked(shake=0.0, n=8, crack=(4, 2, 4))
    centre = mesh.nodes[mesh.triangles].mean(axis=1)
    mesh = replace(
        mesh, regions=(centre[:, 0] > 5.0).astype(np.int64), region_names=("body", "other")
    )
    angle = 20.0
    after = advance(mesh, "crack_1", -1, to(angle))
    new = after.triangulation
    assert_sound(mesh, after)
    assert after.deviation < EXACT
    assert after.end == len(mesh.nodes)
    assert len(new.triangles) == len(mesh.triangles) + 2
    np.testing.assert_allclose(new.nodes[after.end], [5.0, 4.0 + np.tan(np.radians(angle))])
    assert new.nodes[after.end, 0] == 5.0
    corners = new.nodes[new.triangles]
    np.testing.assert_array_equal(new.regions == 1, corners.mean(axis=1)[:, 0] > 5.0)
    assert after.quality == triangle_quality(new.nodes, new.triangles[after.changed]).min()


@pytest.mark.parametrize(("angle", "met"), [(0.9, True), (4.5, True), (5.5, False), (18.0, False)])
def test_a_crack_ends_at_a_node_of_the_edge_only_where_it_is_near(angle, met):
    """A node at an angle has the rating 0.25 x 3 / angle; a split of the edge sin(2 angle)
    sqrt(3) / 2, the quality of the flat triangle. Both are equal at 5 degrees.
    """
    mesh = cracked(shake=0.0, crack=(4, 2, 7))
    halve_cell(mesh, 67, 76, 77, 68)
    after = advance(mesh, "crack_1", -1, to(angle))
    assert (after.end < len(mesh.nodes)) == met
    assert after.deviation == pytest.approx(angle if met else 0.0, abs=EXACT)
    assert not after.triangulation.is_tip("crack_1", -1)


def between_two_tips(distance):
    """A crack whose direction crosses the side between the tips of two others.

    One of these is 12 degrees off its direction; no node may move.
    """
    up, down = np.tan(np.radians(12.0)), -np.tan(np.radians(50.0))
    nodes = [[0.0, 0], [-1, 0], [0, 1], [0, -1], [2, 0.3], [1, up], [1, down]]
    nodes = np.array(nodes) * np.array([1, 1, 1, 1, distance, distance, distance])[:, None]
    triangles = [(0, 5, 2), (0, 2, 1), (0, 1, 3), (0, 3, 6), (0, 6, 5), (5, 4, 2), (6, 4, 5)]
    return Triangulation(
        nodes=nodes,
        triangles=np.array([*triangles, (3, 4, 6)]),
        regions=np.zeros(8, np.int64),
        region_names=("body",),
        edges={"rim": np.array([(4, 2), (2, 1), (1, 3), (3, 4)])},
        cracks={
            "crack_1": np.array([(1, 0)]),
            "above": np.array([(4, 5)]),
            "below": np.array([(3, 6)]),
        },
        points={},
    )


@pytest.mark.parametrize(("part", "met"), [(0.9, True), (1.1, False)])
def test_a_crack_does_not_creep_between_two_others(part, met):
    """Segments below 0.4 of the mean edge are rated lower in proportion, 12 degrees by 3 / 12.

    Both ratings are equal at a length of 0.1 mean edges; below that the crack meets the other
    tip. The longest segment tried is 1.3 times the distance to the side.
    """
    distance = 0.1 * part / 1.3
    for _ in range(20):  # the mean edge at the tip depends on it
        mean = (3.0 + distance / np.cos(np.radians(12)) + distance / np.cos(np.radians(50))) / 5
        distance = 0.1 * part * mean / 1.3
    mesh = between_two_tips(distance)
    assert areas(mesh).min() > 0.0
    after = advance(mesh, "crack_1", -1, to(0.0))
    assert_sound(mesh, after)
    assert after.end == (5 if met else len(mesh.nodes))
    assert after.deviation == pytest.approx(12.0 if met else 0.0, abs=EXACT)
    assert after.triangulation.is_tip("crack_1", -1) == (not met)


def test_a_crack_does_not_run_back_along_itself():
    """The tip of another crack beside it leaves only triangles of very low quality."""
    near = 0.02 * to(15.0)
    mesh = Triangulation(
        nodes=np.array([[0.0, 0], [-1, 0], [0, -1], [1, 0], [0, 2], near]),
        triangles=np.array([(0, 5, 1), (0, 1, 2), (0, 2, 3), (0, 3, 5), (5, 3, 4), (5, 4, 1)]),
        regions=np.zeros(6, np.int64),
        region_names=("body",),
        edges={"rim": np.array([(1, 2), (2, 3), (3, 4), (4, 1)])},
        cracks={"crack_1": np.array([(1, 0)]), "other": np.array([(4, 5)])},
        points={},
    )
    assert areas(mesh).min() > 0.0
    # 80 degrees from the crack itself, 85 from the tip of the other one.
    after = advance(mesh, "crack_1", -1, to(100.0))
    assert after.end == 5


def test_a_crack_that_is_met_between_its_nodes_has_one_more():
    mesh = cracked(shake=0.0, crack=(4, 2, 4))
    line = np.arange(81).reshape(9, 9)[5, 2:7]
    mesh = replace(mesh, cracks={**mesh.cracks, "other": np.column_stack([line[:-1], line[1:]])})
    after = advance(mesh, "crack_1", -1, to(25.0))
    new = after.triangulation
    assert after.end == len(mesh.nodes)
    np.testing.assert_allclose(new.nodes[after.end], [5.0, 4.0 + np.tan(np.radians(25.0))])
    met = [*line[:3], after.end, *line[3:]]
    np.testing.assert_array_equal(new.cracks["other"], np.column_stack([met[:-1], met[1:]]))
    assert_sound(mesh, after)


def test_the_border_of_a_material_stays_where_a_crack_splits_it():
    """Even if other segment lengths would give better triangles."""
    mesh = cracked(shake=0.0, n=8, crack=(4, 2, 4))
    centre = mesh.nodes[mesh.triangles].mean(axis=1)
    regions = (centre[:, 0] > 5.0).astype(np.int64)
    mesh = replace(mesh, regions=regions, region_names=("body", "other"))
    after = advance(mesh, "crack_1", -1, to(8.0))
    assert after.end == len(mesh.nodes)
    assert after.quality < 0.25
    assert after.triangulation.nodes[after.end, 0] == 5.0
    assert_sound(mesh, after)


@elements
def test_both_ends_of_a_crack_and_the_doubling(element):
    mesh = cracked(shake=0.3, crack=(4, 3, 5))
    before = build_grid(mesh, element)
    assert [tip.name for tip in before.tips] == ["crack_1_start", "crack_1_end"]
    for end, angle in ((0, 160.0), (-1, 30.0)):
        after = advance(mesh, "crack_1", end, to(angle))
        assert_sound(mesh, after)
        mesh = after.triangulation
    pairs = mesh.cracks["crack_1"]
    np.testing.assert_array_equal(pairs[1:, 0], pairs[:-1, 1])
    grid = build_grid(mesh, element)
    # Two more nodes inside the crack; T6 adds one in the middle of each face.
    corners = len(mesh.nodes) + len(pairs) - 1
    assert grid.n_corners == corners
    left, right = (grid.edge_nodes(grid.crack_faces["crack_1"][:, k]) for k in (0, 1))
    np.testing.assert_array_equal(grid.nodes[left[:, 0]], grid.nodes[right[:, 1]])
    np.testing.assert_array_equal(grid.nodes[left[:, 2:]], grid.nodes[right[:, 2:]])
    assert (left[:, 2:] != right[:, 2:]).all()
    assert [tuple(grid.nodes[tip.node]) for tip in grid.tips] == [
        tuple(mesh.nodes[tip_of(mesh, end=end)]) for end in (0, -1)
    ]


def test_twenty_bends_leave_sound_triangles():
    rng = np.random.default_rng(0)
    worst, lengths = [], []
    for number in range(20):
        mesh, angle = cracked(number, n=14, crack=(7, 0, 2)), 0.0
        for _ in range(20):
            if not mesh.is_tip("crack_1", -1):
                break
            angle = np.clip(angle + rng.uniform(-60.0, 60.0), -80.0, 80.0)
            after = advance(mesh, "crack_1", -1, to(angle))
            assert_sound(mesh, after)
            mesh = after.triangulation
            worst.append(triangle_quality(mesh.nodes, mesh.triangles).min())
            lengths.append(np.hypot(*(mesh.nodes[after.end] - mesh.nodes[after.start])))
    assert min(worst) > 0.05
    assert np.quantile(worst, 0.1) > 0.2
    assert min(lengths) > 0.1
