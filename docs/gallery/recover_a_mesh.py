"""
A mesh from few dots
====================

Few dots with normals give the whole surface back: as dense dots, or as closed triangles.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
from scipy.spatial import cKDTree

import sparsurf

dots = sparsurf.surface("../../data/tdp43/topology.pdb")
few = dots.take(sparsurf.sample(dots, percent=5))
dense = sparsurf.recover(few)

far = cKDTree(sparsurf.surface("../../data/tdp43/topology.pdb", density=40).points).query(dense.points)[0]
print(
    f"{len(few)} dots give {len(dense)}, {far.mean():.2f} Å from dots of the molecule, which lie 0.15 Å apart"
)

fig = plt.figure(figsize=(9, 4), layout="constrained")
for k, (surface, title) in enumerate([(few, "kept"), (dense, "recovered")]):
    surface.plot(ax=fig.add_subplot(1, 2, k + 1, projection="3d")).set_title(f"{title}: {len(surface)} dots")

# %%
# The command line writes closed triangles:

folder = Path(tempfile.mkdtemp())
sparsurf.write(few, folder / "few.csv")
command = [sys.executable, "-m", "sparsurf", "recover", "few.csv", "--mesh", "-o", "mesh.ply"]
print(subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stderr)
