"""Page on samplers compared at equal n_S, on one surface or over several."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from sparsurf.patches.readings import WRITTEN_READING
from sparsurf.report.numbers import interval, number, share
from sparsurf.sampling.samplers import lookup_sampler
from sparsurf.study.comparison.measuring import DOTTED

TEMPLATE = "compare.html.j2"
MAIN_PERCENT = 10.0  # n_S of the answer, or the nearest that was measured
REFERENCE = "uniform"
MIN_FACTOR = 1.05  # times fewer dots, for a bound to be reported
AS_WRITTEN, RECOVERED = "Z as_written", "Z recovered"
MEASURES = (AS_WRITTEN, RECOVERED, "Z as_coded", "Z centres")  # that get a table each
BOUNDS = {"more than ": "> ", "less than ": "< ", "about ": "≈ "}


def comparison_page(
    name: str,
    table: pd.DataFrame,
    fewer: pd.DataFrame,
    pairs: pd.DataFrame | None = None,
    alone: pd.DataFrame | None = None,
    centres: pd.DataFrame | None = None,
    of: str | None = None,
    **facts: Any,
) -> dict[str, Any]:
    """Collect the values of the page.

    Parameters
    ----------
    name : str
        Of the surface, or of the run.
    table : DataFrame
        compare.csv of one surface, or of several (with `lowest` and `highest` instead of `low` and `high`).
    fewer : DataFrame
        How many times fewer dots a sampler needs than another for the same Z.
    pairs, alone : DataFrame, optional
        Differences between samplers with paired intervals; Z if nothing of the full surface is known.
    centres : DataFrame, optional
        centres.csv: d of the best combinations and of the always-kept centres.
    of : str, optional
        What was averaged, on a page over several surfaces.
    facts
        Further values of the template: n_dots, area, n_tests, draws, choices.
    """
    table, fewer = _rename_limits(table), _rename_limits(fewer)
    z, at, best = best_of(table)
    return {
        "name": name,
        "of": of,
        "at": f"{at:g}",
        "best": lookup_sampler(best).words,
        "best_Z": number(float(z[at][best])),
        "alike": [lookup_sampler(sampler).words for sampler in alike(pairs, best, at)]
        if pairs is not None
        else [],
        "recovered": recovered(table, at),
        "fewer": fewer_rows(fewer, at),
        "against": against(fewer, at),
        "percents": [f"{p:g}" for p in z.columns],
        "tables": {
            measure: rows_of(table, measure) for measure in MEASURES if measure in set(table["measure"])
        },
        "alone": alone_rows(_rename_limits(alone), at) if alone is not None else [],
        "centres": centre_rows(centres) if centres is not None else [],
        "Z_mean_descriptor": number(table["Z_mean_descriptor"].mean()),
        "facts": facts,
    }


def best_of(table: pd.DataFrame) -> tuple[pd.DataFrame, float, str]:
    """Return Z as written of every sampler, the n_S in % of the answer, and the sampler that is best there."""
    z = matrix(table, AS_WRITTEN)
    at = _main_column(z)
    return z, at, str(z[at].idxmin())


def _main_column(z: pd.DataFrame) -> Any:
    """Return the column nearest to MAIN_PERCENT."""
    return min(map(float, z.columns), key=lambda percent: abs(percent - MAIN_PERCENT))


def _rename_limits(table: pd.DataFrame) -> pd.DataFrame:
    """Name the limits low and high, whether they are of an interval or of several surfaces."""
    return table.rename(columns={"lowest": "low", "highest": "high"})


def matrix(table: pd.DataFrame, measure: str, value: str = "value") -> pd.DataFrame:
    """Pivot a measure: samplers in rows, requested n_S in columns."""
    rows = table[table["measure"] == measure]
    pivoted = rows.pivot(index="sampler", columns="percent", values=value)
    return pivoted.reindex(index=rows["sampler"].unique(), columns=rows["percent"].unique())


def rows_of(table: pd.DataFrame, measure: str) -> list[list[str]]:
    """Format a measure as rows, the best at MAIN_PERCENT first."""
    values = matrix(table, measure)
    values = values.sort_values(_main_column(values))
    return [
        [lookup_sampler(name).words, *map(number, row)]
        for name, row in zip(values.index, values.to_numpy(), strict=True)
    ]


def alike(pairs: pd.DataFrame, best: str, at: float) -> list[str]:
    """List the samplers whose Z does not differ significantly from that of the best, by the paired interval."""
    rows = pairs[(pairs["measure"] == AS_WRITTEN) & (pairs["percent"] == at)]
    rows = rows[(rows["low"] <= 0) & (rows["high"] >= 0)]
    names = [*rows.loc[rows["than"] == best, "sampler"], *rows.loc[rows["sampler"] == best, "than"]]
    return list(dict.fromkeys(names))


def recovered(table: pd.DataFrame, at: float) -> dict[str, str] | None:
    """Find the sampler from whose dots the surface is recovered best; None if that was not measured."""
    if RECOVERED not in set(table["measure"]):
        return None
    z = matrix(table, RECOVERED)[at]
    floor = table["Z_resampled"].mean() if "Z_resampled" in table else np.nan
    return {"sampler": lookup_sampler(str(z.idxmin())).words, "Z": number(z.min()), "floor": number(floor)}


def bounded(row: pd.Series) -> str:
    """Format a factor with its limits, or a bound with its sign."""
    text = BOUNDS.get(row["bound"], "") + number(row["factor"], 1)
    return text if row["bound"] else interval(row["factor"], row["low"], row["high"], 1)


def fewer_rows(fewer: pd.DataFrame, at: float) -> list[list[str]]:
    """Format a row per sampler: how many times fewer dots it needs than a uniform subset and than the paper's sampling."""
    rows = fewer[(fewer["measure"] == AS_WRITTEN) & (fewer["percent"] == at) & (fewer["use"] == "surface")]
    by = {(row["sampler"], row["than"]): bounded(row) for _, row in rows.iterrows()}
    names = dict.fromkeys(rows.sort_values("factor", ascending=False)["sampler"])
    return [
        [lookup_sampler(name).words, by.get((name, REFERENCE), ""), by.get((name, "paper"), "")]
        for name in names
    ]


def against(fewer: pd.DataFrame, at: float) -> str | None:
    """Format how many times fewer dots the farthest-point sampler needs than a uniform subset; None if not measured."""
    rows = fewer[(fewer["measure"] == AS_WRITTEN) & (fewer["percent"] == at) & (fewer["use"] == "surface")]
    rows = rows[(rows["sampler"] == "farthest") & (rows["than"] == REFERENCE)]
    rows = rows[~rows["bound"].astype(str).str.startswith("more") | (rows["factor"] >= MIN_FACTOR)]
    return None if rows.empty else bounded(rows.iloc[0])


def centre_rows(centres: pd.DataFrame) -> list[list[str]]:
    """Format a row per range of n_S: n_S in % and d of the best combination, and d of the centres."""
    rows = centres.dropna(subset="d")
    rows = rows[
        rows["reading"]
        == (WRITTEN_READING if WRITTEN_READING in set(rows["reading"]) else rows["reading"].iloc[0])
    ]
    return [
        [share(row["n_S_percent"])]
        + [interval(*(row[f"{key}{end}"] for end in ("", "_low", "_high"))) for key in ("d", "d_centres")]
        for _, row in rows.iterrows()
    ]


def alone_rows(alone: pd.DataFrame, at: float) -> list[list[str]]:
    """Format Z of subsets without the full surface, at one n_S and the middle linking distance."""
    scales = sorted(alone["scale"].unique())
    rows = alone[(alone["percent"] == at) & (alone["scale"] == scales[len(scales) // 2])].sort_values("Z")
    words = {name: lookup_sampler(name).words for name in rows["sampler"]} | {DOTTED: "sparsely placed dots"}
    return [
        [words[row["sampler"]], share(row["n_S_percent"]), interval(row["Z"], row["low"], row["high"])]
        for _, row in rows.iterrows()
    ]
