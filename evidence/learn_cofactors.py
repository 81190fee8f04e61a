"""One attempt to beat residue composition across folds, with weights learned on half of the folds."""

import pandas as pd

from measures import atom_channels, cofactors
from measures.tables import write_tables
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.streams import stream
from sparsurf.workflow.jobs import job


def main(
    sites: str, answers: str, queries: list[str], relatives: list[str], table: str, means: str, seed: int
) -> None:
    """Write a row per query, target and method, and their means; `answers` has the TM-scores."""
    entries, molecules, ligands = cofactors.read_sites(sites)
    pairs = [
        (read_molecule(query), read_molecule(relative))
        for query, relative in zip(queries, relatives, strict=True)
    ]
    rng = stream(seed, "cofactors", "relatives")
    points = [cofactors.points_above(query) for query, _ in pairs]
    tm = pd.read_csv(answers).drop_duplicates(["query", "target"]).set_index(["query", "target"])["tm"]
    rows = atom_channels.measure(
        entries["name"].to_list(),
        entries["class"].to_list(),
        molecules,
        [ligand.mean(axis=0) for ligand in ligands],
        [cofactors.points_above(molecule) for molecule in molecules],
        tm,
        atom_channels.relatives(pairs, [rng.permutation(own)[: atom_channels.PLACES] for own in points]),
    )
    write_tables({table: rows, means: atom_channels.means(rows)}, "%.4g")


if __name__ == "__main__":
    with job(snakemake):
        main(
            sites=snakemake.input.sites,
            answers=snakemake.input.answers,
            queries=snakemake.input.queries,
            relatives=snakemake.input.relatives,
            table=snakemake.output.table,
            means=snakemake.output.means,
            seed=snakemake.params.seed,
        )
