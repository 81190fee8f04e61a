"""Evaluate a comparison of samplers: dots needed for the same Z, differences, and means over proteins.

All samplers share their test dots, whose contributions cancel in differences between samplers.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from sparsurf.study.comparison.measuring import USE
from sparsurf.study.required_dots import smallest_n_s
from sparsurf.study.statistics import CONFIDENCE_LEVEL, estimate

REFERENCE = "uniform"  # sampler with which the others are compared
# A factor is a bound if `smallest_n_s` returns 0 or inf, an n_S outside the measured ones
BOUND = {0.0: "more than ", np.inf: "less than "}
Z_MEASURES = ("Z as_written", "Z centres")  # the Z of each use at which numbers of dots are compared
BASELINES = (REFERENCE, "farthest")  # samplers with which the others are compared, next to the best
FACTOR_COLUMNS = ["use", "measure", "than", "sampler", "percent", "factor", "low", "high", "bound"]
N_BOOTSTRAP = 400  # samples of test dots and draws
KEYS = ["sampler", "percent", "use", "measure"]


def dots_needed(table: pd.DataFrame, measure: str = "Z as_written") -> pd.DataFrame:
    """Compute the number of dots that each sampler needs for the Z that another one reaches.

    Parameters
    ----------
    table : DataFrame
        See `measuring.compare_samplers`.
    measure : str

    Returns
    -------
    DataFrame, one row per sampler and requested n_S: use, measure, sampler, percent, Z (reached there), and for each sampler
    the n_S in % that reaches the same Z, by interpolation of ln Z over ln n_S. 0 stands for fewer dots than the smallest
    measured n_S, inf for more than the largest.
    """
    part = table[table["measure"] == measure]
    curves = {
        str(name): rows.sort_values("n_S_percent")[["n_S_percent", "value"]].to_numpy().T
        for name, rows in part.groupby("sampler", sort=False)
    }
    rows = [
        {**{key: row[key] for key in ("use", "measure", "sampler", "percent")}, "Z": row["value"]}
        | {name: smallest_n_s(row["value"], *curve) for name, curve in curves.items()}
        for _, row in part.iterrows()
    ]
    return pd.DataFrame(rows)


def dots_needed_for_all_uses(table: pd.DataFrame) -> pd.DataFrame:
    """Compute `dots_needed` for both uses, as the surface and as centres."""
    return pd.concat([dots_needed(table, measure) for measure in Z_MEASURES], ignore_index=True)


def measured_ranges(table: pd.DataFrame, measure: str = "Z as_written") -> dict[str, tuple[float, float]]:
    """Return the smallest and the largest measured n_S in % of each sampler."""
    by_sampler = table[table["measure"] == measure].groupby("sampler")["n_S_percent"]
    return {str(name): (n_s.min(), n_s.max()) for name, n_s in by_sampler}


def factor_with_bound(
    row: Mapping[Any, Any], sampler: str, ends: Mapping[str, tuple[float, float]]
) -> tuple[float, str]:
    """Compute the factor by which a sampler needs fewer dots than that of a row, for the same Z.

    Parameters
    ----------
    row : dict
        A row of `dots_needed`.
    sampler : str
    ends : dict
        See `measured_ranges`.

    Returns
    -------
    float, and '' or, if the n_S lies outside the measured ones, 'more than ' or 'less than '.
    """
    n_s, n_s_of_sampler = row[row["sampler"]], row[sampler]
    return float(n_s / np.clip(n_s_of_sampler, *ends[sampler])), BOUND.get(n_s_of_sampler, "")


def paired_differences(
    raw: Mapping[tuple[str, str], np.ndarray],
    percents: Sequence[float],
    measures: Sequence[str] = ("Z as_written", "Z scaled", "Z centres"),
    against: Sequence[str] = BASELINES,
) -> pd.DataFrame:
    """Estimate differences of Z between samplers.

    Parameters
    ----------
    raw : dict
        (sampler, measure) -> (P, D, T), see `measuring.compare_samplers`.
    percents : sequence of float
    measures, against : sequences of str

    Returns
    -------
    DataFrame: measure, than, sampler, percent, difference (sampler - than, negative if the sampler is better), low and high
    (its 95 % interval)
    """
    rows = []
    for measure in measures:
        names = [name for name, raw_measure in raw if raw_measure == measure]
        for than in [name for name in against if name in names]:
            for name in [name for name in names if name != than]:
                mean = estimate(raw[name, measure] - raw[than, measure])
                columns = {"measure": measure, "than": than, "sampler": name, "percent": percents}
                rows.append(
                    pd.DataFrame(columns | {"difference": mean.mean, "low": mean.low, "high": mean.high})
                )
    return pd.concat(rows, ignore_index=True) if rows else pd.DataFrame()


def factor_intervals(
    raw: Mapping[tuple[str, str], np.ndarray],
    table: pd.DataFrame,
    rng: np.random.Generator,
    against: Sequence[str] = (REFERENCE, "paper"),
    resampled: int = N_BOOTSTRAP,
) -> pd.DataFrame:
    """Compute factors by which samplers need fewer dots than others for the same Z, with 95 % bootstrap intervals.

    The test dots, shared by all samplers, and the draws of each sampler are resampled with replacement.

    Parameters
    ----------
    raw : dict
        See `paired_differences`.
    table : DataFrame
        See `measuring.compare_samplers`: n_S_percent of every sampler.
    rng : numpy.random.Generator
    against : sequence of str
    resampled : int
        Number of bootstrap samples.

    Returns
    -------
    DataFrame: use, measure, than, sampler, percent (of `than`), factor, low, high, bound; no rows for a missing measure.
    An n_S outside the measured ones is replaced by the nearest measured one. The factor is then a bound ('more than ' or
    'less than '), and so is the limit on that side. If all bootstrap samples are at the bound, low and high are NaN.
    """
    rows = []
    for measure in Z_MEASURES:
        names = [name for name, raw_measure in raw if raw_measure == measure]
        if not names:
            continue
        n_s = table[table["measure"] == measure].pivot(
            index="sampler", columns="percent", values="n_S_percent"
        )
        curves = dict(zip(names, _resampled_curves(raw, measure, names, rng, resampled), strict=True))
        for than in [name for name in against if name in names]:
            for name in [name for name in names if name != than]:
                n_s_than, n_s_name = n_s.loc[than].to_numpy(float), n_s.loc[name].to_numpy(float)
                for p, percent in enumerate(n_s.columns):
                    pairs = zip(curves[than], curves[name], strict=True)
                    needed = [smallest_n_s(a[p], n_s_name, b) for a, b in pairs]
                    factors = n_s_than[p] / np.clip(needed, n_s_name[0], n_s_name[-1])
                    low, high = np.quantile(
                        factors[1:], [(1 - CONFIDENCE_LEVEL) / 2, (1 + CONFIDENCE_LEVEL) / 2]
                    )
                    bound = BOUND.get(needed[0], "")
                    if bound and low == high:
                        low = high = np.nan
                    row = {
                        "use": USE[measure],
                        "measure": measure,
                        "than": than,
                        "sampler": name,
                        "percent": percent,
                    }
                    row |= {"factor": factors[0], "low": low, "high": high, "bound": bound}
                    rows.append(row)
    return pd.DataFrame(rows, columns=FACTOR_COLUMNS)


def _resampled_curves(
    raw: Mapping[tuple[str, str], np.ndarray],
    measure: str,
    names: Sequence[str],
    rng: np.random.Generator,
    resampled: int,
) -> Iterator[np.ndarray]:
    """Yield curves, (1 + resampled, P), of each sampler, first as measured; all samplers share the resampled test dots."""
    n_tests = raw[names[0], measure].shape[2]
    tests: list[np.ndarray] = [np.arange(n_tests)]
    tests += [rng.integers(0, n_tests, size=(n_tests,)) for _ in range(resampled)]
    for name in names:
        x = raw[name, measure]
        draws: list[np.ndarray] = [np.arange(x.shape[1])]
        draws += [rng.integers(0, x.shape[1], size=(x.shape[1],)) for _ in range(resampled)]
        yield np.array([x[:, d][:, :, t].mean(axis=(1, 2)) for d, t in zip(draws, tests, strict=True)])


def means_by_protein(tables: Mapping[tuple[str, str], pd.DataFrame]) -> dict[str, pd.DataFrame]:
    """Average over the conformations of each protein.

    Parameters
    ----------
    tables : dict
        (protein, conformation) -> table of `measuring.compare_samplers`.

    Returns
    -------
    dict, name -> table; if there is only one protein, its conformations are kept separate.
    """
    names = list(dict.fromkeys(protein for protein, _ in tables))
    if len(names) == 1:
        return {f"{protein}/{conformation}": table for (protein, conformation), table in tables.items()}
    out = {}
    for name in names:
        of_protein = pd.concat([table for (protein, _), table in tables.items() if protein == name])
        out[name] = of_protein.groupby(KEYS, sort=False).mean(numeric_only=True).reset_index()
    return out


def means_over_proteins(units: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Compute means and spread over proteins.

    Parameters
    ----------
    units : dict
        See `means_by_protein`.

    Returns
    -------
    DataFrame, one row per sampler, requested n_S and measure: n_S_percent, value, sd, lowest, highest over the
    proteins; the same for the ratio to the uniform subset of the same protein (NaN if not measured); n (number of proteins, or
    of conformations of a single protein); means of Z_mean_descriptor, Z_empty and, if measured, Z_resampled and
    Z_turned.
    """
    rows = pd.concat([table.assign(unit=name) for name, table in units.items()])
    reference = rows[rows["sampler"] == REFERENCE].set_index(["unit", "percent", "measure"])["value"]
    keys = pd.MultiIndex.from_frame(rows[["unit", "percent", "measure"]])
    with np.errstate(divide="ignore", invalid="ignore"):
        rows["ratio"] = rows["value"].to_numpy() / reference.reindex(keys).to_numpy()
    groups = rows.groupby(KEYS, sort=False)
    out = groups[["n_S_percent"]].mean()
    for name in ("value", "ratio"):
        spread = groups[name].agg(["mean", "std", "min", "max"])
        prefix = "" if name == "value" else "ratio_"
        out[[name, f"{prefix}sd", f"{prefix}lowest", f"{prefix}highest"]] = spread
    out["n"] = groups["value"].size()
    references = [key for key in ("Z_mean_descriptor", "Z_empty", "Z_resampled", "Z_turned") if key in rows]
    out[references] = groups[references].mean()
    return out.reset_index()


def factors_over_proteins(units: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Compute factors by which samplers need fewer dots than the uniform one and than the paper's.

    Parameters
    ----------
    units : dict
        See `means_by_protein`.

    Returns
    -------
    DataFrame: use, measure, than, sampler, percent (of `than`), factor (geometric mean over the proteins), lowest,
    highest, n, and bound: 'more than ' or 'less than ' if the factor of any protein is a bound, 'about ' if there are bounds
    of both kinds.
    """
    rows = []
    for measure in Z_MEASURES:
        for table in units.values():
            need, ends = dots_needed(table, measure), measured_ranges(table, measure)
            for row in need[need["sampler"].isin([REFERENCE, "paper"])].to_dict("records"):
                for name in need["sampler"].unique():
                    if name != row["sampler"]:
                        key = (row["use"], measure, row["sampler"], name, row["percent"])
                        rows.append((*key, *factor_with_bound(row, name, ends)))
    keys = ["use", "measure", "than", "sampler", "percent"]
    groups = pd.DataFrame(rows, columns=[*keys, "factor", "bound"]).groupby(keys, sort=False)
    out = groups["factor"].agg(
        factor=lambda x: np.exp(np.mean(np.log(x))), lowest="min", highest="max", n="size"
    )
    out["bound"] = groups["bound"].agg(_joint_bound)
    return out.reset_index()


def _joint_bound(bounds: pd.Series) -> str:
    """Return the bound of a mean of factors from their own bounds."""
    kinds = set(bounds) - {""}
    return "about " if len(kinds) > 1 else "".join(kinds)
