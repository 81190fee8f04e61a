"""All tables of the study of many proteins, from the results of each protein."""

from collections.abc import Sequence

import pandas as pd

from measures import over_proteins
from measures.studies import Measured
from sparsurf.patches.readings import FULL_READING, KEPT_READING
from sparsurf.recovery.readings import RECOVERED
from sparsurf.streams import stream
from sparsurf_study.analysis.summary import SurfaceResult, summary_table

SEED = 20261120
LOWEST_TARGET = 10.0  # %; recovered dots reach its Z below the smallest n_S measured: only a bound


def tables_of(
    measured: list[Measured],
    summary: pd.DataFrame,
    relation: pd.DataFrame,
    surfaces: pd.DataFrame,
    recovered: Sequence[Measured] = (),
) -> dict[str, pd.DataFrame]:
    """Compute every table, by name.

    Parameters
    ----------
    measured : list of studies.Measured
    summary, relation, surfaces : DataFrames of the same run
    recovered : such a list of the proteins a quarter of whose grid was measured under `recovered`
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
    if recovered:
        found["recovered"] = of_recovered([protein.result for protein in recovered])
    return found


def of_recovered(results: list[SurfaceResult]) -> pd.DataFrame:
    """Return d per range of n_S for the proteins whose grid was recovered, with the combination that is best on average and the
    protein on which the choice of all others does worst."""
    summary = summary_table(results)
    best = over_proteins.plateaus(results, summary)
    chosen = best[["range", "n_combinations", "winner", "n_there", "n_held"]]
    worst = summary.sort_values("d_from_all").drop_duplicates("range")[["range", "protein", "d_from_all"]]
    chosen = chosen.merge(
        worst.rename(columns={"protein": "lowest_protein", "d_from_all": "lowest"}), on="range"
    )
    return over_proteins.d_by_range(summary).merge(chosen, on="range", how="left")


def quantities_of(summary: pd.DataFrame, needed: pd.DataFrame) -> dict[str, pd.Series]:
    """Return the numbers of each protein to correlate with its size and mean roughness: words -> Series by protein."""
    own = summary[summary["n_combinations"] > 0].groupby(["reading", "protein"])["d_cv"].mean()
    out = {f"cross-validated d, `{reading}`": own[reading] for reading in (KEPT_READING, FULL_READING)}
    for target, part in needed[needed["target"] > LOWEST_TARGET].groupby("target"):
        own = part[(part["sampler"] == "farthest") & (part["reading"] == RECOVERED)].set_index("protein")
        out[f"times fewer than {target:g} % random"] = own["factor"]
    return out
