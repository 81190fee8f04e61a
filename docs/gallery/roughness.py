"""
Roughness on a structure
========================

R is near 1 where the surface is flat and near 0 where it is rough. The paper's sampling goes by it.
"""

import matplotlib.pyplot as plt

import sparsurf

molecule = sparsurf.read_molecule("../../data/tdp43/topology.pdb")
dots = sparsurf.surface(molecule)
R = sparsurf.roughness(dots)

dots.plot(R, name="roughness").set_title("roughness R of each dot")

# %%
# The mean over the dots of each residue tells which parts of the protein are rough. A buried residue has no point:

residues = sparsurf.residues(molecule, dots, roughness_values=R)
fig, ax = plt.subplots(figsize=(8, 3), layout="constrained")
ax.plot(
    residues["residue"].astype(int), residues["mean_roughness"], ".-", color="#31688e"
)
ax.set(xlabel="residue", ylabel="mean R")
