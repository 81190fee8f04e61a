"""The best combination per range of n_S, and the best of all."""

import json

import pandas as pd

from sparsurf import evaluation, tables
from sparsurf.workflow import job


def main(path_to_grid, path_to_distances, path_to_ranges, path_to_best, settings):
    """Write ranges.csv and best.json, and their twins for people."""
    table, grid = pd.read_csv(path_to_grid), evaluation.load_grid(path_to_distances)
    ranges = tables.ranges_table(table, grid, settings["ranges"])
    best = tables.best(table, grid, settings["max_n_S_percent"])
    ranges.to_csv(path_to_ranges["csv"], index=False)
    texts = {
        path_to_ranges["md"]: tables.ranges_markdown(ranges, best["yardsticks"]),
        path_to_best["md"]: tables.best_markdown(best),
        path_to_best["json"]: json.dumps(best, indent=2) + "\n",
    }
    for path, text in texts.items():
        with open(path, "w", encoding="utf-8") as stream:
            stream.write(text)


if __name__ == "__main__":
    with job(snakemake) as output:
        main(
            path_to_grid=snakemake.input.grid,
            path_to_distances=snakemake.input.distances,
            path_to_ranges={"csv": output["ranges"], "md": output["ranges_md"]},
            path_to_best={"json": output["best"], "md": output["best_md"]},
            settings=snakemake.params.settings,
        )
