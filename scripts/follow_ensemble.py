"""n_S and d of one combination over the frames of a trajectory."""

from pathlib import Path

from sparsurf.config import OF_STRUCTURES
from sparsurf.ensemble import follow
from sparsurf.structure import read_molecule
from sparsurf.workflow import job, reporter


def main(
    path_to_molecule, path_to_trajectory, path_to_table, path_to_part, protein, settings, name, threads, code
):
    """Write ensemble.csv; what an interrupted run has done is taken from the partial file beside it."""
    keys = {key: value for key, value in protein.items() if key in OF_STRUCTURES and key != "trajectory"}
    molecule = read_molecule(
        path_to_molecule, path_to_trajectory, stride=settings["ensemble"]["stride"], **keys
    )
    table = follow(molecule, settings, name, threads, path_to_part, code, reporter(name, "frames"))
    table.to_csv(path_to_table, index=False)
    Path(path_to_part).unlink()


if __name__ == "__main__":
    with job(snakemake) as output:
        main(
            path_to_molecule=snakemake.input.structure,
            path_to_trajectory=snakemake.input.get("trajectory"),
            path_to_table=output["table"],
            path_to_part=f"{snakemake.output.table}.part",  # not in `output`, which does not outlive the job
            protein=snakemake.params.protein,
            settings=snakemake.params.settings,
            name=snakemake.wildcards.protein,
            threads=snakemake.threads,
            code=snakemake.params.code,
        )
