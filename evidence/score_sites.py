"""How often places and whole sites are found again: weights are chosen on one half of the complexes, tested on the other."""

import numpy as np
import pandas as pd

from measures import sites
from measures.tables import read_tables, write_tables
from sparsurf.study.statistics import mean_interval
from sparsurf.workflow.jobs import job

KINDS = ("interface", "elsewhere")
KEYS = ["percent", "channels", "places"]
VALUES = ["first", "first_percent", "auc", "chance"]


def main(
    numbers_paths: list[str],
    target_paths: list[str],
    site_paths: list[str],
    costs_paths: list[str],
    sites_table: str,
    sites_means: str,
    sites_moved: str,
    sites_whole: str,
    sites_summary: str,
    sites_costs: str,
    weights: str,
    forms: list[str],
) -> None:
    """Write the tables, and the weights chosen on the first half, which the library ships."""
    names, half, numbers, targets, queries, learned = sites.halves(
        numbers_paths, target_paths, site_paths, forms
    )
    rows, moved_tables = [], []
    for name, k, arrays in zip(names, half, numbers, strict=True):
        rows += [{"protein": name, "half": k + 1, **row} for row in sites.scores(arrays, learned[1 - k])]
        moved_tables.append(sites.by_place(arrays, learned[1 - k], numbers).assign(protein=name))
    table, moved = pd.DataFrame(rows), pd.concat(moved_tables)
    true_sites = [arrays.get("true_site") for arrays in numbers]
    whole = sites.whole(names, half, queries, targets, true_sites, learned)
    write_tables(
        {
            sites_table: table,
            sites_means: _means(table),
            sites_moved: _by_range(moved),
            sites_whole: whole,
            sites_summary: _summary(table, moved, whole, numbers),
            sites_costs: _costs(read_tables(costs_paths)),
        },
        "%.4g",
    )
    shipped = {
        key: values if key == "channels" else values.astype(np.float32) for key, values in learned[0].items()
    }
    np.savez(weights, **shipped)


def _means(table: pd.DataFrame) -> pd.DataFrame:
    """Return means over proteins with 95 % intervals: of both halves in turn, and of the half without the shipped weights."""
    rows = []
    for scope, rows_in_scope in (("in turn", table), ("shipped weights", table[table["half"] == 2])):
        for key, group in rows_in_scope.groupby(KEYS, sort=False):
            row = dict(zip(["scope", *KEYS], (scope, *key), strict=True)) | {"proteins": len(group)}
            for value in VALUES:
                row |= {value: group[value].mean()}
            row |= dict(
                zip(("first_low", "first_high"), mean_interval(group["first"].to_numpy())[1:], strict=True)
            )
            rows.append(row)
    return pd.DataFrame(rows)


def _by_range(moved: pd.DataFrame) -> pd.DataFrame:
    """Compute how often places are found, by how far the atoms around them moved."""
    low = pd.cut(moved["moved"], sites.MOVED, labels=sites.MOVED[:-1], right=False)
    table = moved.groupby(low, observed=True)[["first", "first_percent", "first_of_all"]].mean().reset_index()
    upper = dict(zip(sites.MOVED[:-1], sites.MOVED[1:], strict=True))
    table.insert(1, "below", [upper[value] for value in table["moved"]])
    return table.assign(places=moved.groupby(low, observed=True).size().to_numpy())


def _costs(costs: pd.DataFrame) -> pd.DataFrame:
    """Return the mean cost of describing a protein; with all dots kept, as if each of them were a place."""
    more = np.where(costs["percent"] == 100, costs["dots"] / costs["places"], 1)
    scaled = costs[["percent", "atoms", "places"]].assign(
        places=more * costs["places"],
        megabytes=more * costs["bytes"] / 1e6,
        seconds=more * costs["seconds"],
    )
    return scaled.groupby("percent").mean().reset_index().assign(proteins=costs["protein"].nunique())


def _summary(
    table: pd.DataFrame, moved: pd.DataFrame, whole: pd.DataFrame, numbers: list[dict]
) -> pd.DataFrame:
    """Return totals over all proteins, one per row."""
    there = np.array([arrays["share_there"] for arrays in numbers])
    rows = {
        "proteins": table["protein"].nunique(),
        "places sought": len(moved),
        "candidates of all proteins": sum(len(arrays[f"target {sites.MAIN}"]) for arrays in numbers),
        "right protein and place first": moved.groupby("protein")["first_of_all"].mean().mean(),
        "interface, right protein and place first": moved[moved["interface"]]
        .groupby("protein")["first_of_all"]
        .mean()
        .mean(),
        "whole sites": len(whole),
        "targets of a whole site": whole["targets"].mean(),
        "whole sites right": whole["right"].mean(),
        "whole sites on the right protein": whole["right_protein"].mean(),
        "lowest score on the right protein": whole["score"].min(),
        "highest score on another protein": whole["best_other"].max(),
        "interface dots on both forms": np.nanmean(there[:, 0]),
        "other dots on both forms": np.nanmean(there[:, 1]),
    }
    return pd.DataFrame({"what": rows.keys(), "value": rows.values()})


if __name__ == "__main__":
    with job(snakemake):
        main(
            numbers_paths=snakemake.input.numbers,
            target_paths=snakemake.input.targets,
            site_paths=snakemake.input.sites,
            costs_paths=snakemake.input.costs,
            sites_table=snakemake.output.sites,
            sites_means=snakemake.output.sites_means,
            sites_moved=snakemake.output.sites_moved,
            sites_whole=snakemake.output.sites_whole,
            sites_summary=snakemake.output.sites_summary,
            sites_costs=snakemake.output.sites_costs,
            weights=snakemake.output.weights,
            forms=snakemake.params.forms,
        )
