"""
Find a site again
=================

A site of one frame is sought on the surface of another frame, half a nanosecond later.
"""

import matplotlib.pyplot as plt

import sparsurf

molecule = sparsurf.read_molecule(
    "../../data/tdp43/topology.pdb", "../../data/tdp43/trajectory.xtc", stride=500
)
before = sparsurf.describe_sites(molecule.frame(0), name="before")
after = sparsurf.describe_sites(molecule.frame(1), name="after")

hits = sparsurf.find(before, after, residues="222-228", n=1)
print(hits[["residue", "residue_name", "score", "places"]].round(2))

# %%
# The hit lies among the residues of the site. Every place of the surface, and the hit on it:

ax = plt.figure(figsize=(6, 5), layout="constrained").add_subplot(projection="3d")
ax.scatter(*after.points.T, s=1, color="0.75")
own = after.labels["residue"].astype(int).between(222, 228)
ax.scatter(*after.points[own].T, s=4, color="#35b779", label="residues 222 to 228")
ax.scatter(*hits[["x", "y", "z"]].to_numpy().T, s=60, color="#d55e00", label="hit")
ax.legend()
