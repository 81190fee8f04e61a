"""
The surface of a protein
========================

A structure becomes dots with outward normals. Each dot is of one kind: on an atom (contact), between two atoms (saddle) or
among three (concave).
"""

import sparsurf

dots = sparsurf.surface("../../data/tdp43/topology.pdb")
print(len(dots), "dots,", round(dots.area.sum()), "Å^2")

ax = dots.plot()
ax.set_title("contact, saddle and concave dots")

# %%
# The same as a table, with the residue of each dot:

molecule = sparsurf.read_molecule("../../data/tdp43/topology.pdb")
print(dots.to_frame(molecule).head())
