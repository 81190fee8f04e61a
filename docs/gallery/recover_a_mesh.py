"""
A mesh from few dots
====================

Few dots with normals give the whole surface back: as dense dots, or as closed triangles.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
from scipy.spatial import cKDTree

import sparsurf

structure = "../../data/tdp43/topology.pdb"
dots = sparsurf.surface(structure)
few = dots.take(sparsurf.sample(dots, percent=5))
dense = sparsurf.recover(few)
print(len(few), "dots give", len(dense))

# 40 dots per Å^2 lie 0.15 Å apart: how far are the recovered dots from them?
truth = cKDTree(sparsurf.surface(structure, density=40).points)
print(f"{truth.query(dense.points)[0].mean():.2f} Å on average")

fig = plt.figure(figsize=(9, 4), layout="constrained")
for k, (surface, title) in enumerate([(few, "kept"), (dense, "recovered")]):
    ax = surface.plot(ax=fig.add_subplot(1, 2, k + 1))
    ax.set_title(f"{title}: {len(surface)} dots")

# %%
# The same surface as closed triangles, for programs that print, simulate or measure volumes:

mesh = sparsurf.mesh(few)
print(f"{len(mesh.triangles)} triangles around {mesh.volume:.0f} Å^3")
sparsurf.write(mesh, Path(tempfile.mkdtemp(), "mesh.ply"))
