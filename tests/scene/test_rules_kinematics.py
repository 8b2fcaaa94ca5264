"""Keys that do not go with finite deformation and its materials."""

from __future__ import annotations

from pathlib import Path

import pytest
from scene_texts import refused

FINITE = "kinematics: finite\n"
J2 = "nu: 0.3, law: j2, yield_stress: 10"
REFUSED = [
    (FINITE + "plane: stress\n", "kinematics", "finite needs plane: strain"),
    (FINITE + "growth: {control: crack, direction: cf}\n", "growth.control", "crack needs"),
    (FINITE + "growth: {}\n", "growth.direction", "max_hoop needs K_I and K_II"),
    ("growth: {control: crack}\nload_steps: 2\n", "load_steps", "does not go with"),
    ("load_steps: 0\n", "load_steps", "at least 1"),
    ("load_steps: []\n", "load_steps", "at least 1"),
    ("load_steps: [0, 1]\n", "load_steps", "the first from zero"),
    ("load_steps: [0.5, 0.5]\n", "load_steps", "must differ from the one before"),
    ("kinematics: small\nload_steps: [-1]\n", "load_steps", "a negative load factor"),
    ("plane: stress\nload_steps: [1, -1]\n", "load_steps", "a negative load factor"),
    ("kinematics: large\n", "kinematics", "finite"),
]
MATERIALS = [
    ("nu: 0.3, law: j2", "", "material.yield_stress", "is missing: the law j2 needs it"),
    ("nu: 0.3, yield_stress: 9", "", "material.yield_stress", "the law hencky is elastic"),
    ("nu: 0.3, hardening: 9", "", "material.hardening", "the law hencky is elastic"),
    ("nu: 0.3, law: steel", "", "material.law", "neo_hookean"),
    (J2, "", "material.law", "j2 needs kinematics: finite"),
    (J2, FINITE + "growth: {direction: cf}\n", "material.law", "does not go with growth"),
]


def text(rest: str, material: str = "nu: 0.3") -> str:
    return (
        f"name: specimen\nmaterial: {{E: 1000, {material}, g_c: 1}}\n"
        "family: {kind: single_edge, width: 50, height: 90, crack_length: 9, traction: 1}\n" + rest
    )


@pytest.mark.parametrize(("rest", "key", "fragment"), REFUSED)
def test_refused(tmp_path: Path, rest: str, key: str, fragment: str) -> None:
    problems = refused(text(rest), tmp_path)
    assert key in [problem.key for problem in problems]
    assert any(fragment in problem.reason for problem in problems)


@pytest.mark.parametrize(("material", "rest", "key", "fragment"), MATERIALS)
def test_material_refused(
    tmp_path: Path, material: str, rest: str, key: str, fragment: str
) -> None:
    (problem,) = refused(text(rest, material), tmp_path)
    assert problem.key == key
    assert fragment in problem.reason
