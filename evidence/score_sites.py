"""How often places and whole sites are found again: weights chosen on one half of the complexes, reported on the other."""

import numpy as np
import pandas as pd

from measures import sites
from measures.tables import joined, store
from sparsurf.study.statistics import mean_interval
from sparsurf.workflow.jobs import run

KINDS = ("interface", "elsewhere")
KEYS = ["percent", "channels", "places"]
VALUES = ["first", "first_percent", "auc", "chance"]


def main(inputs, outputs, forms):
    """Write the tables, and the weights chosen on the first half, which the library ships."""
    names, half, numbers, targets, queries, learned = sites.halves(inputs, forms)
    rows, moved = [], []
    for name, k, arrays in zip(names, half, numbers, strict=True):
        rows += [{"protein": name, "half": k + 1, **row} for row in sites.scores(arrays, learned[1 - k])]
        moved.append(sites.by_place(arrays, learned[1 - k], numbers).assign(protein=name))
    table, moved = pd.DataFrame(rows), pd.concat(moved)
    whole = sites.whole(names, half, queries, targets, [own.get("true_site") for own in numbers], learned)
    costs = joined(inputs["costs"])
    found = {
        "sites": table,
        "sites_means": _means(table),
        "sites_moved": _by_range(moved),
        "sites_whole": whole,
    }
    found["sites_costs"] = _costs(costs)
    found["sites_summary"] = _summary(table, moved, whole, numbers)
    store(found, outputs, "%.4g")
    shipped = {
        key: each if key == "channels" else each.astype(np.float32) for key, each in learned[0].items()
    }
    np.savez(outputs["weights"], **shipped)


def _means(table):
    """Means over proteins with 95 % intervals, of both halves in turn and of the half that the shipped weights have not seen."""
    rows = []
    for scope, own in (("in turn", table), ("shipped weights", table[table["half"] == 2])):
        for key, group in own.groupby(KEYS, sort=False):
            row = dict(zip(["scope", *KEYS], (scope, *key), strict=True)) | {"proteins": len(group)}
            for value in VALUES:
                row |= {value: group[value].mean()}
            row |= dict(
                zip(("first_low", "first_high"), mean_interval(group["first"].to_numpy())[1:], strict=True)
            )
            rows.append(row)
    return pd.DataFrame(rows)


def _by_range(moved):
    """The same of places, by how far the atoms around them moved."""
    low = pd.cut(moved["moved"], sites.MOVED, labels=sites.MOVED[:-1], right=False)
    table = moved.groupby(low, observed=True)[["first", "first_percent", "first_of_all"]].mean().reset_index()
    upper = dict(zip(sites.MOVED[:-1], sites.MOVED[1:], strict=True))
    table.insert(1, "below", [upper[value] for value in table["moved"]])
    return table.assign(places=moved.groupby(low, observed=True).size().to_numpy())


def _costs(costs):
    """What describing a protein costs, means over proteins; of all dots as if each of them were a place."""
    more = np.where(costs["percent"] == 100, costs["dots"] / costs["places"], 1)
    own = costs[["percent", "atoms", "places"]].assign(
        places=more * costs["places"],
        megabytes=more * costs["bytes"] / 1e6,
        seconds=more * costs["seconds"],
    )
    return own.groupby("percent").mean().reset_index().assign(proteins=costs["protein"].nunique())


def _summary(table, moved, whole, numbers):
    """Numbers of all: a row for each."""
    there = np.array([own["share_there"] for own in numbers])
    rows = {
        "proteins": table["protein"].nunique(),
        "places sought": len(moved),
        "candidates of all proteins": sum(len(own[f"target {sites.MAIN}"]) for own in numbers),
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
    run(main, snakemake)
