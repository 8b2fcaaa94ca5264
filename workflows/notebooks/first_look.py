# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # A first look at a result
#
# An edge crack in a plate that is clamped at the bottom and sheared at the top, in mixed mode. The
# scene is the file `shear_plate.yaml`.

# %%
import matplotlib.pyplot as plt
import numpy as np

import cfmpm
from cfmpm.output.fields import build_fields
from cfmpm.plotting import draw_deformed, draw_tip_forces
from cfmpm.plotting.style import RC

plt.rcParams.update(RC)

scene = cfmpm.load_scene("../../configs/paper/shear_plate.yaml")
result = cfmpm.run(scene)
history = result.history

# %% [markdown]
# The history is an xarray dataset with dimensions for steps, crack tips and domain radii. Every
# variable has a unit and a description. The history of a stationary crack has one step.
#
# In brackets: the range over the domain radii, which is the uncertainty of the *evaluation*. It
# does not contain the discretisation error.

# %%
tip = history.isel(step=0, tip=0)
for name in ("G", "J", "cf_norm", "cf_angle", "K_I", "K_II", "T_stress"):
    spread = float(tip[f"{name}_spread"])
    print(f"{name:9}{float(tip[name]):10.4f} ({spread:.2g}) {tip[name].attrs['units']}")

# %% [markdown]
# Published for a plate of 7 by 16 inches under 1 psi: K_I = 34.0 and K_II = 4.55 psi in^0.5. This
# one is 70 by 160 mm under 1 MPa; K goes with the stress and the root of the length.

# %%
published = np.sqrt(10.0) * np.array([34.0, 4.55])
found = np.array([float(tip["K_I"]), float(tip["K_II"])])
print("found over published:", np.round(found / published, 4))

# %% [markdown]
# The configurational force points out of the crack, at an angle: its component along the crack is
# J, its norm is larger, by the cosine of that angle.

# %%
norm, j = float(tip["cf_norm"]), float(tip["J"])
along = norm * np.cos(np.radians(float(tip["cf_angle"])))
print(f"|CF| {norm:.5f}, along the crack {along:.5f}, J {j:.5f} N/mm")

# %% [markdown]
# Stress on the deformed body, whose title says how much the displacement is magnified; and the
# configurational forces of the nodes around the tip with their sum.

# %%
_, axes = plt.subplots(1, 2, figsize=(10, 5.5), layout="constrained")
draw_deformed(axes[0], build_fields(result))
nodal, grid = result.configurational_force, result.grid
draw_tip_forces(axes[1], grid, nodal, grid.tips[0], float(tip["domain_radius"].max()))

# %% [markdown]
# `cfmpm run` keeps the history in `results/<name>/history.nc`; `cfmpm.open_history` reads it back.
