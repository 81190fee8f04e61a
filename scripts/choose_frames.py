"""Choose the conformations of a study from a trajectory, the models of a file, or a single structure."""

from pathlib import Path

import pandas as pd

from sparsurf.molecules.conformations import choose_frames
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.rounding import write_table
from sparsurf.streams import stream
from sparsurf.workflow.jobs import job


def main(
    structure: str,
    trajectory: str | None,
    frames: str,
    silhouette: str,
    projection: str,
    explained: str,
    structures: str,
    settings: dict,
    molecule_options: dict,
    seed: int,
    name: str,
) -> None:
    """Write frames.csv, the tables it was chosen from, and one PDB file per conformation.

    Parameters
    ----------
    settings : dict, the section `frames` of the config
    molecule_options : dict, the keyword arguments of `read_molecule` that the protein has in the config
    """
    stride, selection, clusters = settings["stride"], settings["selection"], settings["clusters"]
    molecule = read_molecule(structure, trajectory, stride=stride, **molecule_options)
    chosen = None if selection == "clusters" else selection
    if trajectory is None and molecule.n_frames == 1:
        all_frames = molecule if stride == 1 else read_molecule(structure, **molecule_options)
        if all_frames.n_frames == 1:  # `frames` is about the trajectories of the same study
            clusters, chosen = "auto", chosen and "all"
    choice = choose_frames(molecule, clusters=clusters, frames=chosen, rng=stream(seed, name, "clusters"))
    write_table(frames, choice.table)
    write_table(silhouette, choice.silhouettes)
    coordinates = pd.DataFrame(choice.projection, columns=["pc1", "pc2"])
    coordinates.insert(0, "frame", molecule.frame_number)
    coordinates["cluster"] = choice.label
    write_table(projection, coordinates)
    write_table(explained, pd.DataFrame({"explained": choice.explained}))
    Path(structures).mkdir()
    for conformation, position in zip(choice.table["conformation"], choice.index, strict=True):
        molecule.write_pdb(Path(structures, f"{conformation}.pdb"), position)


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            trajectory=snakemake.input.get("trajectory"),
            frames=snakemake.output.frames,
            silhouette=snakemake.output.silhouette,
            projection=snakemake.output.projection,
            explained=snakemake.output.explained,
            structures=snakemake.output.structures,
            settings=snakemake.params.frames,
            molecule_options=snakemake.params.molecule_options,
            seed=snakemake.params.seed,
            name=snakemake.wildcards.protein,
        )
