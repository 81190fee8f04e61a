"""Tabulate the best parameters of all surfaces, and whether they follow mean roughness."""

from pathlib import Path

from sparsurf.rounding import write_table
from sparsurf.streams import stream
from sparsurf.study.summary import read_result, relation_table, summary_table
from sparsurf.workflow.jobs import job


def main(surfaces: list[str], summary: str, relation: str, seed: int) -> None:
    """Write summary.csv and relation.csv.

    Parameters
    ----------
    surfaces : paths that end in <protein>/<conformation>/surface.npz; the other results lie in the same folders
    """
    results = [read_result(Path(path).parent) for path in surfaces]
    best = summary_table(results)
    write_table(summary, best)
    write_table(relation, relation_table(results, best, stream(seed, "summary")))


if __name__ == "__main__":
    with job(snakemake):
        main(
            surfaces=snakemake.input.surfaces,
            summary=snakemake.output.summary,
            relation=snakemake.output.relation,
            seed=snakemake.params.seed,
        )
