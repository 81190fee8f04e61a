"""Page on the paper: each claim, whether it holds under each reading, and the numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from sparsurf.paper import replication
from sparsurf.paper.published_runs import MEASURES
from sparsurf.patches.readings import CODED_READING, GRID_READINGS, WRITTEN_READING
from sparsurf.recovery.readings import RECOVERED
from sparsurf.report.numbers import against_zero, combination, interval, number, share
from sparsurf.sampling.combination import (
    PARAMETERS,
    PUBLISHED_ROWS,
    TABLE_1,
    Combination,
    combination_labels,
    split_combinations,
)
from sparsurf.study.required_dots import AT_MOST, MORE
from sparsurf.study.rough_and_flat import MIN_TEST_DOTS

if TYPE_CHECKING:
    from sparsurf.study.prepared_surface import PreparedSurface

TEMPLATE = "paper.html.j2"
YES, NO, PARTLY = "yes", "no", "in part"
MIN_P = 0.05  # below which published values are not those of one more run
NEGLIGIBLE_SHARE = 0.05  # of the combinations, which does not change a verdict
PUBLISHED_BEST = (1, 0, 6, 0)  # at alpha = 1
PUBLISHED_D = 2.69  # of that combination
MAX_LINK_COLUMNS = 6
HALVES = ("rougher half", "flatter half")
FIGURES = {  # the paper's figure: its file among those of the surface, and the chapter with its numbers
    1: ("roughness", "range_of_roughness"),
    2: ("number_of_dots_panels", "span"),
    3: ("d_over_grid_panels", "best"),
    4: ("rough_and_flat", "rough"),
    5: ("subsets", "gather"),
}


def paper_page(data: dict[str, Any]) -> dict[str, Any]:
    """Collect the values of the page.

    Parameters
    ----------
    data : dict
        DataFrames: `grid` and `ranges` of the surface, `rows` (`replication.published_rows`), `places`, `tests` and
        `bias` (`published_runs`), `links` and `signs` (`replication.sweep_links`, `sign_changes`), `defects`, `bins`
        (`rough_and_flat.bins_table`, with a column `around`), `family` (`replication.best_of_family`), `required_dots`
        (`required_dots.required_dots_table`), `gathering` (`replication.gathering_by_roughness`). `best` (dict), `uniform`
        (dict: median number of patches of a dot), `surface` (dict, see `surface_of`).
    """
    grid, null = data["grid"], data["best"]["references"]["Z_mean_descriptor"]
    chapters = {
        "span": span_of(grid),
        "table1": table1(data["places"], data["tests"], data["rows"], data["bias"]),
        "winners": winners(data["ranges"], data["places"]),
        "best": best_at_one(data["best"], grid),
        "positive": positive(grid, data["family"]),
        "describe": describe(grid, data["rows"], null),
        "rough": rough_and_flat(data["bins"]),
        "uniform": uniform(grid, data["uniform"]["median"]),
        "gather": gather(data["gathering"]),
        "range_of_roughness": range_of_roughness(data["surface"]),
    }
    return chapters | {
        "claims": [(name, chapter["holds"]) for name, chapter in chapters.items()],
        "readings": GRID_READINGS,
        "surface": data["surface"],
        "links": links(data["links"], data["signs"], grid),
        "defects": defects(data["defects"]),
        "outlook": outlook(data["required_dots"]),
        "figures": [(n, file, chapter, chapters[chapter]["holds"]) for n, (file, chapter) in FIGURES.items()],
    }


def surface_of(
    evaluator: PreparedSurface, rules: dict[str, Any], path_to_surface: str | None = None
) -> dict[str, Any]:
    """Describe the dots: how they were generated, and their numbers next to those of the paper's A1."""
    source = "file" if path_to_surface else "program" if rules["method"] == "dms" else rules["reentrant"]
    rows = [
        ("dots", f"{len(evaluator.points):,}", "20,045"),
        ("centres of patches", f"{len(evaluator.cover.centre):,}", "181"),
        ("mean roughness", number(evaluator.roughness.mean(), 4), "0.6263"),
    ]
    ends = evaluator.roughness.min(), evaluator.roughness.max()
    return {"source": source, "rows": rows, "roughness": tuple(map(float, ends))}


def judged(agree: float, several: bool = False) -> str:
    """Judge a share of cases as yes, no or in part; with `several`, a few cases do not count."""
    few = NEGLIGIBLE_SHARE if several else 0
    return YES if agree >= 1 - few else NO if agree <= few else PARTLY


def both(holds: str) -> dict[str, str]:
    """Return the same answer for both readings."""
    return dict.fromkeys(GRID_READINGS, holds)


def span_of(grid: pd.DataFrame) -> dict[str, Any]:
    """Compare the range of n_S of the grid with the published one."""
    measured = grid["n_S_percent"].min(), grid["n_S_percent"].max()
    published = TABLE_1["n_S_low_percent"][0], TABLE_1["n_S_high_percent"][-1]
    near = np.abs(np.subtract(measured, published)).max() < 0.2
    return {
        "holds": both(YES if near else NO),
        "found": [number(x) for x in measured],
        "said": [number(x) for x in published],
    }


def table1(
    places: pd.DataFrame, tests: pd.DataFrame, rows: pd.DataFrame, bias: pd.DataFrame
) -> dict[str, Any]:
    """Compare Table I with runs made as published, under both binnings, and with the other reading."""
    agree = tests.loc[tests["measure"] == "together", "p"] >= MIN_P
    d, low, high = (rows[f"{key}_{WRITTEN_READING}"] for key in ("d", "d_low", "d_high"))
    inside = (low <= rows["d_published"]) & (rows["d_published"] <= high)
    coded = {
        name: [rows[f"{name}{end}_{CODED_READING}"] for end in ("", "_low", "_high")] for name in MEASURES
    }
    inside_coded = {
        name: int(rows[f"{name}_published"].between(ends[1], ends[2]).sum()) for name, ends in coded.items()
    }
    runs = places[places["binning"] == "half-open"]
    of_bias = bias[bias["binning"] == "closed"]["d_bias"]
    return {
        "holds": {CODED_READING: judged(float(agree.mean())), WRITTEN_READING: judged(inside.mean())},
        "runs": int(runs["n_runs"].max()),
        "tests": [
            (
                row["binning"],
                row["measure"],
                p_text(row["p"]),
                outside_of(places, row["binning"], row["measure"]),
            )
            for _, row in tests.iterrows()
        ],
        "as_written": [number(d.min()), number(d.max())],
        "bias": number(of_bias.mean()),
        "inside": inside_coded,
        "rows": len(rows),
        "table": [
            [
                f"{row['range']}",
                combination(row),
                number(row["d_published"]),
                interval(*of_combination),
                interval(row["d_mean"], row["d_lowest"], row["d_highest"]),
                interval(*written),
            ]
            for (_, row), of_combination, written in zip(
                runs.iterrows(), zip(*coded["d"], strict=True), zip(d, low, high, strict=True), strict=True
            )
        ],
        "table_of_Z": [
            [
                f"{row['range']}",
                number(row["Z_tS_published"]),
                interval(*of_combination),
                interval(row["Z_tS_mean"], row["Z_tS_lowest"], row["Z_tS_highest"]),
            ]
            for (_, row), of_combination in zip(
                runs.iterrows(), zip(*coded["Z_tS"], strict=True), strict=True
            )
        ],
    }


def outside_of(places: pd.DataFrame, binning: str, name: str) -> str:
    """List the rows (from 1) whose published value lies outside all runs; empty for measures that have no rows."""
    if name not in MEASURES:
        return ""
    runs = places[places["binning"] == binning]
    low, high, published = (runs[f"{name}_{key}"] for key in ("lowest", "highest", "published"))
    return ", ".join(map(str, runs.loc[(published < low) | (published > high), "range"])) or "none"


def p_text(p: float) -> str:
    """Format a probability, never as 0."""
    return "< 0.0001" if p < 0.0001 else f"{p:.2g}"


def winners(ranges: pd.DataFrame, places: pd.DataFrame) -> dict[str, Any]:
    """Compare our winner of each range with the published one, and count how often that won the runs."""
    published = [str(Combination(*row)) for row in PUBLISHED_ROWS]
    ours, same, among = {}, {}, {}
    for reading in GRID_READINGS:
        rows = ranges[ranges["reading"] == reading]
        ours[reading] = combination_labels(rows)
        same[reading] = sum(a == b for a, b in zip(ours[reading], published, strict=False))
        among[reading] = sum(
            b in split_combinations(field) for field, b in zip(rows["best_set"], published, strict=False)
        )
    runs = places[places["binning"] == "half-open"]
    return {
        "holds": {reading: judged(among[reading] / len(published)) for reading in GRID_READINGS},
        "same": same,
        "among": among,
        "rows": len(published),
        "table": [
            [k, text, *winners_, f"{won} of {n}"]
            for k, (text, *winners_, won, n) in enumerate(
                zip(published, *ours.values(), runs["n_won"], runs["n_runs"], strict=False), 1
            )
        ],
    }


def best_at_one(best: dict[str, Any], grid: pd.DataFrame) -> dict[str, Any]:
    """Compare the best combination at the largest alpha with the published one."""
    published = grid[np.isclose(grid[PARAMETERS], PUBLISHED_BEST).all(axis=1)]
    holds: dict[str, str] = {}
    table = []
    for reading in GRID_READINGS:
        row = best[reading]["unrestricted"]
        d = [f"{key}_{reading}" for key in ("d", "d_low", "d_high")]
        among = str(Combination(*PUBLISHED_BEST)) in split_combinations(row["best_set"])
        inside = published[d[1]].le(PUBLISHED_D).all() and published[d[2]].ge(PUBLISHED_D).all()
        holds[reading] = NO if not among else YES if inside else PARTLY
        d_published = interval(*published[d].iloc[0]) if len(published) else interval(np.nan, np.nan, np.nan)
        d_ours = interval(row["d_cv"], row["d_cv_low"], row["d_cv_high"])
        table.append((reading, [combination(row), d_ours, int(row["n_best_set"]), d_published]))
    return {"holds": holds, "table": table}


def positive(grid: pd.DataFrame, family: pd.DataFrame) -> dict[str, Any]:
    """Count the combinations in which the sampling beats a uniform subset, also with alpha tuned to the same n_S."""
    holds, loses, table = {}, {}, []
    for reading in GRID_READINGS:
        d, low, high = (grid[f"{key}_{reading}"] for key in ("d", "d_low", "d_high"))
        holds[reading] = judged((low > 0).mean(), several=True)
        loses[reading] = bool((high < 0).mean() > 0.5)
        table.append(
            (
                reading,
                [
                    int((d > 0).sum()),
                    int((low > 0).sum()),
                    int((high < 0).sum()),
                    number(d.mean()),
                    number(d.max()),
                ],
            )
        )
    return {
        "holds": holds,
        "loses": loses,
        "n": len(grid),
        "table": table,
        "members": int(family["members"].sum()),
        "better": int(family["n_better"].sum()),
        "family": [
            [f"{row['percent']:g}", number(row["Z_best"]), number(row["Z_uniform"])]
            for _, row in family.iterrows()
        ],
    }


def describe(grid: pd.DataFrame, rows: pd.DataFrame, null: float) -> dict[str, Any]:
    """Count the combinations in which a subset describes a patch worse than the mean patch does."""
    holds, table = {}, []
    for reading in GRID_READINGS:
        worse, of_rows = (table_[f"Z_tS_{reading}"] > null for table_ in (grid, rows))
        holds[reading] = judged(1 - worse.mean(), several=True)
        table.append((reading, [int(worse.sum()), len(grid), int(of_rows.sum()), len(rows)]))
    return {"holds": holds, "null": number(null), "table": table}


def rough_and_flat(bins: pd.DataFrame) -> dict[str, Any]:
    """Compare d in rough and flat patches, around kept dots (as in the paper) and around any dots."""
    agree: dict[str, list[bool]] = {reading: [] for reading in GRID_READINGS}
    table = []
    for around, rows in bins.groupby("around", sort=False):
        single = rows[~rows["bin"].isin(HALVES) & (rows["n"] >= MIN_TEST_DOTS)]
        rough, flat = (rows[rows["bin"] == name].iloc[0] for name in HALVES)
        for reading in GRID_READINGS:
            cells = [_d(row, reading) for row in (rough, flat, single.iloc[-1])]
            more = bool(rough[f"d_low_{reading}"] > max(0, flat[f"d_high_{reading}"]))
            equal = against_zero(*single.iloc[-1][[f"d_low_{reading}", f"d_high_{reading}"]]) == "around"
            agree[reading] += [more, equal]
            table.append((around, reading, cells))
    return {
        "holds": {reading: judged(float(np.mean(cases))) for reading, cases in agree.items()},
        "table": table,
    }


def _d(row: pd.Series, reading: str) -> str:
    """Format d of a row with its interval."""
    return interval(*(row[f"d_{end}{reading}"] for end in ("", "low_", "high_")))


def uniform(grid: pd.DataFrame, patches: float) -> dict[str, Any]:
    """Compare what beta = gamma = delta = 0 keeps with the share alpha."""
    rows = grid[(grid[["beta", "gamma", "delta"]] == 0).all(axis=1)]
    near = len(rows) and bool((rows["n_S_percent"] - 100 * rows["alpha"]).abs().max() < 1)
    return {
        "holds": both(YES if near else NO),
        "patches": f"{patches:g}",
        "table": [
            [f"{row['alpha']:g}", share(100 * row["alpha"]), number(row["n_S_percent"], 1)]
            for _, row in rows.iterrows()
        ],
    }


def gather(gathering: pd.DataFrame) -> dict[str, Any]:
    """Compare the shares of the dots that are kept where the surface is roughest and where it is flattest."""
    rows, more = [], []
    for name, tenths in gathering.groupby("combination", sort=False):
        kept = tenths["kept_percent"]
        more.append(bool(kept.iloc[0] > kept.iloc[-1]))
        shares = (kept.iloc[0], kept.iloc[-1], tenths["uniform_percent"].iloc[0])
        rows.append([str(name), *(number(value, 1) for value in shares)])
    return {"holds": both(judged(float(np.mean(more)))), "table": rows}


def range_of_roughness(surface: dict[str, Any]) -> dict[str, Any]:
    """Check that every R lies between 0 and 1."""
    low, high = surface["roughness"]
    return {"holds": both(YES if low >= 0 and high <= 1 else NO), "found": [number(low), number(high)]}


def links(table: pd.DataFrame, signs: pd.DataFrame, grid: pd.DataFrame) -> dict[str, Any]:
    """Tabulate d of the published rows by linking distance, and what d depends on."""
    by = {k: rows.set_index("D_link") for k, rows in table.groupby("row")}
    distances = sorted(table["D_link"].unique())
    distances = distances[:: -(-len(distances) // MAX_LINK_COLUMNS)]
    return {
        "distances": [f"{x:g}" for x in distances],
        "table": [[k, *(number(rows["d"][x]) for x in distances)] for k, rows in by.items()],
        "best": [number(x, 1) for x in (signs["D_link_best"].min(), signs["D_link_best"].max())],
        "turned": int(signs["negative_from"].notna().sum()),
        "rows": len(signs),
        "correlation": number(replication.correlation_of_readings(grid)),
        "fragments": number(replication.correlation_with_fragments(grid)),
        "shattered": share(100 * replication.fragmented_share(grid)),
        "threshold": share(100 * replication.FRAGMENTED_BELOW),
    }


def defects(table: pd.DataFrame) -> list[tuple[str, list[str]]]:
    """Tabulate how n_S and d of the ten rows change, on average, with each defect of the published sampling corrected."""
    by = {str(name): rows.set_index("row") for name, rows in table.groupby("sampling", sort=False)}
    reference = by.pop("as published")
    columns = {"n_S_percent": 1} | {f"d_{reading}": 2 for reading in GRID_READINGS}
    return [
        (
            name,
            [number((rows[column] - reference[column]).mean(), digits) for column, digits in columns.items()],
        )
        for name, rows in by.items()
    ]


def bounded(row: Any) -> str:
    """Format n_S_percent of required_dots.csv: "all" if no fewer dots are enough, ≤ if the fewest that were tried are."""
    if row["bound"] == MORE:
        return "all"
    return ("≤ " if row["bound"] == AT_MOST else "") + share(row["n_S_percent"])


def outlook(required_dots: pd.DataFrame) -> dict[str, Any]:
    """Tabulate how many dots reach each noise floor, as they are and recovered."""
    by = required_dots.set_index(["floor", "reading"])
    floors = list(dict.fromkeys(required_dots["floor"]))
    return {
        "sampler": required_dots["sampler"].iloc[0],
        "table": [
            [
                floor,
                number(by.loc[(floor, WRITTEN_READING), "Z_floor"]),
                *(bounded(by.loc[(floor, r)]) for r in (WRITTEN_READING, RECOVERED)),
            ]
            for floor in floors
        ],
    }
