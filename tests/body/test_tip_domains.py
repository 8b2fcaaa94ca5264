from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from structured import rectangle

from cfmpm.body.grid import build_grid
from cfmpm.body.tip_domains import TipDomain, choose_domains, sharp_bend
from cfmpm.errors import SceneError


def tip_clearance(grid, tip, *, growing=False):
    return choose_domains(grid, tip, 1, growing=growing).clearance


@pytest.fixture(scope="module")
def grid():
    return build_grid(rectangle(20, 20, 10.0, 10.0, crack=(8, 0, 10)), "T6")


def test_clearance_ends_at_the_nearest_edge(grid):
    (tip,) = grid.tips
    assert tip_clearance(grid, tip) == pytest.approx(4.0)


def test_clearance_ends_at_supports_and_other_materials(grid):
    (tip,) = grid.tips
    near = int(np.flatnonzero(np.all(np.isclose(grid.nodes, [6.5, 6.0]), axis=1))[0])
    assert tip_clearance(replace(grid, points={"pin": near}), tip) == pytest.approx(
        np.hypot(1.5, 2)
    )
    centres = grid.nodes[grid.triangles].mean(axis=1)
    layered = replace(
        grid, regions=(centres[:, 1] > 5.5).astype(int), region_names=("body", "layer")
    )
    assert tip_clearance(layered, tip) == pytest.approx(1.5)


def test_clearance_ends_at_the_other_tip_and_at_other_cracks():
    triangulation = rectangle(20, 20, 10.0, 10.0, crack=(8, 6, 12))
    inner = build_grid(triangulation, "T3")
    assert [tip_clearance(inner, tip) for tip in inner.tips] == pytest.approx([3.0, 3.0])
    other = rectangle(20, 20, 10.0, 10.0, crack=(10, 11, 18)).cracks["crack_1"]
    both = build_grid(
        replace(triangulation, cracks={**triangulation.cracks, "crack_2": other}), "T3"
    )
    assert len(both.tips) == 4
    assert tip_clearance(both, both.tips[1]) == pytest.approx(1.0)


def test_clearance_ends_at_a_sharp_bend():
    triangulation = rectangle(20, 20, 10.0, 10.0)
    number = np.arange(21 * 21).reshape(21, 21)
    line = np.concatenate([number[0:6, 8], number[5, 9:11], number[6:9, 10]])
    bent = build_grid(
        replace(triangulation, cracks={"c": np.column_stack([line[:-1], line[1:]])}), "T3"
    )
    (tip,) = bent.tips
    np.testing.assert_allclose(tip.tangent, [1, 0], atol=1e-15)
    assert tip_clearance(bent, tip) == pytest.approx(1.5)


@pytest.mark.parametrize("growing", [False, True])
@pytest.mark.parametrize(("turn", "clearance"), [(5.0, 4.0), (-19.0, 4.0), (21.0, 1.0)])
def test_a_crack_that_bends_little_by_little_leaves_its_domain_room(grid, turn, clearance, growing):
    """Segments of 1 mm with small turns: only sharp corners limit the domain."""
    (tip,) = grid.tips
    bent = with_path(tip, *(turned(180.0 + i * turn) for i in range(6)))
    found = choose_domains(grid, bent, 1, growing=growing).clearance
    assert found == pytest.approx(4.0 if growing else clearance)


@pytest.mark.parametrize("count", [1, 2, 3, 7])
def test_chosen_radii_fit_in(grid, count):
    (tip,) = grid.tips
    domains = choose_domains(grid, tip, count)
    assert len(domains.radii) == count
    assert max(domains.radii) == pytest.approx(0.9 * 4.0)
    assert min(domains.radii) >= 0.5 * max(domains.radii)
    assert not domains.cut_back


def test_radii_asked_for_are_kept_or_cut_back(grid):
    (tip,) = grid.tips
    assert choose_domains(grid, tip, [1.0, 3.0]).radii == (1.0, 3.0)
    cut = choose_domains(grid, tip, [1.0, 30.0])
    # All by one factor: their spread goes on to say something.
    assert cut.radii == (pytest.approx(0.12), pytest.approx(3.6))
    assert cut.cut_back


def test_clearance_ends_at_its_own_flank():
    """A crack that turns back at a distance of 1 mm limits the clearance of its growing tip."""
    triangulation = rectangle(20, 20, 10.0, 10.0)
    number = np.arange(21 * 21).reshape(21, 21)
    line = np.concatenate([number[0:15, 8], number[14, 9:11], number[13:5:-1, 10]])
    hook = build_grid(
        replace(triangulation, cracks={"c": np.column_stack([line[:-1], line[1:]])}), "T3"
    )
    (tip,) = hook.tips
    assert tip_clearance(hook, tip) == pytest.approx(1.0)
    assert tip_clearance(hook, tip, growing=True) == pytest.approx(1.0)


def test_a_tip_on_the_border_of_another_material_is_refused_unless_it_runs(grid):
    (tip,) = grid.tips
    centres = grid.nodes[grid.triangles].mean(axis=1)
    halves = replace(
        grid, regions=(centres[:, 0] > 5.0).astype(int), region_names=("body", "right")
    )
    with pytest.raises(SceneError, match="interface to another material"):
        choose_domains(halves, tip, 3)
    assert choose_domains(halves, tip, 3, growing=True).clearance == pytest.approx(4.0)


def turned(angle):
    """Unit vector at an angle [deg]."""
    return np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])


def with_path(tip, *ways):
    """The tip with another crack path, given by segments from the tip on."""
    path = tip.path[0] + np.concatenate([np.zeros((1, 2)), np.cumsum(ways, axis=0)])
    return replace(tip, path=path)


@pytest.mark.parametrize(
    ("h", "largest"),
    [
        (0.1, 2.0),  # 20 elements
        (0.049, 1.0),  # of a graded grid a quarter of the clearance of 4 mm
        (0.2, 3.6),  # at most 0.9 of that
    ],
)
def test_radii_of_a_tip_at_rest_reach_over_twenty_elements(grid, h, largest):
    (tip,) = grid.tips
    domains = choose_domains(grid, replace(tip, h=h), 3)
    assert domains.radii == pytest.approx([0.5 * largest, 0.75 * largest, largest])
    assert domains.elements == pytest.approx(largest / h)
    assert not domains.growing


@pytest.mark.parametrize(("h", "largest"), [(0.1, 0.5), (0.01, 0.05), (0.8, 3.6)])
def test_radii_of_a_running_tip_reach_over_five(grid, h, largest):
    (tip,) = grid.tips
    domains = choose_domains(grid, replace(tip, h=h), 2, growing=True)
    assert domains.radii == pytest.approx([0.5 * largest, largest])
    assert domains.growing


def test_radii_that_just_fit_are_not_cut_back(grid):
    (tip,) = grid.tips
    largest = 0.9 * choose_domains(grid, tip, 1).clearance
    for radius, cut in ((largest, False), (0.5 * largest, False), (1.001 * largest, True)):
        domains = choose_domains(grid, tip, [0.1 * radius, radius])
        assert domains.cut_back == cut
        assert max(domains.radii) == pytest.approx(min(radius, largest))
        assert domains.elements == pytest.approx(max(domains.radii) / tip.h)


def test_a_running_tip_keeps_off_the_other_end_of_its_crack_and_not_off_its_bends():
    triangulation = rectangle(20, 20, 10.0, 10.0, crack=(8, 6, 12))
    inner = build_grid(triangulation, "T3")
    for tip in inner.tips:
        assert tip_clearance(inner, tip, growing=True) == pytest.approx(3.0)
        bent = with_path(tip, 0.5 * turned(10.0), 2.0 * turned(40.0))
        assert tip_clearance(inner, bent, growing=True) > 2.3


@pytest.mark.parametrize(("apex", "flank"), [(58.0, True), (62.0, False)])
def test_what_is_twice_as_far_by_the_crack_as_straight_across_is_a_flank(grid, apex, flank):
    """Two segments of 1 mm at an angle: 1 / sin(angle / 2) times the direct distance."""
    (tip,) = grid.tips
    back = turned(180.0 + apex)
    end = turned(0.0) + back
    bent = with_path(tip, turned(0.0), back, 4.0 * end / np.hypot(*end))
    found = tip_clearance(grid, bent, growing=True)
    assert found == pytest.approx(np.hypot(*end) if flank else 4.0)


def test_a_point_of_a_load_limits_a_domain_but_for_the_tip_itself(grid):
    (tip,) = grid.tips
    assert tip_clearance(replace(grid, points={"tip": tip.node}), tip) == pytest.approx(4.0)


@pytest.mark.parametrize(("way", "ahead"), [((1.0, 0.75), True), ((0.75, 1.0), False)])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_what_lies_within_45_degrees_is_ahead(grid, way, ahead, side):
    """Points at 37 and 53 degrees, 1.25 mm away; points behind the tip do not lie ahead."""
    (tip,) = grid.tips
    for along in (1.0, -1.0):
        at = tip.path[0] + np.array(way) * [along, side]
        node = int(np.flatnonzero(np.all(np.isclose(grid.nodes, at), axis=1))[0])
        domains = choose_domains(replace(grid, points={"pin": node}), tip, 1, growing=True)
        assert domains.clearance == pytest.approx(1.25)
        assert domains.runs_at == (ahead and along > 0.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_bend_by_more_than_twenty_degrees_is_sharp(grid, sign):
    """To either side; the nearest bend counts."""
    (tip,) = grid.tips
    for turn, distance in ((19.0, np.inf), (21.0, 1.2)):
        path = with_path(
            tip, 0.7 * turned(180.0), 0.5 * turned(180.0), 2.0 * turned(180.0 + sign * turn)
        )
        assert sharp_bend(path) == pytest.approx(distance)
    twice = with_path(tip, turned(180.0), turned(180.0 + sign * 30.0), turned(180.0))
    assert sharp_bend(twice) == pytest.approx(1.0)
    assert choose_domains(grid, twice, 1, growing=True).since_bend == pytest.approx(1.0 / tip.h)


@pytest.mark.parametrize(
    ("of", "steers"),
    [
        ({"elements": 2.0, "runs_at": True}, True),
        ({"elements": 1.99, "runs_at": True}, False),
        ({"elements": 0.1, "runs_at": False}, True),
        ({"since_bend": 2.0}, True),
        ({"since_bend": 1.99}, False),
        ({"on_border": True}, False),
    ],
)
def test_which_domains_tell_a_direction(of, steers):
    """Two elements to an object ahead are needed, and two since the last sharp bend."""
    assert TipDomain((1.0,), 4.0, cut_back=False, growing=True, **of).steers == steers


def test_a_running_tip_on_a_border_is_told(grid):
    (tip,) = grid.tips
    centres = grid.nodes[grid.triangles].mean(axis=1)
    for x, on_border in ((5.0, True), (6.0, False)):
        halves = replace(
            grid, regions=(centres[:, 0] > x).astype(int), region_names=("body", "right")
        )
        assert choose_domains(halves, tip, 3, growing=True).on_border == on_border
