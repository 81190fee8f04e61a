"""
Roughness over a trajectory
===========================

One surface for each frame, and the mean roughness of each residue in it.
"""

import matplotlib.pyplot as plt
import numpy as np

import sparsurf

molecule = sparsurf.read_molecule(
    "../../data/tdp43/topology.pdb", "../../data/tdp43/trajectory.xtc", stride=50
)
rows = []
for frame in range(molecule.n_frames):
    dots = sparsurf.surface(molecule, frame=frame)
    rows.append(sparsurf.residues(molecule, dots)["mean_roughness"])

fig, ax = plt.subplots(figsize=(8, 4), layout="constrained")
image = ax.imshow(
    np.array(rows).T, aspect="auto", origin="lower", extent=(0, 1, 208.5, 269.5),
    vmin=0.2, vmax=0.9,  # as in all pages and figures
)  # fmt: skip
ax.set(xlabel="time (ns)", ylabel="residue")
fig.colorbar(image, label="mean R", extend="both")
