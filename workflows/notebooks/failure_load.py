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
# uncertainty. A linear scene breaks at the factor sqrt(g_c / G) on its load, which every history
# with `g_c` states as `critical_load_factor`. Samples are drawn by Latin hypercube: one from each
# of as many intervals of equal probability.

# %%
import matplotlib.pyplot as plt
import numpy as np
from scipy.stats import lognorm, norm, qmc, spearmanr

import cfmpm
from cfmpm.plotting.style import BLUE, RC

plt.rcParams.update(RC)

SAMPLES = 40
UNCERTAIN = {
    "family.crack_length": norm(100.0, 5.0),  # mm
    "material.E": norm(210e3, 6e3),  # MPa
    "material.g_c": lognorm(s=0.15, scale=10.0),  # N/mm
}
drawn = qmc.LatinHypercube(len(UNCERTAIN), rng=np.random.default_rng(1)).random(SAMPLES)
values = {
    key: one.ppf(column) for (key, one), column in zip(UNCERTAIN.items(), drawn.T, strict=True)
}

# %% [markdown]
# Each sample is a run of its own; on a graded grid of some thousand unknowns that takes a tenth of
# a second. The load of the scene is 10 MPa.

# %%
strength = np.empty(SAMPLES)
for i in range(SAMPLES):
    sample = {key: float(column[i]) for key, column in values.items()}
    scene = cfmpm.load_scene(
        "../../configs/paper/single_edge_crack.yaml",
        {
            **sample,
            "mesh": {"element": "T6", "size": 80, "grading": {"tip_size": 1, "growth": 0.4}},
            "fracture.radii": 1,
        },
    )
    strength[i] = 10.0 * cfmpm.run(scene).history["critical_load_factor"].item()
print(f"{strength.mean():.1f} MPa ± {strength.std(ddof=1):.1f} MPa (one standard deviation)")
print(f"one plate in twenty breaks below {np.quantile(strength, 0.05):.1f} MPa")

# %% [markdown]
# What matters most? The toughness, then the length. The load goes with the root of E too, but E is
# known to 3 %: of as many samples as here, correlations within ±0.3 tell nothing.

# %%
_, axes = plt.subplots(1, 4, figsize=(12, 3.2), layout="constrained", sharey=True)
shown = {"crack length [mm]": 1.0, "Young's modulus [GPa]": 1e-3, "g_c [N/mm]": 1.0}
for one, column, (label, scale) in zip(axes, values.values(), shown.items(), strict=False):
    one.plot(scale * column, strength, "o", color=BLUE, ms=4)
    one.set_xlabel(label)
    one.set_title(f"rank correlation {spearmanr(column, strength).statistic:+.2f}")
axes[0].set_ylabel("load at fracture [MPa]")
axes[3].hist(strength, bins=10, orientation="horizontal", color=BLUE)
axes[3].set_xlabel("number of samples [1]")

# %% [markdown]
# A check that needs no further run: at one length the load is proportional to sqrt(E g_c), so that
# what is left of the scatter after division by it is a function of the length alone.

# %%
left = strength / np.sqrt(values["material.E"] * values["material.g_c"])
order = np.argsort(values["family.crack_length"])
smooth = np.polynomial.Polynomial.fit(values["family.crack_length"][order], left[order], 2)
residual = left[order] / smooth(values["family.crack_length"][order]) - 1
print(f"off a parabola in the length by at most {np.abs(residual).max():.1e}")
