"""Gather the rows of all frames of a trajectory in one table, and R_i of the residues over them."""

from pathlib import Path

import pandas as pd

from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.rounding import write_table
from sparsurf.study.ensemble import split_residue_columns
from sparsurf.study.residues import roughness_over_frames
from sparsurf.workflow.jobs import job

STRIDE_TO_FIRST_FRAME = 10**9  # leaves one frame: the residues are the same in all


def main(
    structure: str,
    trajectory: str | None,
    rows: list[str],
    table: str,
    over_time: str,
    residues: str,
    molecule_options: dict,
) -> None:
    """Write ensemble.csv, and R_i of the residues in every frame and over all.

    Parameters
    ----------
    trajectory : None where the structure holds the frames
    rows : paths of the rows of all parts, in order
    table, over_time, residues : tables to be written
    molecule_options : dict, options of `read_molecule`
    """
    molecule = read_molecule(structure, trajectory, stride=STRIDE_TO_FIRST_FRAME, **molecule_options)
    parts = [pd.read_csv(path) for path in rows if Path(path).stat().st_size > 1]  # some may have no frames
    frames, roughness_over_time = split_residue_columns(pd.concat(parts), molecule.residues)
    write_table(table, frames)
    write_table(over_time, roughness_over_time)
    roughness = roughness_over_time.to_numpy(float)[:, 2:]
    write_table(residues, roughness_over_frames(molecule.residues, roughness))


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            trajectory=snakemake.input.get("trajectory"),
            rows=list(snakemake.input.rows),
            table=snakemake.output.table,
            over_time=snakemake.output.over_time,
            residues=snakemake.output.residues,
            molecule_options=snakemake.params.molecule_options,
        )
