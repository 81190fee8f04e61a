"""Cost and error of analyses of few dots; in one thread, so that CPU seconds can be compared."""

from measures import fragments, thinned_costs
from measures.partners import pair_of
from measures.tables import write_tables
from sparsurf.workflow.jobs import job


def main(
    structure: str,
    partners: list[str],
    table: str,
    percents: list[float],
    samplers: list[str],
    surface: dict,
    seed: int,
) -> None:
    """Write a row per sampler and number of dots."""
    dots = fragments.dots_of(structure, surface["reentrant"], surface)
    pair = pair_of(partners, "pair")
    write_tables({table: thinned_costs.measure(dots, pair, percents, samplers, seed)}, "%.4g")


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            partners=snakemake.input.partners,
            table=snakemake.output.table,
            percents=snakemake.params.percents,
            samplers=snakemake.params.samplers,
            surface=snakemake.params.surface,
            seed=snakemake.params.seed,
        )
