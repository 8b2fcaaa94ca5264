from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from structured import rectangle

from cfmpm.fracture.domains import choose_domains, tip_clearance
from cfmpm.grid import build_grid


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
    assert cut.radii == (1.0, pytest.approx(3.6))
    assert cut.cut_back
