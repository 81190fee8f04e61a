"""Frames of a trajectory, models of a file or a single structure become the conformations of a study."""

from pathlib import Path

import pandas as pd

from sparsurf.molecules.conformations import choose_frames
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.streams import stream
from sparsurf.workflow.jobs import run


def main(inputs, outputs, molecule_options, settings, name):
    """Write frames.csv, what it was chosen from, and one PDB file per conformation."""
    asked = settings["frames"]
    molecule = read_molecule(
        inputs["structure"], inputs.get("trajectory"), stride=asked["stride"], **molecule_options
    )
    clusters, frames = asked["clusters"], None if asked["use"] == "clusters" else asked["use"]
    atoms = None if asked["pca_atoms"] == "auto" else asked["pca_atoms"]
    if _is_single(
        inputs, molecule, asked["stride"], molecule_options
    ):  # `frames` is about the trajectories beside it
        clusters, frames, atoms = "auto", frames and "all", None
    choice = choose_frames(
        molecule,
        clusters=clusters,
        frames=frames,
        atoms=atoms,
        rng=stream(settings["seed"], name, "clusters"),
    )
    choice.table.to_csv(outputs["frames"], index=False)
    choice.silhouettes.to_csv(outputs["silhouette"], index=False)
    projection = pd.DataFrame(choice.projection, columns=["pc1", "pc2"])
    projection.insert(0, "frame", molecule.frame_number)
    projection["cluster"] = choice.label
    projection.to_csv(outputs["projection"], index=False)
    pd.DataFrame({"explained": choice.explained}).to_csv(outputs["explained"], index=False)
    folder = Path(outputs["structures"])
    folder.mkdir()
    for conformation, position in zip(choice.table["conformation"], choice.index, strict=True):
        molecule.write_pdb(folder / f"{conformation}.pdb", position)


def _is_single(inputs, molecule, stride, molecule_options):
    """Whether a molecule is a structure of one model, or of one that was chosen: not one that a stride has left."""
    if "trajectory" in inputs or molecule.n_frames > 1:
        return False
    return stride == 1 or read_molecule(inputs["structure"], **molecule_options).n_frames == 1


if __name__ == "__main__":
    run(main, snakemake)
