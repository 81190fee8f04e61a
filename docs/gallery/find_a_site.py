"""
Find a site again
=================

A site of one frame is sought on the surface of another frame, half a nanosecond later.
"""

import matplotlib.pyplot as plt
import numpy as np

import sparsurf

molecule = sparsurf.read_molecule(
    "../../data/tdp43/topology.pdb", "../../data/tdp43/trajectory.xtc", stride=500
)
before = sparsurf.describe_sites(molecule.frame(0), name="before")
after = sparsurf.describe_sites(molecule.frame(1), name="after")

hits = sparsurf.find(before, after, residues="222-228", n=1)
print(hits[["residue", "residue_name", "score", "places"]].round(2))

# %%
# The hit lies among the residues of the site. The surface of the second frame, with the site as it was and the hit:

dots = sparsurf.surface(molecule, frame=1)
residue = dots.to_frame(molecule)["residue"].astype(int)
site = np.where(residue.between(222, 228), residue, np.nan)
distance = np.linalg.norm(dots.points - hits[["x", "y", "z"]].to_numpy()[0], axis=1)

fig = plt.figure(figsize=(9, 4), layout="constrained")
for k, (values, title) in enumerate(
    [(site, "residues of the site"), (distance, "distance to the hit, Å")]
):
    dots.plot(values, ax=fig.add_subplot(1, 2, k + 1)).set_title(title)
