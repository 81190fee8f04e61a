"""Follow n_S and d of one combination over some of the frames of a trajectory."""

from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.study.ensemble import evaluate_frames
from sparsurf.workflow.jobs import job, reporter


def main(
    structure: str,
    trajectory: str | None,
    rows: str,
    settings: Settings,
    seed: int,
    molecule_options: dict,
    part: str,
    name: str,
    threads: int = 1,
) -> None:
    """Write the rows of a part of the frames.

    Parameters
    ----------
    trajectory : None where the structure holds the frames
    molecule_options : dict, options of `read_molecule`
    part : 1-of-3 for the first of three equal parts of the frames
    name : of the protein
    """
    molecule = read_molecule(structure, trajectory, stride=settings.ensemble.stride, **molecule_options)
    k, n_parts = map(int, part.split("-of-"))
    progress = reporter(f"{name}, part {k} of {n_parts}", "frames")
    table = evaluate_frames(molecule, settings, Streams(seed, name), threads, progress, (k, n_parts))
    table.to_csv(rows, index=False, lineterminator="\n")


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            trajectory=snakemake.input.get("trajectory"),
            rows=snakemake.output.rows,
            settings=Settings.of(snakemake.params),
            seed=snakemake.params.seed,
            molecule_options=snakemake.params.molecule_options,
            part=snakemake.wildcards.scatteritem,
            name=snakemake.wildcards.protein,
            threads=snakemake.threads,
        )
