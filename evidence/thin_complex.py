"""What maps from few centres are worth on one complex; in one thread, so that CPU seconds can be compared."""

from measures.partners import pair_of
from sparsurf.pairs.thinning import STAGES, thinning
from sparsurf.workflow.jobs import run

KEYS = ["complex", "sampler", "percent", "surface"]


def main(inputs, outputs, settings, pair):
    """Write means over both sides and all draws."""
    partners = pair_of(inputs["own"], pair)
    table = thinning(*partners, settings["percents"], draws=settings["draws"], with_recovered=True)
    groups = table.assign(complex=pair).groupby(KEYS, sort=False)
    means = groups[["n_S_percent", "correlation", "auc", "seconds", *STAGES]].mean().reset_index()
    means.insert(4, "n_S", groups["n_S"].mean().round(1).to_numpy())
    means.to_csv(outputs["table"], index=False)


if __name__ == "__main__":
    run(main, snakemake)
