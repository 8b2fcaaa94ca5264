# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # Crack paths
#
# Four scenes whose cracks run: under shear, past two holes, into one of three holes, and from both
# ends of a slanted crack. The crosses are where the tips ended.

# %%
import numpy as np

import cfmpm

SCENES = {
    "paper/shear_plate_growth": {"mesh.size": 4},
    "paper/plate_two_holes": {},
    "paper/beam_three_holes": {},
    "examples/centre_crack": {
        "family.crack_angle": 45,
        "material.g_c": 1.0,
        "growth": {"control": "crack"},
    },
}
histories = {}
for name, changes in SCENES.items():
    histories[name] = cfmpm.run(cfmpm.load_scene(f"../../configs/{name}.yaml", changes)).history
    print(f"{name}: {histories[name].attrs['ending']}")

# %% [markdown]
# The path of the left crack between the two holes, by max hoop stress, as others have computed it.

# %%
others = np.loadtxt("../reference/holes_hoop.csv", delimiter=",", comments="#", skiprows=1)

# %%
for name, history in histories.items():
    reference = {"others, left crack": others} if name.endswith("two_holes") else None
    history.cfmpm.plot_path(reference=reference).set_title(history.attrs["title"])

# %% [markdown]
# `path()` gives the places of each tip as an array. Under shear the crack starts at the angle of
# the configurational force and turns level as it nears the edge.

# %%
(path,) = histories["paper/shear_plate_growth"].cfmpm.path().values()
angles = np.degrees(np.arctan2(*np.diff(path, axis=0).T[::-1]))
print("directions of its first and last whole segment:", np.round(angles[[0, -2]], 1))

# %% [markdown]
# The slanted crack runs at the load that just drives it (`control: crack`). Then all work of the
# loads is found again, as strain energy or as new crack; what is missing is the error of the steps.
# The last segment before an edge breaks a whole ligament, far too much for the trapezoidal rule by
# which work is summed: so here until the first end arrives.

# %%
slanted = histories["examples/centre_crack"]
balance = slanted.cfmpm.energy_balance().where(slanted["J"].notnull().all("tip"))
share = float(np.abs(balance["missing"]).max() / balance["external_work"].max())
print(f"missing: at most {share:.1e} of the work")
