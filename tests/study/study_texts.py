"""Small studies for the tests."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

SCENE = """\
name: small
family: {kind: single_edge, width: 10, height: 20, crack_length: 4, traction: 10}
material: {E: 210e3, nu: 0.3, g_c: 1.0}
mesh: {element: T3, size: 2, grading: uniform}
fracture: {radii: 1}
"""
STUDY = """\
name: lengths
base: small.yaml
product:
  length: {key: family.crack_length, values: [2, 4]}
  E: {key: material.E, linspace: [100e3, 200e3, 2]}
"""
# Loads out of balance on a body that nothing holds: that is found on the grid alone.
FAILING = """\
name: failing
base:
  name: pulled
  geometry:
    outline: [{at: [0, 0], edge: bottom}, [10, 0], {at: [10, 20], edge: top}, [0, 20]]
    cracks: [{points: [[0, 10], [4, 10]]}]
  material: {E: 210e3, nu: 0.3}
  loads:
    - {edge: top, traction: [0, 5]}
    - {edge: bottom, traction: [0, -5]}
  mesh: {element: T3, size: 2, grading: uniform}
product:
  pull: {key: "loads[0].traction[1]", values: [5, 6]}
  element: {key: mesh.element, values: [T3, T6]}
"""
GROWING = """\
name: growing
base:
  name: grown
  family: {kind: single_edge, width: 10, height: 20, crack_length: 4, traction: 10}
  material: {E: 210e3, nu: 0.3, g_c: 1.0}
  mesh: {element: T3, size: 2, grading: uniform}
  growth: {control: crack}
product:
  most: {key: growth.increments, values: [1, 3]}
"""
UNCRACKED = """\
name: whole
base:
  name: block
  geometry:
    outline: [{at: [0, 0], edge: bottom}, [10, 0], {at: [10, 20], edge: top}, [0, 20]]
  material: {E: 210e3, nu: 0.3, g_c: 1.0}
  load_steps: 1
  loads: [{edge: top, traction: [0, 5]}, {edge: bottom, displacement: {y: 0}}]
  mesh: {element: T3, size: 2, grading: uniform}
product:
  nu: {key: material.nu, values: [0.2, 0.3]}
"""
# What differs between two runs of one study.
VOLATILE = {"date_created", "history"}


def write_study(folder: Path, text: str = STUDY, name: str = "study.yaml") -> Path:
    """Write a study file beside its base scene."""
    (folder / "small.yaml").write_text(SCENE)
    path = folder / name
    path.write_text(text)
    return path


def without_times(path: Path | str) -> xr.Dataset:
    """A dataset of a study without variables that differ between two runs."""
    dataset = xr.load_dataset(path).drop_vars(["run_time", "cpu_time"])
    for name in VOLATILE:
        del dataset.attrs[name]
    return dataset
