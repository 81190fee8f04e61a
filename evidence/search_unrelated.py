"""Groups of places of one chain searched on chains of other superfamilies."""

from measures import unrelated
from sparsurf.sites.describing import load_sites
from sparsurf.streams import stream
from sparsurf.workflow.jobs import job


def main(sites: str, targets: list[str], table: str, chain: str, half: int, seed: int) -> None:
    """Write a row per group and target."""
    rng = stream(seed, "unrelated", chain)
    queries = unrelated.groups(load_sites(sites), rng)
    rows = unrelated.search(queries, [load_sites(path) for path in targets])
    rows.assign(protein=chain, half=half, same=False).to_csv(table, index=False)


if __name__ == "__main__":
    with job(snakemake):
        main(
            sites=snakemake.input.sites,
            targets=snakemake.input.targets,
            table=snakemake.output.table,
            chain=snakemake.wildcards.chain,
            half=snakemake.params.half,
            seed=snakemake.params.seed,
        )
