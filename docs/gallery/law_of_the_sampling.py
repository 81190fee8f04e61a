"""
The law of the sampling
=======================

The paper keeps a dot with a probability that falls with the flatness of its patch and grows with the distance from the centre.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial import cKDTree

import sparsurf

r = np.linspace(0, 1, 101)  # distance from the centre, in units of r_patch
fig, axes = plt.subplots(1, 3, figsize=(10, 3), sharey=True, layout="constrained")
laws = [(0, 2, 0), (0, 6, 0), (1, 2, 2)]
for ax, (beta, gamma, delta) in zip(axes, laws, strict=True):
    for R in (0.2, 0.5, 0.8):
        ax.plot(r, (1 - R) ** beta * r ** (gamma * (1 + R) + delta), label=f"R = {R}")
    ax.set_xlabel("distance from the centre (patch radii)")
    ax.set_title(f"β = {beta}, γ = {gamma}, δ = {delta}")
axes[0].set_ylabel("probability (α = 1)")
axes[0].legend()

# %%
# What it keeps, at the paper's best combination and at a sparse one. Bright places are far from the next kept dot:

ready = sparsurf.prepare(sparsurf.surface("../../data/tdp43/topology.pdb"))
fig = plt.figure(figsize=(9, 4), layout="constrained")
for k, combination in enumerate([(1, 0, 6, 0), (1, 1, 10, 0)]):
    kept = sparsurf.sample(ready, combination=combination)
    distance, _ = cKDTree(ready.points[kept]).query(ready.points)
    ax = ready.surface.plot(
        distance, ax=fig.add_subplot(1, 2, k + 1), name="distance to a kept dot (Å)"
    )
    share = len(kept) / len(ready.points)
    ax.set_title(f"{combination}: {share:.0%} of the dots")
