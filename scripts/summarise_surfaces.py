"""Summarise all surfaces of a run in one table, with the figure of how many dots are enough."""

from pathlib import Path

from sparsurf.report.figures import layout, required_dots
from sparsurf.rounding import write_table
from sparsurf.study.summary import read_result, surfaces_table
from sparsurf.workflow.jobs import job


def main(surfaces: list[str], table: str, png: str, patches: dict, minimal: dict, sampled: list[str]) -> None:
    """Write surfaces.csv and the figure.

    Parameters
    ----------
    surfaces : paths that end in <protein>/<conformation>/surface.npz; the other results lie in the same folders
    patches, minimal : dict, sections of the config
    sampled : proteins that have results of the grid
    """
    folders = {Path(path).parent: Path(path).parts[-3] in sampled for path in surfaces}
    write_table(table, surfaces_table([read_result(*folder) for folder in folders.items()], patches))
    curves = [required_dots.read(*folder) for folder in folders.items()]
    layout.save(required_dots.figure(curves, minimal.get("floor", required_dots.FRESH)), png)


if __name__ == "__main__":
    with job(snakemake):
        main(
            surfaces=snakemake.input.surfaces,
            table=snakemake.output.table,
            png=snakemake.output.png,
            patches=snakemake.params.patches,
            minimal=snakemake.params.minimal,
            sampled=snakemake.params.sampled,
        )
