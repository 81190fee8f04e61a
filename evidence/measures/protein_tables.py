"""All tables of the study of many proteins, from the results of each protein."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from measures import over_proteins
from measures.studies import Measured
from sparsurf.patches.readings import CODED_READING, WRITTEN_READING
from sparsurf.recovery.readings import RECOVERED
from sparsurf.streams import stream
from sparsurf.study.relation import with_interval
from sparsurf.study.summary import Result, summary_table

SEED = 20261120
N_RANGES = 10
LOWEST_TARGET = 10.0  # %; recovered dots reach its Z below the smallest n_S measured: only a bound
WHOLE = "recovered_whole"  # table of the study that recovers surfaces for the whole grid


def tables_of(
    measured: list[Measured],
    summary: pd.DataFrame,
    relation: pd.DataFrame,
    surfaces: pd.DataFrame,
    recovered: Sequence[Measured] = (),
    whole: Sequence[Measured] = (),
) -> dict[str, pd.DataFrame]:
    """Compute every table, by name.

    Parameters
    ----------
    measured : list of studies.Measured
    summary, relation, surfaces : DataFrames of the same run
    recovered, whole : such lists of the proteins a quarter or all of whose grid was measured under `recovered`
    """
    results = [protein.result for protein in measured]
    curves, floors = (
        pd.concat(
            [table.assign(protein=protein.result.protein) for protein, table in tables], ignore_index=True
        )
        for tables in (
            [(protein, protein.by_n_s) for protein in measured],
            [(protein, protein.floors) for protein in measured],
        )
    )
    needed = over_proteins.needed(curves)
    quantities = quantities_of(summary, needed)
    found = {
        "d": over_proteins.d_by_range(summary),
        "plateaus": over_proteins.plateaus(results, summary),
        "needed_means": over_proteins.needed_means(needed),
        "by_n_s": over_proteins.recovered_means(curves, floors),
        "correlations": over_proteins.rank_correlations(quantities, surfaces),
        "power": pd.DataFrame(
            [
                over_proteins.power(int(n), stream(SEED, "power", int(n)))
                for n in sorted(relation["n_proteins"].unique())
            ]
        ),
    }
    covered = [coverage(results, quantities, curves, floors)]
    if recovered:
        found["recovered"], more = of_recovered([protein.result for protein in recovered])
        covered.append(more)
    if recovered and whole:
        found[WHOLE], more = of_whole_grid(
            *([protein.result for protein in measured_some] for measured_some in (whole, recovered))
        )
        covered.append(more)
    return found | {"coverage": pd.concat(covered, ignore_index=True)}


def of_recovered(results: list[Result]) -> tuple[pd.DataFrame, pd.DataFrame]:
    """For the proteins whose grid was recovered: d per range of n_S with the combination that is best on average and the
    protein on which the choice of all others does worst; and how often such an interval holds, a row of `coverage`."""
    summary = summary_table(results)
    best = over_proteins.plateaus(results, summary)
    chosen = best[["range", "n_combinations", "winner", "n_there", "n_held"]]
    worst = summary.sort_values("d_from_all").drop_duplicates("range")[["range", "protein", "d_from_all"]]
    chosen = chosen.merge(
        worst.rename(columns={"protein": "lowest_protein", "d_from_all": "lowest"}), on="range"
    )
    held = summary.groupby("protein")["d_cv"].mean()
    covered = _covered(f"cross-validated d, `{RECOVERED}`", held.to_numpy(), RECOVERED)
    return over_proteins.d_by_range(summary).merge(chosen, on="range", how="left"), covered


def _covered(words: str, values: np.ndarray, key: str) -> pd.DataFrame:
    """Compute how often the interval of a mean over that many proteins contains it, a row of `coverage`."""
    share = over_proteins.coverage_of_mean(values, stream(SEED, "coverage", key))
    return pd.DataFrame([{"quantity": words, "interval": "mean", "n": len(values), "coverage": share}])


def of_whole_grid(whole: list[Result], quarter: list[Result]) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the gain of the best of the whole recovered grid over the best of a quarter of it, on proteins that have both.

    Returns
    -------
    DataFrame: range (0: mean of a protein's ranges), n (proteins), and means over them: n_S_percent and
    n_S_percent_quarter, `whole` and `quarter`, cross-validated d of each protein's own best, and `gain`, the first less the
    second, with their intervals; and how often such an interval of the gain holds, a row of `coverage`
    """
    keys, columns = ["protein", "range"], ["n_S_percent", "d_cv"]
    tables = (summary_table(results).dropna(subset="d_cv")[keys + columns] for results in (whole, quarter))
    both = next(tables).merge(next(tables), on=keys, suffixes=("", "_quarter"))
    both = both.rename(columns={"d_cv": "whole", "d_cv_quarter": "quarter"})
    both["gain"] = both["whole"] - both["quarter"]
    rows = []
    for k, rows_of_range in [(0, both.groupby("protein").mean()), *both.groupby("range")]:
        row = {"range": k, "n": len(rows_of_range)} | {
            name: rows_of_range[name].mean() for name in ("n_S_percent", "n_S_percent_quarter")
        }
        for name in ("whole", "quarter", "gain"):
            row |= with_interval(name, rows_of_range[name])
        rows.append(row)
    gain = both.groupby("protein")["gain"].mean().to_numpy()
    return pd.DataFrame(rows), _covered(
        f"cross-validated d, `{RECOVERED}`, whole less a quarter of the grid", gain, WHOLE
    )


def quantities_of(summary: pd.DataFrame, needed: pd.DataFrame) -> dict[str, pd.Series]:
    """Return the numbers of each protein to correlate with its size and mean roughness: words -> Series by protein."""
    own = summary[summary["n_combinations"] > 0].groupby(["reading", "protein"])["d_cv"].mean()
    out = {f"cross-validated d, `{reading}`": own[reading] for reading in (CODED_READING, WRITTEN_READING)}
    for target, part in needed[needed["target"] > LOWEST_TARGET].groupby("target"):
        own = part[(part["sampler"] == "farthest") & (part["reading"] == RECOVERED)].set_index("protein")
        out[f"times fewer than {target:g} % uniform"] = own["factor"]
    return out


def coverage(
    results: list[Result], quantities: dict[str, pd.Series], curves: pd.DataFrame, floors: pd.DataFrame
) -> pd.DataFrame:
    """Compute how often intervals over that many proteins contain the truth, with the measured proteins as the population."""
    rng = stream(SEED, "coverage over proteins")
    means = {words: values for words, values in quantities.items() if words.startswith("cross-validated d, ")}
    means |= {f"ln of {words}": np.log(x) for words, x in quantities.items() if words.startswith("times")}
    for percent in (2.5, 10.0):
        relative = over_proteins.over_floor(curves, floors)
        relative = relative[
            (relative["sampler"] == "farthest")
            & (relative["reading"] == RECOVERED)
            & (relative["percent"] == percent)
        ]
        means[f"Z recovered from {percent:g} %, over fresh dots"] = relative["over_floor"]
    rows = [
        (words, "mean", len(values), over_proteins.coverage_of_mean(values.to_numpy(), rng))
        for words, values in means.items()
    ]
    for reading in (CODED_READING, WRITTEN_READING):
        for k in (2, 5):
            held = over_proteins.coverage_of_set(results, reading, k, N_RANGES, rng)
            rows.append((f"the best of range {k}, `{reading}`", "confidence set", len(results), held))
    return pd.DataFrame(rows, columns=["quantity", "interval", "n", "coverage"])
