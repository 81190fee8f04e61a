"""
Minimal dots in PyMOL
=====================

A tenth of the dots, in a script that PyMOL opens as spheres on the cartoon of the protein.
"""

import tempfile
from pathlib import Path

import sparsurf

folder = Path(tempfile.mkdtemp())  # or the folder of your choice
few = sparsurf.minimal("../../data/tdp43/topology.pdb", percent=10)
sparsurf.write(few, folder / "minimal.pml")  # minimal.cxc for ChimeraX

# %%
# Then ``pymol minimal.pml``. A study writes such a scene for you (``open.pml``, ``open.cxc``).
#
# The weight of a dot is the number of dots that it stands for:

ax = few.surface.plot(few.weight)
ax.set_title(f"{len(few)} dots and their weights")
