"""
Minimal dots in PyMOL
=====================

A tenth of the dots, in a script that PyMOL opens as spheres on the cartoon of the protein.
"""

import tempfile
from pathlib import Path

from scipy.spatial import cKDTree

import sparsurf

folder = Path(tempfile.mkdtemp())  # or the folder of your choice
dots = sparsurf.surface("../../data/tdp43/topology.pdb")
few = sparsurf.minimal(dots, percent=10)
sparsurf.write(few, folder / "minimal.pml")  # minimal.cxc for ChimeraX

# %%
# Then ``pymol minimal.pml``. A study writes such a scene for you (``open.pml``, ``open.cxc``).
#
# The weight of a dot is the number of dots that it stands for. Each place has the weight of the nearest kept
# dot:

_, nearest = cKDTree(few.points).query(dots.points)
ax = dots.plot(few.weight[nearest], name="weight")
ax.set_title(f"{len(few)} dots stand for {len(dots)}: their weights")
