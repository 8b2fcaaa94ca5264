from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from structured import rectangle

from cfmpm.body.grid import build_grid
from cfmpm.body.tip_domains import choose_domains
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


def test_clearance_ends_at_a_bend():
    triangulation = rectangle(20, 20, 10.0, 10.0)
    number = np.arange(21 * 21).reshape(21, 21)
    line = np.concatenate([number[0:6, 8], number[5, 9:11], number[6:9, 10]])
    bent = build_grid(
        replace(triangulation, cracks={"c": np.column_stack([line[:-1], line[1:]])}), "T3"
    )
    (tip,) = bent.tips
    assert tip.straight == pytest.approx(1.5)
    np.testing.assert_allclose(tip.tangent, [1, 0], atol=1e-15)
    assert tip_clearance(bent, tip) == pytest.approx(1.5)


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
    """A crack that turns back on itself, 1 mm apart, seen from a tip that runs."""
    triangulation = rectangle(20, 20, 10.0, 10.0)
    number = np.arange(21 * 21).reshape(21, 21)
    line = np.concatenate([number[0:15, 8], number[14, 9:11], number[13:5:-1, 10]])
    hook = build_grid(
        replace(triangulation, cracks={"c": np.column_stack([line[:-1], line[1:]])}), "T3"
    )
    (tip,) = hook.tips
    assert tip.straight == pytest.approx(4.0)
    assert tip_clearance(hook, tip) == pytest.approx(1.0)
    assert tip_clearance(hook, tip, growing=True) == pytest.approx(1.0)


def test_a_tip_on_the_border_of_another_material_is_refused_unless_it_runs(grid):
    (tip,) = grid.tips
    centres = grid.nodes[grid.triangles].mean(axis=1)
    halves = replace(
        grid, regions=(centres[:, 0] > 5.0).astype(int), region_names=("body", "right")
    )
    with pytest.raises(SceneError, match="border of another material"):
        choose_domains(halves, tip, 3)
    assert choose_domains(halves, tip, 3, growing=True).clearance == pytest.approx(4.0)
