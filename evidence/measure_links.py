"""d of the published combinations on one surface by linking distance and reading."""

from measures import fragments, links
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    name, params = snakemake.wildcards.protein, snakemake.params
    prepared = fragments.prepare(snakemake.input.structure, params, f"links {name}", snakemake.threads)
    table = links.links_table(prepared, params.links, params.test_dots, params.draws)
    table.insert(0, "surface", name)
    table.to_csv(snakemake.output.links, index=False)
