"""Values of the page on samplers compared at equal n_S, on one surface or over several."""

from __future__ import annotations

from typing import Any

import pandas as pd

from sparsurf.sampling.samplers import sampler_label
from sparsurf.study.comparison.measuring import DOTTED

TEMPLATE = "compare.html.j2"
MAIN_PERCENT = 10.0  # n_S of the answer, or the nearest that was measured
REFERENCE = "uniform"
MIN_FACTOR = 1.05  # times fewer dots: a smaller bound is not reported
AS_WRITTEN, RECOVERED = "Z as_written", "Z recovered"
MEASURES = (AS_WRITTEN, RECOVERED, "Z as_coded", "Z centres")  # with a table each


def comparison_page(
    name: str,
    table: pd.DataFrame,
    fewer: pd.DataFrame,
    pairs: pd.DataFrame | None = None,
    alone: pd.DataFrame | None = None,
    of: str | None = None,
    **facts: Any,
) -> dict[str, Any]:
    """Collect the values of the page.

    Parameters
    ----------
    name : str
        Name of the surface or of the run.
    table : DataFrame
        compare.csv of one surface, or of several (with `lowest` and `highest` instead of `low` and `high`).
    fewer : DataFrame
        Factors by which samplers need fewer dots than others for the same Z.
    pairs, alone : DataFrame, optional
        Differences between samplers with paired intervals; Z without the full surface.
    of : str, optional
        What was averaged, on a page over several surfaces.
    facts
        Further values of the template: n_dots, area, estimated, n_tests, draws, of_paper, n.
    """
    table, fewer = _rename_limits(table), _rename_limits(fewer)
    z, at, best = best_of(table)
    fewer = fewer[(fewer["measure"] == AS_WRITTEN) & (fewer["percent"] == at) & (fewer["use"] == "surface")]
    alone = None if alone is None else _rename_limits(alone)
    names = {*table["sampler"], *fewer["sampler"], *([] if alone is None else alone["sampler"])}
    return {
        "name": name,
        "of": of,
        "at": at,
        "best": best,
        "best_Z": float(z[at][best]),
        "alike": alike(pairs, best, at) if pairs is not None else [],
        "called": {name: sampler_label(name) for name in names} | {DOTTED: "sparsely placed dots"},
        "recovered": recovered(table, at),
        "fewer": fewer_dots(fewer),
        "against": against(fewer),
        "percents": z.columns.tolist(),
        "tables": {measure: by_z(table, measure) for measure in MEASURES if measure in set(table["measure"])},
        "alone": [] if alone is None else alone_rows(alone, at),
        "Z_mean_descriptor": table["Z_mean_descriptor"].mean(),
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


def by_z(table: pd.DataFrame, measure: str) -> dict[Any, list[float]]:
    """Return the values of each sampler, the best at MAIN_PERCENT first."""
    values = matrix(table, measure)
    return values.sort_values(_main_column(values)).T.to_dict("list")


def alike(pairs: pd.DataFrame, best: str, at: float) -> list[str]:
    """List the samplers whose Z does not differ significantly from that of the best, by the paired interval."""
    rows = pairs[(pairs["measure"] == AS_WRITTEN) & (pairs["percent"] == at)]
    rows = rows[(rows["low"] <= 0) & (rows["high"] >= 0)]
    names = [*rows.loc[rows["than"] == best, "sampler"], *rows.loc[rows["sampler"] == best, "than"]]
    return list(dict.fromkeys(names))


def recovered(table: pd.DataFrame, at: float) -> dict[str, Any] | None:
    """Find the sampler from whose dots the surface is recovered best; None if that was not measured."""
    if RECOVERED not in set(table["measure"]):
        return None
    z = matrix(table, RECOVERED)[at]
    floor = float(table["Z_resampled"].mean()) if "Z_resampled" in table else None
    return {"sampler": str(z.idxmin()), "Z": z.min(), "floor": floor}


def fewer_dots(fewer: pd.DataFrame) -> dict[str, dict[Any, Any]]:
    """Return the factor of each sampler, the largest first, by the sampler with which it is compared."""
    rows = fewer.sort_values("factor", ascending=False)
    return {
        str(name): group.set_index("than").to_dict("index")
        for name, group in rows.groupby("sampler", sort=False)
    }


def against(fewer: pd.DataFrame) -> dict[Any, Any] | None:
    """Return the factor of the farthest-point sampler over a uniform subset; None if not measured."""
    rows = fewer[(fewer["sampler"] == "farthest") & (fewer["than"] == REFERENCE)]
    rows = rows[~rows["bound"].astype(str).str.startswith("more") | (rows["factor"] >= MIN_FACTOR)]
    return None if rows.empty else rows.iloc[0].to_dict()


def alone_rows(alone: pd.DataFrame, at: float) -> list[dict[Any, Any]]:
    """Select Z of subsets without the full surface, at one n_S and the middle linking distance."""
    scales = sorted(alone["scale"].unique())
    rows = alone[(alone["percent"] == at) & (alone["scale"] == scales[len(scales) // 2])]
    return rows.sort_values("Z").to_dict("records")
