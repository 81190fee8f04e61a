"""Quality of maps from few centres on one complex; in one thread, so that CPU seconds can be compared."""

from measures.partners import pair_of
from sparsurf.pairs.thinning import STAGES, thinning
from sparsurf.workflow.jobs import job

KEYS = ["complex", "sampler", "percent", "surface"]


def main(partners: list[str], table: str, pair: str, percents: list[float], draws: int) -> None:
    """Write means over both sides and all draws."""
    maps = thinning(*pair_of(partners, pair), percents, draws=draws, with_recovered=True)
    groups = maps.assign(complex=pair).groupby(KEYS, sort=False)
    means = groups[["n_S_percent", "correlation", "auc", "seconds", *STAGES]].mean().reset_index()
    means.insert(4, "n_S", groups["n_S"].mean().round(1).to_numpy())
    means.to_csv(table, index=False)


if __name__ == "__main__":
    with job(snakemake):
        main(
            partners=snakemake.input.partners,
            table=snakemake.output.table,
            pair=snakemake.wildcards.pair,
            percents=snakemake.params.percents,
            draws=snakemake.params.draws,
        )
