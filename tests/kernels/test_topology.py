"""Adjacency of triangles against plain graphs."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Delaunay

from cfmpm.kernels import topology


@pytest.mark.parametrize("share_of_cuts", [0.0, 0.3, 0.6, 1.0])
def test_connected_parts_are_those_of_the_graph_of_triangles(share_of_cuts: float) -> None:
    """Parts that sides without a twin separate, numbered by their first triangles."""
    rng = np.random.default_rng(7)
    twins = _twins(Delaunay(rng.random((200, 2))).simplices.astype(np.int64))
    for triangle, side in np.argwhere(twins >= 0):
        twin = twins[triangle, side]
        if twin >= 0 and rng.random() < share_of_cuts:
            twins[triangle, side] = twins[twin // 3, twin % 3] = -1
    element, side = np.nonzero(twins >= 0)
    links = (np.ones(len(element)), (element, twins[element, side] // 3))
    count, expected = connected_components(coo_array(links, shape=(len(twins),) * 2), False)
    found = topology.connected_parts(twins)
    np.testing.assert_array_equal(found, expected)
    assert (count == 1) == (share_of_cuts == 0.0)
    assert (count == len(twins)) == (share_of_cuts == 1.0)


def _twins(triangles: np.ndarray) -> np.ndarray:
    stars = topology.node_stars(triangles, int(triangles.max()) + 1)
    twins: np.ndarray = topology.find_twins(triangles, *stars)
    return twins
