"""Tables of both descriptors over several structures."""

from measures.steadiness import grid_means, means
from measures.tables import cpu_table, read_tables, write_tables
from sparsurf.workflow.jobs import job


def main(tables: dict[str, list[str]], outputs: dict[str, str], logs: str) -> None:
    """Write the tables of all structures, and means of what changes a descriptor.

    `tables` and `outputs` have the keys changes, linked, orders, rows, samplers and grid; `outputs` also has changes_means,
    linked_means, orders_means, grid_means and cpu.
    """
    results = {key: read_tables(paths) for key, paths in tables.items()}
    results["changes_means"] = means(results["changes"], ["density", "descriptor", "change"])
    results["linked_means"] = means(results["linked"], ["D_link", "descriptor", "change"])
    results["orders_means"] = means(results["orders"], ["density", "descriptor", "n"])
    results["grid_means"] = grid_means(results["grid"])
    results["cpu"] = cpu_table(logs)
    write_tables({outputs[key]: table for key, table in results.items()})


if __name__ == "__main__":
    with job(snakemake):
        main(
            tables=dict(snakemake.input.items()),
            outputs=dict(snakemake.output.items()),
            logs=snakemake.params.logs,
        )
