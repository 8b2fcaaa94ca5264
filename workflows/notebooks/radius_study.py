# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # How large a domain?
#
# J and K do not depend on the domain around the tip; what is found of them on a grid does, near
# the tip, where the elements cannot follow the singular field. The norm and the direction of the
# configurational force depend on the domain in mixed mode even without that: the stress-free crack
# faces in the domain carry a part of it, which grows with the root of the radius.
#
# One run evaluates any number of radii. Here are ten, on two grids that a study compares: a uniform
# one of T3 elements, as in the paper, and one of T6 elements graded towards the tip.

# %%
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

from cfmpm.plotting.curves import draw_curve, draw_level
from cfmpm.plotting.style import RC

plt.rcParams.update(RC)

STUDY = f"""
name: radius
base: {Path("../../configs/paper/shear_plate.yaml").resolve()}
replace: {{fracture.radii: {np.geomspace(1.0, 30.0, 10).tolist()}}}
product:
  grid:
    key: mesh
    values:
      T3 uniform: {{element: T3, size: 2.5, grading: uniform}}
      T6 graded: {{element: T6, size: 6, grading: {{tip_size: 0.05, growth: 0.3}}}}
"""

# %% [markdown]
# `cfmpm study` solves the members of a study side by side and gathers them into one dataset, with a
# dimension for each parameter.

# %%
with tempfile.TemporaryDirectory() as folder:
    Path(folder, "radius.yaml").write_text(STUDY)
    command = [sys.executable, "-m", "cfmpm", "study", "radius.yaml"]
    print(subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout)
    study = xr.load_dataset(Path(folder, "results", "radius", "study.nc")).isel(tip=0)

# %% [markdown]
# The reference is G of the graded grid at its largest radius, which has four digits.

# %%
exact = float(study["G"].sel(grid="T6 graded"))
_, axes = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
for k, grid in enumerate(study["grid"].values):
    one = study.sel(grid=grid)
    at = one["domain_radius"]
    draw_curve(axes[0], at, one["J_radius"] / exact, f"J, {grid}", 2 * k)
    draw_curve(axes[0], at, one["cf_norm_radius"] / exact, f"|CF|, {grid}", 2 * k + 1)
    draw_curve(axes[1], at, one["cf_angle_radius"], f"CF, {grid}", 2 * k + 1)
draw_level(axes[0], 1.0, "G")
draw_level(axes[1], float(study["kink_angle"].sel(grid="T6 graded")), "largest hoop stress")
axes[0].set_ylabel("over G [1]")
axes[1].set_ylabel("angle from the crack [°]")
for one in axes:
    one.set_xscale("log")
    one.set_xlabel("radius of the domain [mm]")
    one.legend()

# %% [markdown]
# J of the uniform grid settles once the domain is a few elements wide, at a value that the grid
# decides; J of the graded grid is the same everywhere. The direction of the configurational force
# drifts on both, away from that of the largest hoop stress.

# %%
fine = study.sel(grid="T6 graded")
print(f"J over the radii: {float(fine['J_spread'] / fine['J']):.1e} of itself")
turned = float(np.abs(fine["cf_angle_radius"] - fine["kink_angle"]).max())
print(f"direction of CF: up to {turned:.2f}° away from that of the largest hoop stress")
