"""Criteria that another package adds: local symmetry, and a driving force of mode I."""

from __future__ import annotations

from pathlib import Path

import pytest
from extending import new_files, section
from foreign_package import install, run

ENTRIES = """
from cfmpm.registry.criteria import Criterion

LOCAL_SYMMETRY = Criterion(
    "foreign.local_symmetry:LocalSymmetry", "in which mode II vanishes", needs_k=True
)
MODE_I = Criterion("foreign:mode_one", "G of mode I", needs_k=True)


def mode_one(values):
    k_1, k_2 = values["K_I"], values["K_II"]
    return values["G"] * k_1**2 / (k_1**2 + k_2**2)
"""
POINTS = """
[cfmpm.directions]
local_symmetry = foreign:LOCAL_SYMMETRY
[cfmpm.driving_forces]
mode_one = foreign:MODE_I
"""
CODE = """
import math

import numpy as np

import cfmpm
from cfmpm import build
from cfmpm.fracture.criteria.protocols import direction_by
from cfmpm.output import summary
from foreign.local_symmetry import LocalSymmetry

ours, known = direction_by("local_symmetry"), direction_by("max_energy")
assert type(ours) is LocalSymmetry
assert ours.angle({"K_I": 1.0, "K_II": 0.0}) == 0.0
assert np.isnan(ours.heading({"K_I": -1.0, "K_II": 2.0}, np.array([1.0, 0.0]))).all()
for k_1, k_2 in ((1.0, 0.3), (1.0, -0.3), (0.2, 1.0), (0.0, 1.0)):
    values = {"K_I": k_1, "K_II": k_2}
    assert ours.angle(values) * k_2 < 0.0
    assert math.isclose(ours.angle(values), known.angle(values), abs_tol=2.0)
    assert math.isclose(ours.kink_factor(values), known.kink_factor(values), rel_tol=2e-3)

PLATE = "configs/paper/shear_plate_growth.yaml"


def scene(**growth):
    return cfmpm.load_scene(PLATE, {"growth": {"control": "crack", "increments": 3} | growth})


def grown(**growth):
    return cfmpm.run(scene(**growth)).history.isel(tip=0)


here, there = (grown(direction=word).isel(step=-1) for word in ("local_symmetry", "max_energy"))
away = math.hypot(here.tip_x - there.tip_x, here.tip_y - there.tip_y)
assert 0.0 < away < 0.01 * there.crack_length, away

first = grown(direction="cf", criterion="mode_one").isel(step=0)
part = float(first.K_I**2 / (first.K_I**2 + first.K_II**2))
assert part < 0.999
assert math.isclose(first.G * part, scene().material.g_c, rel_tol=1e-12)

full = cfmpm.scene.expand(scene(direction="local_symmetry", criterion="mode_one"))
said = " ".join(summary.of_check(full, build.build(full), "superlu", [], "here").split())
assert "at the load at which G of mode I of the first tip is g_c; in the direction" in said, said
assert "in the direction in which mode II vanishes;" in said, said

for key, word in (("direction", "local_symmetry"), ("criterion", "mode_one")):
    growth = {"direction": "cf", "criterion": "cf_norm", key: word}
    try:
        cfmpm.load_scene(PLATE, {"kinematics": "finite", "growth": growth})
    except cfmpm.SceneError as error:
        assert f"{word} needs K_I and K_II" in str(error), error
    else:
        raise AssertionError(word)
"""


@pytest.mark.slow
def test_criteria(tmp_path: Path) -> None:
    (text,) = new_files(section("A criterion for the direction of growth")).values()
    files = {"foreign/__init__.py": ENTRIES, "foreign/local_symmetry.py": text}
    install(tmp_path, files, POINTS)
    run(tmp_path, CODE)
