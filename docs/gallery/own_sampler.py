"""
Your own sampler
================

A sampler is one function: which n dots of a surface are kept. Here, those that look most away from the middle.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial import cKDTree

import sparsurf
from sparsurf.sampling.samplers import sampler


@sampler("most outward dots", nested=True)
def outward(prepared, n, rng):
    """The n dots whose normals point away from the middle."""
    away = prepared.points - prepared.points.mean(axis=0)
    away /= np.linalg.norm(away, axis=1)[:, None]
    return np.argsort(-(away * prepared.normals).sum(axis=1), kind="stable")[:n]


ready = sparsurf.prepare(sparsurf.surface("../../data/tdp43/topology.pdb"))
names = ["outward", "farthest"]
kept = {name: sparsurf.sample(ready, percent=10, sampler=name) for name in names}
print(sparsurf.compare(ready, kept)[["n_S", "Z", "Z_uniform", "d"]].round(2))

# %%
# A negative d: these dots do worse than a uniform subset. Farthest-point samples do better: no place is far from the next one.

fig = plt.figure(figsize=(9, 4), layout="constrained")
for k, (name, chosen) in enumerate(kept.items()):
    distance, _ = cKDTree(ready.points[chosen]).query(ready.points)
    ax = ready.surface.plot(distance, ax=fig.add_subplot(1, 2, k + 1))
    ax.set_title(f"{name}: distance to the next kept dot, Å")

# %%
# To use it in studies, put the function into ``src/sparsurf/sampling/samplers.py``: see :doc:`/extending`.
