"""A family of specimens that another package adds: two edge cracks."""

from __future__ import annotations

from pathlib import Path

import pytest
from extending import new_files, section
from foreign_package import install, run

ENTRY = """
from cfmpm.registry.specimens import SpecimenEntry

DOUBLE_EDGE = SpecimenEntry("foreign.double_edge:DoubleEdge")
"""
# Double-edge crack: Tada, Paris and Irwin, 0.5 %; the grid adds less than 0.1 %.
CODE = """
import math

from foreign.double_edge import DoubleEdge  # before the scene, of which it imports a part

import cfmpm
from cfmpm.scene.schema import schema

lengths = {"width": 100, "height": 300, "crack_length": 25}
plate = {
    "name": "plate",
    "family": {"kind": "double_edge", "traction": 10, **lengths},
    "material": {"E": 210e3, "nu": 0.3},
}
assert type(cfmpm.scene_from_dict(plate).family) is DoubleEdge
history = cfmpm.run(cfmpm.scene_from_dict(plate)).history
turn = math.pi * 25 / 100
known = 10 * (1 + 0.122 * math.cos(turn) ** 4) * math.sqrt(100 * math.tan(turn))
assert list(history.tip.values) == ["left_crack", "right_crack"]
for found in history.K_I[-1].values:
    assert math.isclose(found, known, rel_tol=6e-3), (found, known)

family = {"kind": "double_edge", "traction": 10, **lengths, "crack_length": 50}
try:
    cfmpm.scene_from_dict(plate | {"family": family})
except cfmpm.SceneError as error:
    assert "must be less than half the width, 50" in str(error), error
else:
    raise AssertionError("cracks that meet")
assert "DoubleEdge" in schema()["$defs"]
"""


@pytest.mark.slow
def test_two_edge_cracks(tmp_path: Path) -> None:
    (text, _) = new_files(section("A family of geometries")).values()
    files = {"foreign/__init__.py": ENTRY, "foreign/double_edge.py": text}
    install(tmp_path, files, "[cfmpm.specimens]\ndouble_edge = foreign:DOUBLE_EDGE\n")
    run(tmp_path, CODE)
