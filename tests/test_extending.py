"""The walks of docs/extending.md, gone on a copy of the repository."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs/extending.md").read_text("utf-8")

# What is new in use, each against what is known of it.
NEW = """
import math

import cfmpm
from cfmpm.fracture.criteria import kink_factor, local_symmetry_angle, max_energy_angle

plate = {
    "name": "plate",
    "family": {"kind": "single_edge", "width": 50, "height": 100, "crack_length": 10},
    "kinematics": "finite",
    "mesh": {"size": 10},
}


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


def opened(element):
    family = plate["family"] | {"traction": 10}
    scene = {**plate, "family": family, "kinematics": "small", "material": {"E": 1000, "nu": 0.3}}
    return cfmpm.run(cfmpm.scene_from_dict(scene | {"mesh": {"size": 10, "element": element}}))


# Order 4 is right where order 2 is nearly so.
fine, coarse = opened("T15"), opened("T6")
assert len(fine.grid.elements) == len(coarse.grid.elements)
assert len(fine.points) == 12 * len(fine.grid.elements)
assert math.isclose(fine.history.K_I[0, 0], coarse.history.K_I[0, 0], rel_tol=3e-3)
assert math.isclose(fine.history.J[0, 0], fine.history.G[0, 0], rel_tol=2e-4)

# A pressure is the traction along the normal.
def pressed(*loads):
    scene = {**plate, "kinematics": "small", "material": {"E": 1000, "nu": 0.3}, "loads": loads}
    return float(cfmpm.run(cfmpm.scene_from_dict(scene)).history.K_I[0, 0])


pressures = [{"edge": edge, "pressure": -10} for edge in ("top", "bottom")]
tractions = [{"edge": "top", "traction": [0, 10]}, {"edge": "bottom", "traction": [0, -10]}]
assert math.isclose(pressed(*pressures), pressed(*tractions), rel_tol=1e-10)

assert local_symmetry_angle(1.0, 0.0) == 0.0
assert math.isnan(local_symmetry_angle(-1.0, 0.5))
for k_1, k_2 in ((1.0, 0.3), (1.0, -0.3), (0.2, 1.0), (0.0, 1.0)):
    angle = local_symmetry_angle(k_1, k_2)
    assert angle * k_2 < 0.0
    assert math.isclose(angle, max_energy_angle(k_1, k_2), abs_tol=2.0)
    factors = [kink_factor(rule, k_1, k_2) for rule in ("local_symmetry", "max_energy")]
    assert math.isclose(*factors, rel_tol=2e-3)


def grown(direction):
    growth = {"control": "crack", "direction": direction, "increments": 3}
    scene = cfmpm.load_scene("configs/paper/shear_plate_growth.yaml", {"growth": growth})
    return cfmpm.run(scene).history.isel(tip=0, step=-1)


ours, known = grown("local_symmetry"), grown("max_energy")
assert math.hypot(ours.tip_x - known.tip_x, ours.tip_y - known.tip_y) < 0.05 * known.tip_x

# Double-edge crack: Tada, Paris and Irwin, 0.5 %; the grid adds less than 0.1 %.
history = cfmpm.run(cfmpm.load_scene("configs/examples/double_edge.yaml")).history
turn = math.pi * 25 / 100
known = 10 * (1 + 0.122 * math.cos(turn) ** 4) * math.sqrt(100 * math.tan(turn))
assert list(history.tip.values) == ["left_crack", "right_crack"]
for found in history.K_I[-1].values:
    assert math.isclose(found, known, rel_tol=6e-3), (found, known)
"""


def blocks(language: str) -> list[str]:
    """The code blocks of the page, without the indentation of the list they stand in."""
    found = re.findall(rf"^( *)```{language}\n(.*?)^\1```$", PAGE, re.MULTILINE | re.DOTALL)
    return [re.sub(f"^{indent}", "", text, flags=re.MULTILINE) for indent, text in found]


def change(folder: Path, block: str) -> None:
    """Change a file as a block says; each of its parts fits one place."""
    name, *parts = block.split("\n@@\n")
    path = folder / name.removeprefix("--- ")
    text = path.read_text("utf-8")
    for part in parts:
        lines = [line + "\n" for line in part.splitlines()]
        old, new = ("".join(line[1:] for line in lines if line[0] in kind) for kind in (" -", " +"))
        assert text.count(old) == 1, f"{path.name}:\n{old}"
        text = text.replace(old, new)
    path.write_text(text, "utf-8")


@pytest.fixture(scope="module")
def extended(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy in which all walks have been gone."""
    folder = tmp_path_factory.mktemp("extended")
    for name in ("cfmpm", "configs", "docs", "tests"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", folder)
    for block in blocks("python"):
        # A new file, which its first line names.
        name, text = block.split("\n", 1)
        path = folder / name.removeprefix("# ")
        assert not path.exists()
        path.write_text(text, "utf-8")
    for block in blocks("diff"):
        change(folder, block)
    (example,) = blocks("yaml")
    (folder / "configs/examples/double_edge.yaml").write_text(example, "utf-8")
    (commands,) = blocks("bash")
    for command in commands.splitlines():
        call(folder, command.replace("python", sys.executable, 1), shell=True)
    return folder


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


def test_what_is_new_works(extended: Path) -> None:
    call(extended, [sys.executable, "-c", NEW])


def test_the_tests_that_the_page_names_pass(extended: Path) -> None:
    named = [
        "tests/elements",
        "tests/kernels/test_laws.py",
        "tests/kernels/test_finite.py",
        "tests/fracture/test_criteria.py",
        "tests/scene",
        "tests/study/test_shipped_studies.py::test_schema_is_up_to_date",
    ]
    call(extended, [sys.executable, "-m", "pytest", "-q", *named])
