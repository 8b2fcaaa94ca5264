"""The examples of docs/extending.md, each applied to a copy of the repository."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from extending import PAGE, ROOT, blocks, new_files, section

pytestmark = pytest.mark.slow

# What is new in use, each against what is known of it.
PLATE = """
import math

import cfmpm

plate = {
    "name": "plate",
    "family": {"kind": "single_edge", "width": 50, "height": 100, "crack_length": 10},
    "kinematics": "finite",
    "mesh": {"size": 10},
}
"""
LAW = """
def pulled(law, height):
    loads = [
        {"edge": "bottom", "displacement": {"y": 0}},
        {"edge": "top", "displacement": {"y": height}},
    ]
    material = {"E": 1000, "nu": 0.3, "law": law}
    scene = cfmpm.scene_from_dict(plate | {"loads": loads, "material": material})
    return float(cfmpm.run(scene).history.J[-1, 0])


# The laws are one at small strain, and (J - 1)^2 is stiffer than ln(J)^2 where J grows.
assert math.isclose(pulled("simo_pister", 0.01), pulled("neo_hookean", 0.01), rel_tol=1e-4)
assert pulled("simo_pister", 20) > 1.002 * pulled("neo_hookean", 20)
"""
ELEMENT = """
def opened(element):
    family = plate["family"] | {"traction": 10}
    scene = {**plate, "family": family, "kinematics": "small", "material": {"E": 1000, "nu": 0.3}}
    return cfmpm.run(cfmpm.scene_from_dict(scene | {"mesh": {"size": 10, "element": element}}))


# Order 5 is right where order 2 is nearly so.
fine, coarse = opened("T21"), opened("T6")
assert len(fine.grid.elements) == len(coarse.grid.elements)
assert len(fine.points) == 16 * len(fine.grid.elements)
assert math.isclose(fine.history.K_I[0, 0], coarse.history.K_I[0, 0], rel_tol=3e-3)
assert math.isclose(fine.history.J[0, 0], fine.history.G[0, 0], rel_tol=2e-4)
"""
LOAD = """
# A pressure is the traction along the normal.
def pressed(*loads):
    scene = {**plate, "kinematics": "small", "material": {"E": 1000, "nu": 0.3}, "loads": loads}
    return float(cfmpm.run(cfmpm.scene_from_dict(scene)).history.K_I[0, 0])


pressures = [{"edge": edge, "pressure": -10} for edge in ("top", "bottom")]
tractions = [{"edge": "top", "traction": [0, 10]}, {"edge": "bottom", "traction": [0, -10]}]
assert math.isclose(pressed(*pressures), pressed(*tractions), rel_tol=1e-10)
"""
DIRECTION = """
def grown(direction):
    growth = {"control": "crack", "direction": direction, "increments": 3}
    scene = cfmpm.load_scene("configs/paper/shear_plate_growth.yaml", {"growth": growth})
    return cfmpm.run(scene).history.isel(tip=0, step=-1)


ours, known = grown("local_symmetry"), grown("max_energy")
assert 0.0 < math.hypot(ours.tip_x - known.tip_x, ours.tip_y - known.tip_y) < 0.01 * known.tip_x
"""
FAMILY = """
# Double-edge crack: Tada, Paris and Irwin, 0.5 %; the grid adds less than 0.1 %.
history = cfmpm.run(cfmpm.load_scene("configs/examples/double_edge.yaml")).history
turn = math.pi * 25 / 100
known = 10 * (1 + 0.122 * math.cos(turn) ** 4) * math.sqrt(100 * math.tan(turn))
assert list(history.tip.values) == ["left_crack", "right_crack"]
for found in history.K_I[-1].values:
    assert math.isclose(found, known, rel_tol=6e-3), (found, known)
"""
WALKS = {
    "A material": (LAW, ("tests/kernels/test_laws.py", "tests/kernels/test_finite.py")),
    "An element": (ELEMENT, ("tests/elements/test_rates.py", "tests/elements/test_record.py")),
    "A kind of load": (LOAD, ()),
    "A criterion for the direction of growth": (DIRECTION, ("tests/fracture/test_criteria.py",)),
    "A family of geometries": (FAMILY, ("tests/scene/test_families.py",)),
}
UP_TO_DATE = (
    "tests/scene/test_configs.py",
    "tests/scene/test_reference.py",
    "tests/study/test_shipped_studies.py::test_schema_is_up_to_date",
)


def change(folder: Path, block: str) -> None:
    """Apply a diff block to a file; each part must match exactly once."""
    name, *parts = block.split("\n@@\n")
    path = folder / name.removeprefix("--- ")
    text = path.read_text("utf-8")
    for part in parts:
        lines = [line + "\n" for line in part.splitlines()]
        old, new = ("".join(line[1:] for line in lines if line[0] in kind) for kind in (" -", " +"))
        assert text.count(old) == 1, f"{path.name}:\n{old}"
        text = text.replace(old, new)
    path.write_text(text, "utf-8")


def call(folder: Path, command: str | list[str], *, shell: bool = False) -> None:
    environment = {"PYTHONPATH": str(folder), "NUMBA_CACHE_DIR": str(folder / "kernels")}
    done = subprocess.run(
        command,
        shell=shell,
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("title", WALKS)
def test_walk(title: str, tmp_path: Path) -> None:
    """The addition works, and the tests named on the page pass."""
    for name in ("cfmpm", "configs", "docs", "tests"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    text = section(title)
    for path, content in new_files(text).items():
        assert not (tmp_path / path).exists()
        (tmp_path / path).write_text(content, "utf-8")
    for block in blocks(text, "diff"):
        change(tmp_path, block)
    (commands,) = blocks(PAGE, "bash")
    for command in commands.splitlines():
        call(tmp_path, command.replace("python", sys.executable, 1), shell=True)
    code, tests = WALKS[title]
    call(tmp_path, [sys.executable, "-c", PLATE + code])
    call(tmp_path, [sys.executable, "-m", "pytest", "-q", *tests, *UP_TO_DATE])
