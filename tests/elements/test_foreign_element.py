"""An element of order 3 that another package adds: one file and one entry point."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

SCENES = """
import numpy as np

import cfmpm
from cfmpm.output.fields import build_fields

plate = {
    "name": "plate",
    "family": {
        "kind": "single_edge", "width": 50, "height": 100, "crack_length": 20, "traction": 10
    },
    "material": {"E": 210e3, "nu": 0.3, "g_c": 0.1},
}


def solve(element, size=10, **more):
    scene = cfmpm.scene_from_dict(plate | {"mesh": {"element": element, "size": size}} | more)
    return cfmpm.run(scene)


# Against a grid with tip elements of 1e-5 of the crack; K_I is that of Tada, Paris and Irwin
# for a long plate to 0.5 %.
finest = {"size": 2, "grading": {"tip_size": 2e-4, "growth": 0.1}}
exact = cfmpm.run(cfmpm.scene_from_dict(plate | {"mesh": finest})).history.isel(step=0, tip=0)
handbook = 10 * np.sqrt(20 * np.pi) * np.polyval([30.39, -21.72, 10.55, -0.231, 1.122], 0.4)
assert abs(exact.K_I / handbook - 1) < 5e-3
errors = {}
for word in ("T6", "CUBIC"):
    found = solve(word).history.isel(step=0, tip=0)
    for name in ("K_I", "G", "J", "T_stress"):
        errors[word, name] = abs(float(found[name] / exact[name]) - 1)
for name in ("K_I", "G", "J", "T_stress"):
    assert errors["CUBIC", name] < 0.25 * errors["T6", name], errors
assert errors["CUBIC", "K_I"] < 2.5e-4, errors

result = solve("CUBIC", size=5)
fields = build_fields(result)
assert fields.sizes["face"] == 9 * len(result.grid.elements)
assert fields.sizes["point"] == 6 * len(result.grid.elements)
assert fields.attrs["title"]

# A closed crack without friction: K_I = 0, K_II = sigma sin(beta) cos(beta) sqrt(pi a).
inclined = {
    "kind": "centre_crack", "width": 200, "height": 200, "crack_length": 10, "crack_angle": 45,
    "traction": -10,
}
grading = {"tip_size": 0.2, "growth": 0.25}
mesh = {"element": "CUBIC", "size": 25, "grading": grading}
closed = cfmpm.run(cfmpm.scene_from_dict(plate | {"family": inclined, "mesh": mesh})).history
k_2 = 5 * np.sqrt(5 * np.pi)
assert closed.contact_pairs[0] > 20
np.testing.assert_allclose(abs(closed.K_II[0]), k_2, rtol=5e-3)
np.testing.assert_allclose(closed.K_I[0], 0, atol=5e-3 * k_2)

# Finite deformation, and a grid that is reset.
small = solve("CUBIC", kinematics="small").history.J[0, 0]
finite = solve("CUBIC", kinematics="finite").history.J[0, 0]
assert abs(float(finite / small) - 1) < 5e-3
solve("CUBIC", kinematics="finite", formulation="updated", load_steps=2)

# Growth, integrated over the parts of its domains: the path of the element below it.
growth = {"growth": {"control": "crack", "increments": 8}}
shear = [
    {"edge": "bottom", "displacement": {"x": 0, "y": 0}},
    {"edge": "top", "displacement": {"x": 0.02, "y": 0.02}},
]
def tip(element):
    plain = {name: value for name, value in plate["family"].items() if name != "traction"}
    history = solve(element, 4, loads=shear, family=plain, **growth).history
    assert history.sizes["step"] > 6, history.ending
    return np.column_stack([history.tip_x[:6, 0], history.tip_y[:6, 0]])
ours, known = tip("CUBIC"), tip("T6")
run = np.hypot(*(known[-1] - known[0]))
assert np.hypot(*(ours[-1] - known[-1])) < 0.03 * run, (ours, known)
assert abs(known[-1, 1] - known[0, 1]) > 0.1 * run
"""

REFUSALS = [
    (
        {"mesh": {"element": "CUBIC_STATIONARY"}, "growth": {}},
        "mesh.element: CUBIC_STATIONARY does not go with growth.transfer: domains: it does not "
        "define the domains of its material points, as T3, T6, T10, T15, CUBIC do; use one of "
        "these, or growth.transfer: paper",
    ),
    (
        {
            "mesh": {"element": "CUBIC"},
            "formulation": "updated",
            "updated": {"grid": "following"},
        },
        "updated.grid: following needs mesh.element: T3, whose sides stay straight; CUBIC goes "
        "with grid: fixed and integration: points",
    ),
    ({"mesh": {"element": "Q4"}}, 'mesh.element: unknown value "Q4"; known: T3, T6, T10, T15'),
]


@pytest.fixture
def environment(tmp_path: Path) -> dict[str, str]:
    """Environment in which a package with the element is installed."""
    shutil.copy(Path(__file__).with_name("cubic_element.py"), tmp_path)
    facts = tmp_path / "cubic_element-1.0.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: cubic-element\nVersion: 1.0\n")
    (facts / "entry_points.txt").write_text(
        "[cfmpm.elements]\nCUBIC = cubic_element:ENTRY\n"
        "CUBIC_STATIONARY = cubic_element:STATIONARY_ENTRY\n"
    )
    path = os.pathsep.join(filter(None, [str(tmp_path), os.environ.get("PYTHONPATH")]))
    return {**os.environ, "PYTHONPATH": path}


def call(environment: dict[str, str], *arguments: str) -> str:
    done = subprocess.run(
        [sys.executable, *arguments], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_scenes(environment: dict[str, str]) -> None:
    call(environment, "-c", SCENES)


def test_refusals(environment: dict[str, str]) -> None:
    """Messages name file, line, key and what is allowed."""
    code = f"""
from pathlib import Path
from ruamel.yaml import YAML
import cfmpm
base = {{
    "name": "plate",
    "family": {{
        "kind": "single_edge", "width": 5, "height": 10, "crack_length": 1, "traction": 1
    }},
    "material": {{"E": 1000, "nu": 0.3, "g_c": 1}},
}}
scene = Path({environment["PYTHONPATH"].split(os.pathsep)[0]!r}) / "scene.yaml"
for change, expected in {REFUSALS!r}:
    with scene.open("w") as file:
        YAML().dump(base | change, file)
    try:
        cfmpm.load_scene(scene)
    except cfmpm.SceneError as error:
        assert expected in str(error), error
        assert f"{{scene}}:" in str(error), error
    else:
        raise AssertionError(expected)
"""
    call(environment, "-c", code)


def test_schema_knows_it(environment: dict[str, str]) -> None:
    schema = call(environment, "-m", "cfmpm.scene.schema")
    assert '"CUBIC_STATIONARY"' in schema
    assert "T3: 1 point, T6: 3 points, T10: 6 points, T15: 12 points, " in schema
    assert ", CUBIC: 6 points, " in schema
