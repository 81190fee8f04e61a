"""d of the published combinations on one surface by the link in spacings of the kept dots, with the share in islands."""

from measures import curve, fragments
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    name, params = snakemake.wildcards.protein, snakemake.params
    prepared = fragments.prepare(snakemake.input.structure, params, f"links {name}", snakemake.threads)
    table = curve.curve_table(prepared, params.links, params.test_dots, params.draws)
    table.insert(0, "surface", name)
    table.to_csv(snakemake.output.curve, index=False)
