"""Describe one chain that others are searched on."""

import sparsurf
from sparsurf.workflow.jobs import job


def main(structure: str, sites: str, chain: str) -> None:
    """Write the places of a structure."""
    sparsurf.describe_sites(structure, name=chain).save(sites)


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            sites=snakemake.output.sites,
            chain=snakemake.wildcards.chain,
        )
