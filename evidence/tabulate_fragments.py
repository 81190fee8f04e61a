"""Table I on all surfaces of the paper: published values next to ours, and whether its choices carry over."""

import pandas as pd

from measures.fragments import PUBLISHED_BEST
from measures.tables import cpu_table, read_tables, write_tables
from sparsurf.paper.published_runs import place_published_values, size_of_tests, tests_of_table_1
from sparsurf.patches.readings import CODED_READING, GRID_READINGS
from sparsurf.workflow.jobs import job

OF_SURFACE = ["dots", "centres", "mean_roughness", "lowest_roughness", "highest_roughness"]
OF_STUDY = "A1_dms, other test dots"  # the surface of `make paper`
ROW = ["row", "combination", "d_published", "Z_published"]


def table1_of(rows: pd.DataFrame) -> pd.DataFrame:
    """Return Table I as coded with a column of d and Z for each surface: d_A1_file, d_A1_file_low, ..."""
    coded = rows[rows["reading"] == CODED_READING]
    table = coded.drop_duplicates("row")[ROW].set_index("row")
    for surface, of_surface in coded.groupby("surface", sort=False):
        values = of_surface.set_index("row")
        table[f"n_S_percent_{surface}"] = values["n_S_percent"]
        for name in ("d", "Z"):
            for end in ("", "_low", "_high"):
                table[f"{name}_{surface}{end}"] = values[f"{name}{end}"]
    return table.reset_index()


def inside_of(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the number of published values of d and Z inside of the intervals, per surface and reading, and the sign of d."""
    groups = rows.groupby(["surface", "reading"], sort=False)
    above, below = (
        rows.assign(there=there.astype(int)).groupby(["surface", "reading"], sort=False)["there"].sum()
        for there in (rows["d_low"] > 0, rows["d_high"] < 0)
    )
    table = groups.agg(rows=("row", "size"), d_inside=("d_inside", "sum"), Z_inside=("Z_inside", "sum"))
    return table.assign(d_above_0=above, d_below_0=below).reset_index()


def rows_of_study(paper_rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of the paper's study, with test dots of its own, in the form of `fragments.rows_table`."""
    tables = []
    for reading in GRID_READINGS:
        table = pd.DataFrame({"surface": OF_STUDY, "reading": reading, "row": range(1, len(paper_rows) + 1)})
        for name, key in (("d", "d"), ("Z", "Z_tS")):
            low, high = paper_rows[f"{key}_low_{reading}"], paper_rows[f"{key}_high_{reading}"]
            table[f"{name}_low"], table[f"{name}_high"] = low, high
            table[f"{name}_inside"] = paper_rows[f"{key}_published"].between(low, high).astype(int)
        tables.append(table)
    return pd.concat(tables, ignore_index=True)


def surfaces_of(rows: pd.DataFrame, choices: pd.DataFrame) -> pd.DataFrame:
    """Return a row per surface and reading: its dots, and how the choices of Table I do on it.

    n_may_be_best counts the rows of Table I whose combination may be the best of its range here; n_worse those for which choosing
    again gains significantly; gain is the mean over the rows. d_best and rank_best are those of (1, 0, 6, 0) in its range.
    """
    keys = ["surface", "reading"]
    counted = choices.assign(
        n_worse=(choices["gain_low"] > 0).astype(int),
        same_range=(choices["range"] == choices["row"]).astype(int),
    )
    table = counted.groupby(keys, sort=False).agg(
        n_S_lowest_percent=("n_S_lowest_percent", "first"),
        n_S_highest_percent=("n_S_highest_percent", "first"),
        n_may_be_best=("may_be_best", "sum"),
        n_worse=("n_worse", "sum"),
        n_same_range=("same_range", "sum"),
        gain=("gain", "mean"),
        largest_gain=("gain", "max"),
    )
    best = choices[choices["row"] == PUBLISHED_BEST].set_index(keys)
    for column in ("d", "gain", "gain_low", "gain_high", "may_be_best"):
        table[f"{column}_best"] = best[column]
    of_surface = rows.drop_duplicates("surface").set_index("surface")[OF_SURFACE]
    return table.reset_index().merge(of_surface, on="surface", how="left")


def main(
    rows: list[str],
    choices: list[str],
    gathering: str,
    repeated: str,
    runs: str,
    paper_rows: str,
    tables: dict[str, str],
    logs: str,
) -> None:
    """Write the tables.

    Parameters
    ----------
    paper_rows : the published combinations in the study of `make paper`
    repeated, runs : winners of runs as published on the dots of DMS and on our own
    tables : paths to be written, by the names rows, table1, inside, choices, surfaces, places, tests,
        gathering, size, cpu
    """
    all_rows, all_choices = read_tables(rows), read_tables(choices)
    again = pd.read_csv(repeated)
    places = place_published_values(again)
    sizes = [
        size_of_tests(pd.read_csv(path)).assign(dots=name)
        for name, path in (("DMS's own", repeated), ("placed as by DMS", runs))
    ]
    found = {
        "rows": all_rows,
        "table1": table1_of(all_rows),
        "inside": inside_of(pd.concat([all_rows, rows_of_study(pd.read_csv(paper_rows))], ignore_index=True)),
        "choices": all_choices,
        "surfaces": surfaces_of(all_rows, all_choices),
        "places": places,
        "tests": tests_of_table_1(places, again.groupby("run")["centres"].first().to_numpy()),
        "gathering": pd.read_csv(gathering),
        "size": pd.concat(sizes, ignore_index=True),
        "cpu": cpu_table(logs),
    }
    write_tables({tables[name]: table for name, table in found.items()})


if __name__ == "__main__":
    with job(snakemake):
        main(
            rows=snakemake.input.rows,
            choices=snakemake.input.choices,
            gathering=snakemake.input.gathering,
            repeated=snakemake.input.repeated,
            runs=snakemake.input.runs,
            paper_rows=snakemake.input.paper_rows,
            tables=dict(snakemake.output.items()),
            logs=snakemake.params.logs,
        )
