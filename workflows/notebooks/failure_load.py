# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # At which load does it break, and how sure is that?
#
# A plate with an edge crack, whose length, stiffness and toughness are known with some
# uncertainty. A linear scene breaks at the factor sqrt(g_c / G_kink) on its load, with G in the
# direction in which the crack will run. Every history with `g_c` states it as
# `critical_load_factor`; of several tips a study takes the least. Samples are
# drawn by Latin hypercube: one from each of as many intervals of equal probability.

# %%
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from scipy.stats import spearmanr

from cfmpm.plotting.style import BLUE, RC

plt.rcParams.update(RC)

STUDY = f"""
name: strength
base: {Path("../../configs/paper/single_edge_crack.yaml").resolve()}
replace:
  mesh: {{element: T6, size: 80, grading: {{tip_size: 1, growth: 0.4}}}}
latin_hypercube:
  samples: 40
  seed: 1
  parameters:
    a: {{key: family.crack_length, distribution: norm, arguments: {{loc: 100, scale: 5}}}}
    E: {{key: material.E, distribution: norm, arguments: {{loc: 210e3, scale: 6e3}}}}
    g_c: {{key: material.g_c, distribution: lognorm, arguments: {{s: 0.15, scale: 10}}}}
"""
with tempfile.TemporaryDirectory() as folder:
    Path(folder, "strength.yaml").write_text(STUDY)
    command = [sys.executable, "-m", "cfmpm", "study", "strength.yaml"]
    print(subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout)
    study = xr.load_dataset(Path(folder, "results", "strength", "study.nc"))

# %% [markdown]
# The load of the scene is 10 MPa.

# %%
strength = 10.0 * study["fracture_load_factor"]
print(f"{float(strength.mean()):.1f} MPa, standard deviation {float(strength.std(ddof=1)):.1f} MPa")
print(f"one plate in twenty breaks below {float(strength.quantile(0.05)):.1f} MPa")

# %% [markdown]
# What matters most? The toughness, then the length. The load goes with the root of E too, but E is
# known to 3 %: of as many samples as here, correlations within ±0.3 tell nothing.

# %%
_, axes = plt.subplots(1, 4, figsize=(12, 3.2), layout="constrained", sharey=True)
shown = {"a": "crack length [mm]", "E": "Young's modulus [MPa]", "g_c": "g_c [N/mm]"}
for one, (name, label) in zip(axes, shown.items(), strict=False):
    one.plot(study[name], strength, "o", color=BLUE, ms=4)
    one.set_xlabel(label)
    one.set_title(f"rank correlation {spearmanr(study[name], strength).statistic:+.2f}")
axes[0].set_ylabel("load at fracture [MPa]")
axes[3].hist(strength, bins=10, orientation="horizontal", color=BLUE)
axes[3].set_xlabel("number of samples [1]")

# %% [markdown]
# A check that needs no further run: at one length the load is proportional to sqrt(E g_c), so that
# what is left of the scatter after division by it is a function of the length alone.

# %%
left = strength / np.sqrt(study["E"] * study["g_c"])
parabola = np.polynomial.Polynomial.fit(study["a"], left, 2)
residual = left / parabola(study["a"].values) - 1
print(f"off a parabola in the length by at most {float(np.abs(residual).max()):.1e}")
