"""Values of the page on the paper: whether each claim holds under each reading, and the numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from sparsurf.paper import replication
from sparsurf.paper.published_runs import MEASURES
from sparsurf.patches.readings import FULL_READING, GRID_READINGS, KEPT_READING
from sparsurf.report.numbers import against_zero
from sparsurf.sampling.combination import (
    PARAMETERS,
    PUBLISHED_ROWS,
    TABLE_1,
    Combination,
    combination_labels,
    split_combinations,
)
from sparsurf.study.rough_and_flat import MIN_TEST_DOTS

if TYPE_CHECKING:
    from sparsurf.study.prepared_surface import PreparedSurface

TEMPLATE = "paper.html.j2"
YES, NO, PARTLY = "yes", "no", "in part"
MIN_P = 0.05  # below it, the published values do not look like those of another run
NEGLIGIBLE_SHARE = 0.05  # of the combinations, too few to change a verdict
PUBLISHED_BEST = (1, 0, 6, 0)  # at alpha = 1
PUBLISHED_D = 2.69  # of that combination
MAX_LINK_COLUMNS = 6
HALVES = ("rougher half", "flatter half")
FIGURES = {  # number in the paper: file in the surface's figures, and chapter with its numbers
    1: ("roughness", "range_of_roughness"),
    2: ("number_of_dots", "span"),
    3: ("d_over_grid", "best"),
    4: ("rough_and_flat", "rough"),
    5: ("subsets", "gather"),
}


def paper_page(data: dict[str, Any]) -> dict[str, Any]:
    """Collect the values of the page.

    `data` holds `grid`, `ranges`, `best` and `required_dots` of the surface; `rows`, `links`, `signs`, `defects`, `family` and
    `gathering` of `paper.replication`; `places`, `tests` and `bias` of `paper.published_runs`; `bins` of
    `rough_and_flat.bins_table` with a column `around`; `uniform`, the median number of patches of a dot; and `surface`, see
    `surface_of`.
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
    prepared: PreparedSurface, rules: dict[str, Any], path_to_surface: str | None = None
) -> dict[str, Any]:
    """Describe the dots: how they were generated, and their numbers."""
    source = "file" if path_to_surface else rules["reentrant"]
    return {
        "source": source,
        "n_dots": len(prepared.points),
        "n_centres": len(prepared.cover.centre),
        "mean_roughness": float(prepared.roughness.mean()),
        "roughness": (float(prepared.roughness.min()), float(prepared.roughness.max())),
    }


def judged(agree: float, several: bool = False) -> str:
    """Judge a share of cases as yes, no or in part; with `several`, a few cases do not count."""
    few = NEGLIGIBLE_SHARE if several else 0
    return YES if agree >= 1 - few else NO if agree <= few else PARTLY


def both(holds: bool) -> dict[str, str]:
    """Return the same answer for both readings."""
    return dict.fromkeys(GRID_READINGS, YES if holds else NO)


def span_of(grid: pd.DataFrame) -> dict[str, Any]:
    """Compare the range of n_S of the grid with the published one."""
    measured = grid["n_S_percent"].min(), grid["n_S_percent"].max()
    published = TABLE_1["n_S_low_percent"][0], TABLE_1["n_S_high_percent"][-1]
    return {"holds": both(np.abs(np.subtract(measured, published)).max() < 0.2), "measured": measured}


def table1(
    places: pd.DataFrame, tests: pd.DataFrame, rows: pd.DataFrame, bias: pd.DataFrame
) -> dict[str, Any]:
    """Compare Table I with runs made as published, under both binnings, and with the other reading."""
    agree = tests.loc[tests["measure"] == "together", "p"] >= MIN_P
    written = rows["d_published"].between(rows[f"d_low_{FULL_READING}"], rows[f"d_high_{FULL_READING}"])
    coded = {
        name: rows[f"{name}_published"].between(
            rows[f"{name}_low_{KEPT_READING}"], rows[f"{name}_high_{KEPT_READING}"]
        )
        for name in MEASURES
    }
    runs = places[places["binning"] == "half-open"]
    d = rows[f"d_{FULL_READING}"]
    return {
        "holds": {KEPT_READING: judged(float(agree.mean())), FULL_READING: judged(written.mean())},
        "runs": int(runs["n_runs"].max()),
        "tests": [
            row | {"outside": outside_of(places, row["binning"], row["measure"])}
            for row in tests.to_dict("records")
        ],
        "d_full": (d.min(), d.max()),
        "bias": bias[bias["binning"] == "closed"]["d_bias"].mean(),
        "inside": {name: int(inside.sum()) for name, inside in coded.items()},
        "rows": [
            row | run for row, run in zip(rows.to_dict("records"), runs.to_dict("records"), strict=True)
        ],
    }


def outside_of(places: pd.DataFrame, binning: str, name: str) -> list[int] | None:
    """List the rows (from 1) whose published value lies outside all runs; None for measures that have no rows."""
    if name not in MEASURES:
        return None
    runs = places[places["binning"] == binning]
    low, high, published = (runs[f"{name}_{key}"] for key in ("lowest", "highest", "published"))
    return runs.loc[(published < low) | (published > high), "range"].tolist()


def winners(ranges: pd.DataFrame, places: pd.DataFrame) -> dict[str, Any]:
    """Compare our winner of each range with the published one, and count how often that won the runs."""
    runs = places[places["binning"] == "half-open"]
    table = runs[["range", "n_won", "n_runs"]].reset_index(drop=True)
    table["published"] = [str(Combination(*row)) for row in PUBLISHED_ROWS]
    same, among = {}, {}
    for reading in GRID_READINGS:
        rows = ranges[ranges["reading"] == reading].reset_index(drop=True)
        table[reading] = pd.Series(combination_labels(rows))
        same[reading] = int((table[reading] == table["published"]).sum())
        sets = rows["best_set"].map(split_combinations)
        among[reading] = sum(text in best for text, best in zip(table["published"], sets, strict=False))
    return {
        "holds": {reading: judged(among[reading] / len(table)) for reading in GRID_READINGS},
        "same": same,
        "among": among,
        "rows": table.dropna().to_dict("records"),
    }


def best_at_one(best: dict[str, Any], grid: pd.DataFrame) -> dict[str, Any]:
    """Compare the best combination at the largest alpha with the published one."""
    published = grid[np.isclose(grid[PARAMETERS], PUBLISHED_BEST).all(axis=1)]
    ours = {reading: best[reading]["unrestricted"] for reading in GRID_READINGS}
    holds: dict[str, str] = {}
    for reading, row in ours.items():
        among = str(Combination(*PUBLISHED_BEST)) in split_combinations(row["best_set"])
        low, high = (published[f"d_{end}_{reading}"] for end in ("low", "high"))
        inside = (low <= PUBLISHED_D).all() and (high >= PUBLISHED_D).all()
        holds[reading] = NO if not among else YES if inside else PARTLY
    return {"holds": holds, "ours": ours, "published": published.iloc[0] if len(published) else None}


def positive(grid: pd.DataFrame, family: pd.DataFrame) -> dict[str, Any]:
    """Count the combinations in which the sampling beats a uniform subset, also with alpha tuned to the same n_S."""
    holds, loses, counts = {}, {}, {}
    for reading in GRID_READINGS:
        d, low, high = (grid[f"{key}_{reading}"] for key in ("d", "d_low", "d_high"))
        holds[reading] = judged((low > 0).mean(), several=True)
        loses[reading] = bool((high < 0).mean() > 0.5)
        counts[reading] = {
            "above_0": int((d > 0).sum()),
            "above": int((low > 0).sum()),
            "below": int((high < 0).sum()),
            "mean": d.mean(),
            "largest": d.max(),
        }
    return {
        "holds": holds,
        "loses": loses,
        "n": len(grid),
        "counts": counts,
        "members": int(family["members"].sum()),
        "better": int(family["n_better"].sum()),
        "family": family.to_dict("records"),
    }


def describe(grid: pd.DataFrame, rows: pd.DataFrame, null: float) -> dict[str, Any]:
    """Count the combinations in which a subset describes a patch worse than the mean patch does."""
    worse = {
        reading: [table[f"Z_tS_{reading}"] > null for table in (grid, rows)] for reading in GRID_READINGS
    }
    return {
        "holds": {
            reading: judged(1 - of_grid.mean(), several=True) for reading, (of_grid, _) in worse.items()
        },
        "null": null,
        "counts": {reading: [int(of.sum()) for of in both_tables] for reading, both_tables in worse.items()},
        "n": (len(grid), len(rows)),
    }


def rough_and_flat(bins: pd.DataFrame) -> dict[str, Any]:
    """Compare d in rough and flat patches, around kept dots (as in the paper) and around any dots."""
    agree: dict[str, list[bool]] = {reading: [] for reading in GRID_READINGS}
    table = {}
    for around, rows in bins.groupby("around", sort=False):
        flattest = rows[~rows["bin"].isin(HALVES) & (rows["n"] >= MIN_TEST_DOTS)].iloc[-1]
        rough, flat = (rows[rows["bin"] == name].iloc[0] for name in HALVES)
        table[str(around)] = [rough, flat, flattest]
        for reading in GRID_READINGS:
            more = bool(rough[f"d_low_{reading}"] > max(0, flat[f"d_high_{reading}"]))
            equal = against_zero(flattest[f"d_low_{reading}"], flattest[f"d_high_{reading}"]) == "around"
            agree[reading] += [more, equal]
    return {
        "holds": {reading: judged(float(np.mean(cases))) for reading, cases in agree.items()},
        "table": table,
    }


def uniform(grid: pd.DataFrame, patches: float) -> dict[str, Any]:
    """Compare what beta = gamma = delta = 0 keeps with the share alpha."""
    rows = grid[(grid[["beta", "gamma", "delta"]] == 0).all(axis=1)]
    near = len(rows) and (rows["n_S_percent"] - 100 * rows["alpha"]).abs().max() < 1
    return {"holds": both(bool(near)), "patches": patches, "rows": rows.to_dict("records")}


def gather(gathering: pd.DataFrame) -> dict[str, Any]:
    """Compare the shares of the dots that are kept where the surface is roughest and where it is flattest."""
    groups = gathering.groupby("combination", sort=False)
    rows = groups["kept_percent"].agg(roughest="first", flattest="last")
    rows["all"] = groups["uniform_percent"].first()
    more = (rows["roughest"] > rows["flattest"]).mean()
    return {
        "holds": dict.fromkeys(GRID_READINGS, judged(float(more))),
        "rows": rows.reset_index().to_dict("records"),
    }


def range_of_roughness(surface: dict[str, Any]) -> dict[str, Any]:
    """Check that every R lies between 0 and 1."""
    low, high = surface["roughness"]
    return {"holds": both(low >= 0 and high <= 1), "measured": (low, high)}


def links(table: pd.DataFrame, signs: pd.DataFrame, grid: pd.DataFrame) -> dict[str, Any]:
    """Tabulate d of the published rows by linking distance, and what d depends on."""
    d = table.pivot(index="row", columns="D_link", values="d")
    d = d.iloc[:, :: -(-d.shape[1] // MAX_LINK_COLUMNS)]
    return {
        "d": d.to_dict("index"),
        "distances": d.columns.tolist(),
        "best": (signs["D_link_best"].min(), signs["D_link_best"].max()),
        "turned": int(signs["negative_from"].notna().sum()),
        "rows": len(signs),
        "correlation": replication.correlation_of_readings(grid),
        "fragments": replication.correlation_with_fragments(grid),
        "fragmented_percent": 100 * replication.fragmented_share(grid),
        "threshold_percent": 100 * replication.FRAGMENTED_BELOW,
    }


def defects(table: pd.DataFrame) -> dict[str, dict[Any, float]]:
    """Average over the ten rows how n_S and d change with each defect of the published sampling corrected."""
    columns = ["n_S_percent", *(f"d_{reading}" for reading in GRID_READINGS)]
    by = {str(name): rows.set_index("row")[columns] for name, rows in table.groupby("sampling", sort=False)}
    reference = by.pop("as published")
    return {name: (rows - reference).mean().to_dict() for name, rows in by.items()}


def outlook(required_dots: pd.DataFrame) -> dict[str, Any]:
    """Tabulate how many dots reach each noise floor, by floor and reading."""
    by_floor = {
        floor: rows.set_index("reading").to_dict("index")
        for floor, rows in required_dots.groupby("floor", sort=False)
    }
    return {"sampler": required_dots["sampler"].iloc[0], "floors": by_floor}
