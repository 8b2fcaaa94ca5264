"""A kind of load that another package adds: pressure along the boundary."""

from __future__ import annotations

from pathlib import Path

import pytest
from foreign_package import install, run

ENTRY = """
from cfmpm.registry.loads import LoadKind

PRESSURE = LoadKind(
    "normal to an edge, into the body [MPa]",
    "cfmpm.scene.quantities:Number",
    "pressure_load:apply",
    ("edge",),
    "MPa",
)


def apply(value, place, grid):
    import numpy as np

    from cfmpm.body.applied import Applied

    force = np.zeros((len(place.nodes), 2))
    edges = place.segments.edges
    along = grid.nodes[edges[:, 1]] - grid.nodes[edges[:, 0]]
    inward = np.column_stack([-along[:, 1], along[:, 0]]) / np.hypot(*along.T)[:, None]
    row = {node: i for i, node in enumerate(place.nodes)}
    for nodes, weights, normal in zip(edges, place.segments.weights, inward):
        for node, weight in zip(nodes, weights):
            force[row[node]] += value * weight * normal
    return Applied(force=force)
"""
# A disc under pressure is in a state of uniform pressure; a plate by pressure as by traction.
SCENES = """
import numpy as np
import cfmpm

disc = {
    "name": "disc",
    "geometry": {"outline": [
        {"at": [-1, 0], "edge": "rim", "through": [0, -1]},
        {"at": [1, 0], "edge": "rim", "through": [0, 1]},
    ]},
    "material": {"E": 1000, "nu": 0.3},
    "loads": [{"edge": "rim", "pressure": 7}],
    "mesh": {"size": 0.2, "element": "T3"},
}
stress = cfmpm.run(cfmpm.scene_from_dict(disc)).points.stress
scatter = np.abs(stress - [-7, -7, 0]).max() / 7
assert scatter < 0.02, scatter

plate = {
    "name": "plate",
    "family": {"kind": "single_edge", "width": 5, "height": 10, "crack_length": 2},
    "material": {"E": 1000, "nu": 0.3},
    "mesh": {"size": 1},
}
def K(load):
    loads = [{"edge": "top", **load(1)}, {"edge": "bottom", **load(-1)}]
    return cfmpm.run(cfmpm.scene_from_dict(plate | {"loads": loads})).history.K_I.values

same = K(lambda sign: {"pressure": -3}), K(lambda sign: {"traction": [0, 3 * sign]})
np.testing.assert_allclose(*same, rtol=1e-10)

try:
    cfmpm.scene_from_dict(disc | {"loads": [{"point": [1, 0], "pressure": 7}]})
except cfmpm.SceneError as error:
    assert "does not fit: a pressure goes with edge" in str(error), error
else:
    raise AssertionError("pressure at a point")
"""


@pytest.mark.slow
def test_pressure(tmp_path: Path) -> None:
    points = "[cfmpm.loads]\npressure = pressure_load:PRESSURE\n"
    install(tmp_path, {"pressure_load.py": ENTRY}, points)
    run(tmp_path, SCENES)
