"""How far position and dots move both descriptors, over several structures: tables and figure."""

from measures.steadiness import draw, means
from measures.tables import read_tables, write_tables
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    changes = read_tables(snakemake.input.changes)
    over_structures = means(changes, ["density", "descriptor", "change"])
    write_tables({snakemake.output.changes: changes, snakemake.output.changes_means: over_structures})
    at_lowest = over_structures[over_structures["density"] == over_structures["density"].min()]
    draw(at_lowest).savefig(snakemake.output.figure, dpi=200, metadata={"Software": None})
