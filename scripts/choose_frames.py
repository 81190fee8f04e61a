"""Frames of a trajectory, models of a file or a single structure become the conformations of a study."""

from pathlib import Path

import pandas as pd

from sparsurf.frames import choose_frames
from sparsurf.parallel import stream
from sparsurf.structure import read_molecule
from sparsurf.workflow import job

NO_KEYS = ("structure", "trajectory", "url", "pdb", "sha256")  # of a protein: where it is, not how it is read


def main(path_to_molecule, path_to_trajectory, paths, path_to_structures, protein, settings, name):
    """Write frames.csv, what it was chosen from, and one PDB file per conformation."""
    keys = {key: value for key, value in protein.items() if key not in NO_KEYS}
    molecule = read_molecule(path_to_molecule, path_to_trajectory, stride=settings["stride"], **keys)
    choice = choose_frames(
        molecule,
        clusters=settings["clusters"],
        frames=None if settings["use"] == "clusters" else settings["use"],
        atoms=None if settings["pca_atoms"] == "auto" else settings["pca_atoms"],
        rng=stream(settings["seed"], name, "clusters"),
    )
    choice.table.to_csv(paths["frames"], index=False)
    choice.silhouettes.to_csv(paths["silhouette"], index=False)
    projection = pd.DataFrame(choice.projection, columns=["pc1", "pc2"])
    projection.insert(0, "frame", molecule.frame_number)
    projection["cluster"] = choice.label
    projection.to_csv(paths["projection"], index=False)
    pd.DataFrame({"explained": choice.explained}).to_csv(paths["explained"], index=False)
    folder = Path(path_to_structures)
    folder.mkdir()
    for conformation, position in zip(choice.table["conformation"], choice.index, strict=True):
        molecule.write_pdb(folder / f"{conformation}.pdb", position)


if __name__ == "__main__":
    with job(snakemake) as output:
        main(
            path_to_molecule=snakemake.input.structure,
            path_to_trajectory=snakemake.input.get("trajectory"),
            paths={key: output[key] for key in ("frames", "silhouette", "projection", "explained")},
            path_to_structures=output["structures"],
            protein=snakemake.params.protein,
            settings=snakemake.params.settings,
            name=snakemake.wildcards.protein,
        )
