"""The paper's page: claim by claim, what the paper says, whether it holds under each reading, and the numbers."""

import numpy as np

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

TEMPLATE = "paper.html.j2"
YES, NO, PARTLY = "yes", "no", "in part"
UNLIKELY = 0.05  # p below which published values are not taken for those of one more run
FEW = 0.05  # share of the combinations that makes a claim hold in part
BEST = (1, 0, 6, 0)  # the published best at alpha = 1
LINKS = 6  # linking distances that get a column, at most
HALVES = ("rougher half", "flatter half")


def paper_page(data):
    """What the template asks for.

    Parameters
    ----------
    data : dict
        DataFrames: `grid` and `ranges` of the surface, `rows` (`replication.published_rows`), `places`, `tests` and
        `bias` (`published_runs`), `links` and `signs` (`replication.sweep_links`, `sign_changes`), `defects`, `bins`
        (`rough_and_flat.bins_table`, with a column `around`), `family` (`replication.best_of_family`), `enough`
        (`enough.enough_dots`). `best` (dict), `uniform` (dict: median number of patches of a dot), `surface`
        (dict, see `surface_of`).
    """
    grid, null = data["grid"], data["best"]["references"]["null_model"]
    chapters = {
        "span": span_of(grid),
        "table1": table1(data["places"], data["tests"], data["rows"], data["bias"]),
        "winners": winners(data["ranges"], data["places"]),
        "best": best_at_one(data["best"], grid),
        "positive": positive(grid, data["family"]),
        "describe": describe(grid, data["rows"], null),
        "rough": rough_and_flat(data["bins"]),
        "uniform": uniform(grid, data["uniform"]["median"]),
    }
    return chapters | {
        "claims": [(name, chapter["holds"]) for name, chapter in chapters.items()],
        "readings": GRID_READINGS,
        "surface": data["surface"],
        "links": links(data["links"], data["signs"], grid),
        "defects": defects(data["defects"]),
        "outlook": outlook(data["enough"]),
    }


def surface_of(evaluator, rules, path_to_surface=None):
    """Which dots the page is about: how they were made, and their numbers beside the paper's A1."""
    source = "file" if path_to_surface else "program" if rules["method"] == "dms" else rules["reentrant"]
    rows = [
        ("dots", f"{len(evaluator.points):,}", "20,045"),
        ("centres of patches", f"{len(evaluator.cover.centre):,}", "181"),
        ("mean roughness", number(evaluator.roughness.mean(), 4), "0.6263"),
    ]
    return {"source": source, "rows": rows}


def judged(agree, several=False):
    """Yes, no or in part, of a share of cases; with `several`, a few cases do not count."""
    few = FEW if several else 0
    return YES if agree >= 1 - few else NO if agree <= few else PARTLY


def both(holds):
    """The same answer under both readings."""
    return dict.fromkeys(GRID_READINGS, holds)


def span_of(grid):
    """The range of n_S of the grid."""
    found = grid["n_S_percent"].min(), grid["n_S_percent"].max()
    said = TABLE_1["n_S_low_percent"][0], TABLE_1["n_S_high_percent"][-1]
    near = np.abs(np.subtract(found, said)).max() < 0.2
    return {
        "holds": both(YES if near else NO),
        "found": [number(x) for x in found],
        "said": [number(x) for x in said],
    }


def table1(places, tests, rows, bias):
    """Table I against runs made as published, under both binnings, and against the other reading."""
    agree = tests.loc[tests["measure"] == "together", "p"] >= UNLIKELY
    d, low, high = (rows[f"{key}_{WRITTEN_READING}"] for key in ("d", "d_low", "d_high"))
    inside = (low <= rows["d_published"]) & (rows["d_published"] <= high)
    own = places[places["binning"] == "half-open"]
    of_bias = bias[bias["binning"] == "closed"]["d_bias"]
    return {
        "holds": {CODED_READING: judged(np.mean(agree)), WRITTEN_READING: judged(inside.mean())},
        "runs": int(own["n_runs"].max()),
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
        "table": [
            [
                f"{row['range']}",
                combination(row),
                number(row["d_published"]),
                interval(row["d_mean"], row["d_lowest"], row["d_highest"]),
                number(row["Z_tS_published"]),
                interval(row["Z_tS_mean"], row["Z_tS_lowest"], row["Z_tS_highest"]),
                interval(*text),
            ]
            for (_, row), text in zip(own.iterrows(), zip(d, low, high, strict=True), strict=True)
        ],
    }


def outside_of(places, binning, name):
    """Rows (from 1) whose published value lies outside of all runs, as text; of other measures nothing is known of rows."""
    if name not in MEASURES:
        return ""
    own = places[places["binning"] == binning]
    low, high, said = (own[f"{name}_{key}"] for key in ("lowest", "highest", "published"))
    return ", ".join(map(str, own.loc[(said < low) | (said > high), "range"])) or "none"


def p_text(p):
    """A probability, never as 0."""
    return "< 0.0001" if p < 0.0001 else f"{p:.2g}"


def winners(ranges, places):
    """Our winner of each range beside the published one, and how often that won the runs."""
    published = [str(Combination(*row)) for row in PUBLISHED_ROWS]
    found, same, among = {}, {}, {}
    for reading in GRID_READINGS:
        own = ranges[ranges["reading"] == reading]
        found[reading] = combination_labels(own)
        same[reading] = sum(a == b for a, b in zip(found[reading], published, strict=False))
        among[reading] = sum(b in split_combinations(field) for field, b in zip(own["best_set"], published, strict=False))
    runs = places[places["binning"] == "half-open"]
    return {
        "holds": {reading: judged(among[reading] / len(published)) for reading in GRID_READINGS},
        "same": same,
        "among": among,
        "rows": len(published),
        "table": [
            [k, said, *own, f"{won} of {n}"]
            for k, (said, *own, won, n) in enumerate(
                zip(published, *found.values(), runs["n_won"], runs["n_runs"], strict=False), 1
            )
        ],
    }


def best_at_one(best, grid):
    """The best combination at the largest alpha, and d of the published one."""
    said = grid[np.isclose(grid[PARAMETERS], BEST).all(axis=1)]
    holds, table = {}, []
    for reading in GRID_READINGS:
        row = best[reading]["unrestricted"]
        holds[reading] = YES if str(Combination(*BEST)) in split_combinations(row["best_set"]) else NO
        ends = (
            [said[f"{key}_{reading}"].iloc[0] for key in ("d", "d_low", "d_high")]
            if len(said)
            else [np.nan] * 3
        )
        own = interval(row["d_held_out"], row["d_held_out_low"], row["d_held_out_high"])
        table.append((reading, [combination(row), own, int(row["n_best_set"]), interval(*ends)]))
    return {"holds": holds, "table": table}


def positive(grid, family):
    """In how many combinations the sampling beats a uniform subset, and with alpha tuned to the same n_S."""
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


def describe(grid, rows, null):
    """In how many combinations a subset tells less of a patch than the mean patch."""
    holds, table = {}, []
    for reading in GRID_READINGS:
        worse, of_rows = (each[f"Z_tS_{reading}"] > null for each in (grid, rows))
        holds[reading] = judged(1 - worse.mean(), several=True)
        table.append((reading, [int(worse.sum()), len(grid), int(of_rows.sum()), len(rows)]))
    return {"holds": holds, "null": number(null), "table": table}


def rough_and_flat(bins):
    """d in rough and flat patches, around kept dots (as the paper has them) and around any dots."""
    agree, table = {reading: [] for reading in GRID_READINGS}, []
    for around, own in bins.groupby("around", sort=False):
        single = own[~own["bin"].isin(HALVES) & (own["n"] >= MIN_TEST_DOTS)]
        rough, flat = (own[own["bin"] == name].iloc[0] for name in HALVES)
        for reading in GRID_READINGS:
            cells = [_d(row, reading) for row in (rough, flat, single.iloc[-1])]
            more = bool(rough[f"d_low_{reading}"] > max(0, flat[f"d_high_{reading}"]))
            equal = against_zero(*single.iloc[-1][[f"d_low_{reading}", f"d_high_{reading}"]]) == "around"
            agree[reading] += [more, equal]
            table.append((around, reading, cells))
    return {"holds": {reading: judged(np.mean(each)) for reading, each in agree.items()}, "table": table}


def _d(row, reading):
    return interval(*(row[f"d_{end}{reading}"] for end in ("", "low_", "high_")))


def uniform(grid, patches):
    """What beta = gamma = delta = 0 keeps, beside the share alpha."""
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


def links(table, signs, grid):
    """d of the published rows by linking distance, and what d rests on."""
    by = {k: own.set_index("D_link") for k, own in table.groupby("row")}
    distances = sorted(table["D_link"].unique())
    distances = distances[:: -(-len(distances) // LINKS)]
    return {
        "distances": [f"{x:g}" for x in distances],
        "table": [[k, *(number(own.loc[x, "d"]) for x in distances)] for k, own in by.items()],
        "best": [number(x, 1) for x in (signs["D_link_best"].min(), signs["D_link_best"].max())],
        "turned": int(signs["negative_from"].notna().sum()),
        "rows": len(signs),
        "correlation": number(replication.correlation_of_readings(grid)),
        "fragments": number(replication.correlation_with_fragments(grid)),
        "shattered": share(100 * replication.fragmented_share(grid)),
        "threshold": share(100 * replication.FRAGMENTED_BELOW),
    }


def defects(table):
    """How n_S and d of the ten rows change, on average, with each defect of the published sampling corrected."""
    by = {name: own.set_index("row") for name, own in table.groupby("sampling", sort=False)}
    reference = by.pop("as published")
    columns = {"n_S_percent": 1} | {f"d_{reading}": 2 for reading in GRID_READINGS}
    return [
        (
            name,
            [number((own[column] - reference[column]).mean(), digits) for column, digits in columns.items()],
        )
        for name, own in by.items()
    ]


def bounded(row):
    """n_S_percent of a row of enough.csv: "all" where no fewer dots are enough, ≤ where the fewest that were tried are."""
    if row["bound"] == MORE:
        return "all"
    return ("≤ " if row["bound"] == AT_MOST else "") + share(row["n_S_percent"])


def outlook(enough):
    """How many dots reach each noise floor, as they are and recovered."""
    by = enough.set_index(["floor", "reading"])
    floors = list(dict.fromkeys(enough["floor"]))
    return {
        "sampler": enough["sampler"].iloc[0],
        "table": [
            [
                floor,
                number(by.loc[(floor, WRITTEN_READING), "Z_floor"]),
                *(bounded(by.loc[(floor, r)]) for r in (WRITTEN_READING, RECOVERED)),
            ]
            for floor in floors
        ],
    }
