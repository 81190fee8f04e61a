"""
Minimal dots in PyMOL
=====================

A tenth of the dots, written as a structure of its own that PyMOL shows as spheres on the protein.
"""

import tempfile
from pathlib import Path

import sparsurf

folder = Path(tempfile.mkdtemp())  # or the folder of your choice
few = sparsurf.minimal("../../data/tdp43/topology.pdb", percent=10)
sparsurf.write(few, folder / "minimal.csv")

line = "HETATM{:5d}  X   DOT X{:4d}    {:8.3f}{:8.3f}{:8.3f}  1.00{:6.2f}           X\n"
rows = few.table.head(9999)  # as many residues as a PDB file numbers
with open(folder / "minimal.pdb", "w") as file:
    for k, row in enumerate(rows.itertuples(), start=1):
        file.write(line.format(k, k, row.x, row.y, row.z, row.weight))

# %%
# Then, in PyMOL::
#
#     load topology.pdb
#     load minimal.pdb
#     show cartoon, topology
#     show spheres, minimal
#     set sphere_scale, 0.2, minimal
#     spectrum b, blue_white_red, minimal
#
# The colour is the number of dots that each stands for. A study writes such a scene for you (``open.pml``, ``open.cxc``).

ax = few.surface.plot(few.table["weight"])
ax.set_title(f"{len(few.dots)} dots and their weights")
