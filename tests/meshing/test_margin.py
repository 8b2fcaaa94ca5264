"""The margin around a body."""

from __future__ import annotations

import numpy as np
import pytest
from structured import rectangle

from cfmpm.body.grid import build_grid
from cfmpm.errors import MeshError
from cfmpm.kernels.triangles import triangle_quality
from cfmpm.meshing import triangulate
from cfmpm.meshing.margin import surround
from cfmpm.scene import expand, scene_from_dict


def areas(mesh):
    a, b, c = (mesh.nodes[mesh.triangles[:, k]] for k in range(3))
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    return 0.5 * (ux * vy - uy * vx)


@pytest.mark.parametrize("far", [(0.0, 0.0, 1.0), (1e6, -3e5, 0.1), (0.0, 0.0, 1e5)])
def test_rectangle_with_an_edge_crack(far):
    *shift, scale = far
    body = rectangle(6, 4, 6.0, 4.0, crack=(2, 0, 3))
    body.nodes[:] = scale * body.nodes + shift
    whole = surround(body, 1.0 * scale, 1.0 * scale)
    n, m = len(body.nodes), len(body.triangles)
    np.testing.assert_array_equal(whole.nodes[:n], body.nodes)
    np.testing.assert_array_equal(whole.triangles[:m], body.triangles)
    # 8 x 6 filled once: areas add up, and no triangle is turned.
    np.testing.assert_allclose(areas(whole).sum(), 48.0 * scale**2, rtol=1e-8)
    assert triangle_quality(whole.nodes, whole.triangles).min() > 0.2
    low, high = (whole.nodes.min(axis=0) - shift) / scale, (whole.nodes.max(axis=0) - shift) / scale
    np.testing.assert_allclose([*low, *high], [-1, -1, 7, 5], atol=1e-5)
    # The crack runs on to the outer side, and is open there.
    pairs = whole.cracks["crack_1"]
    np.testing.assert_array_equal(pairs[1:, 0], pairs[:-1, 1])
    np.testing.assert_array_equal(pairs[-3:], body.cracks["crack_1"])
    mouth = (whole.nodes[pairs[0, 0]] - shift) / scale
    np.testing.assert_allclose(mouth, [-1.0, 2.0], atol=1e-5)
    grid = build_grid(whole, "T3")
    assert [tip.node for tip in grid.tips] == [body.cracks["crack_1"][-1, 1]]
    # Every side of the margin has its twin: nothing but the outer side and the faces is open.
    element, side = np.nonzero(grid.twins < 0)
    ends = grid.edge_nodes(3 * element + side)
    x = (grid.nodes[ends].mean(axis=1) - shift) / scale
    outer = (np.abs(x - [3.0, 2.0]) > np.array([3.999, 2.999])).any(axis=1)
    faces = grid.crack_faces["crack_1"].size
    assert np.count_nonzero(~outer) == faces


def test_a_margin_is_the_same_in_a_child_process(monkeypatch):
    body = rectangle(6, 4, 6.0, 4.0, crack=(2, 0, 3))
    here = surround(body, 1.0, 1.0)
    monkeypatch.setattr("cfmpm.meshing.margin.MOST_SIDES", 1)
    there = surround(body, 1.0, 1.0)
    np.testing.assert_array_equal(there.nodes, here.nodes)
    np.testing.assert_array_equal(there.triangles, here.triangles)
    np.testing.assert_array_equal(there.cracks["crack_1"], here.cracks["crack_1"])


def test_holes_are_filled_and_cracks_from_them_end_inside():
    scene = scene_from_dict(
        {
            "name": "plate",
            "geometry": {
                "outline": [[0, 0], [20, 0], [20, 12], [0, 12]],
                "holes": [{"circle": {"centre": [10, 6], "radius": 2}}],
                "cracks": [{"points": [[12, 6], [15, 6]]}],
            },
            "material": {"E": 210e3, "nu": 0.3},
            "loads": [{"edge": "edge_1", "displacement": {"y": 0}}],
            "mesh": {"element": "T3", "size": 1},
        }
    )
    body = triangulate(expand(scene))
    whole = surround(body, 2.0, 1.0)
    np.testing.assert_allclose(areas(whole).sum(), 24.0 * 16.0, rtol=1e-8)
    (pairs,) = whole.cracks.values()
    ends = whole.nodes[[pairs[0, 0], pairs[-1, 1]]]
    np.testing.assert_allclose(ends, [[10, 6], [15, 6]], atol=1e-6)


def test_two_parts_are_refused():
    one = rectangle(2, 2)
    n = len(one.nodes)
    both = type(one)(
        **{
            **vars(one),
            "nodes": np.vstack([one.nodes, one.nodes + 5.0]),
            "triangles": np.vstack([one.triangles, one.triangles + n]),
            "regions": np.zeros(2 * len(one.triangles), np.int64),
        }
    )
    with pytest.raises(MeshError, match="one part"):
        surround(both, 1.0, 1.0)
