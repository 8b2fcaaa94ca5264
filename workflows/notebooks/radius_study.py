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
# One run evaluates any number of radii. Here are ten, on two grids: a uniform one of T3 elements,
# as in the paper, and one of T6 elements graded towards the tip.

# %%
import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

import cfmpm
from cfmpm.plotting.curves import draw_curve, draw_level
from cfmpm.plotting.style import RC

plt.rcParams.update(RC)

GRIDS = {
    "T3, uniform": {"mesh": {"element": "T3", "size": 2.5, "grading": "uniform"}},
    "T6, graded": {"mesh.size": 6, "mesh.grading": {"tip_size": 0.05, "growth": 0.3}},
}
radii = np.geomspace(1.0, 30.0, 10)
runs = {}
for name, changes in GRIDS.items():
    scene = cfmpm.load_scene(
        "../../configs/paper/shear_plate.yaml", {**changes, "fracture.radii": radii.tolist()}
    )
    runs[name] = cfmpm.run(scene).history.isel(step=0, tip=0)
    print(f"{name}: {int(runs[name]['n_unknowns'])} unknowns")
study = xr.concat(list(runs.values()), xr.Variable("grid", list(runs)), combine_attrs="drop")

# %% [markdown]
# The reference is G of the graded grid at its largest radius, which has four digits.

# %%
exact = float(study["G"].sel(grid="T6, graded"))
_, axes = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
for k, grid in enumerate(GRIDS):
    one = study.sel(grid=grid)
    at = one["domain_radius"]
    draw_curve(axes[0], at, one["J_radius"] / exact, f"J, {grid}", 2 * k)
    draw_curve(axes[0], at, one["cf_norm_radius"] / exact, f"|CF|, {grid}", 2 * k + 1)
    draw_curve(axes[1], at, one["cf_angle_radius"], f"CF, {grid}", 2 * k + 1)
draw_level(axes[0], 1.0, "G")
draw_level(axes[1], float(study["kink_angle"].sel(grid="T6, graded")), "largest hoop stress")
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
fine = study.sel(grid="T6, graded")
print(f"J over the radii: {float(fine['J_spread'] / fine['J']):.1e} of itself")
turned = float(np.abs(fine["cf_angle_radius"] - fine["kink_angle"]).max())
print(f"direction of CF: up to {turned:.2f}° away from that of the largest hoop stress")
