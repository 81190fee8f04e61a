"""Follow n_S and d of one combination over some of the frames of a trajectory."""

from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.study.ensemble import evaluate_frames
from sparsurf.workflow.jobs import job, reporter


def main(
    structure: str,
    trajectory: str | None,
    rows: str,
    surface: dict,
    patches: dict,
    distance_from_moved_centre: bool,
    chance_in_every_patch: bool,
    readings: list[str],
    combination: list[float],
    test_dots: int | str,
    stride: int,
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
    surface, patches : dict, sections of the config
    readings : see the section `evaluation` of the config
    combination, test_dots, stride : see the section `ensemble` of the config
    molecule_options : dict, options of `read_molecule`
    part : 1-of-3 for the first of three equal parts of the frames
    name : of the protein
    """
    molecule = read_molecule(structure, trajectory, stride=stride, **molecule_options)
    settings = {
        "surface": surface,
        "patches": patches,
        "sampling": {
            "distance_from_moved_centre": distance_from_moved_centre,
            "chance_in_every_patch": chance_in_every_patch,
        },
        "evaluation": {"readings": readings},
        "ensemble": {"combination": combination, "test_dots": test_dots, "stride": stride},
        "seed": seed,
    }
    k, n_parts = map(int, part.split("-of-"))
    progress = reporter(f"{name}, part {k} of {n_parts}", "frames")
    table = evaluate_frames(molecule, settings, name, threads, progress, (k, n_parts))
    table.to_csv(rows, index=False, lineterminator="\n")


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            trajectory=snakemake.input.get("trajectory"),
            rows=snakemake.output.rows,
            surface=snakemake.params.surface,
            patches=snakemake.params.patches,
            distance_from_moved_centre=snakemake.params.distance_from_moved_centre,
            chance_in_every_patch=snakemake.params.chance_in_every_patch,
            readings=snakemake.params.readings,
            combination=snakemake.params.combination,
            test_dots=snakemake.params.test_dots,
            stride=snakemake.params.stride,
            seed=snakemake.params.seed,
            molecule_options=snakemake.params.molecule_options,
            part=snakemake.wildcards.scatteritem,
            name=snakemake.wildcards.protein,
            threads=snakemake.threads,
        )
