"""AUC of complementarity and of protrusion over many complexes: tables and figure."""

from measures.tables import read_tables, write_tables
from sparsurf.views import layout
from sparsurf_study.pairs.ranking import means_over_pairs
from sparsurf_study.report.figures.pair_figures import over_pairs
from sparsurf_study.workflow.jobs import job

COLUMNS = ["complex", "partner", "descriptor", "score", "auc", "low", "high", "dots", "interface"]
NAMES = {"rotation_robust propensity_smoothed": "complementarity, rotation-robust"}  # in the figure

with job(snakemake):
    areas = read_tables(snakemake.input.areas)[COLUMNS]
    areas["descriptor"] = areas["descriptor"].mask(areas["score"] == "protrusion", "-")
    areas = areas.drop_duplicates(COLUMNS[:4])
    means = means_over_pairs(areas, ["descriptor", "score"])
    tables = {snakemake.output.complexes: areas, snakemake.output.complexes_means: means}
    write_tables(tables, "%.4f")
    named = (areas["descriptor"] + " " + areas["score"]).map(NAMES).fillna(areas["score"])
    layout.save(over_pairs("complexes", areas.assign(score=named)), snakemake.output.figure)
