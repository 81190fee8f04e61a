import numpy as np
import pandas as pd

from measures.over_proteins import needed, with_interval
from measures.studies import Measured
from sparsurf.recovery.readings import RECOVERED
from sparsurf.sampling.combination import combination_labels, split_combinations
from sparsurf.study.floors import FRESH

DEFAULT = "as it is"


def claims(measured: Measured) -> dict[str, float]:
    """Return the numbers that the claims of the study rest on, of one protein under one variant.

    Parameters
    ----------
    measured : studies.Measured

    Returns
    -------
    dict: d_as_coded, d_as_written, cross-validated d of the best (mean of the ranges); over_floor, Z of the surface recovered
    from 10 % farthest-point dots over that of fresh dots; factor, times fewer farthest-point dots, recovered, than uniform ones
    as they are at 25 %
    """
    result, floors, by_n_s = measured
    out = {
        f"d_{reading}": part["d_cv"].mean() for reading, part in result.ranges.groupby("reading", sort=False)
    }
    line = by_n_s[(by_n_s["sampler"] == "farthest") & (by_n_s["reading"] == RECOVERED)].set_index("percent")
    out["over_floor"] = line.loc[10.0, "Z"] / floors.set_index("floor").loc[FRESH, "Z"]
    rows = needed(by_n_s.assign(protein=result.protein)).set_index(["target", "sampler", "reading"])
    return out | {"factor": rows.loc[(25.0, "farthest", RECOVERED), "factor"]}


def table(measured: dict[str, list[Measured]]) -> pd.DataFrame:
    """Return claims by variant over the proteins, with what changed against the unvaried rules, protein by protein.

    Parameters
    ----------
    measured : dict of variant to list of studies.Measured

    Returns
    -------
    DataFrame: variant, claim, n, value and change (`value` less that of `DEFAULT` on the same proteins) with their 95 %
    intervals over proteins; claim `held`: share of the ranges of n_S under `as_coded` in whose confidence set of the best the
    unvaried rules' winner lies
    """
    known = {protein.result.protein: protein for protein in measured[DEFAULT]}
    rows = []
    for variant, studied in measured.items():
        pairs = [
            (protein, known[protein.result.protein]) for protein in studied if protein.result.protein in known
        ]
        changed = [claims(protein) | {"held": held(protein, old)} for protein, old in pairs]
        before = [claims(old) | {"held": held(old, old)} for _, old in pairs]
        for claim in changed[0] if changed else ():
            values, old = (np.array([one[claim] for one in protein]) for protein in (changed, before))
            row = {"variant": variant, "claim": claim, "n": len(values)}
            row |= with_interval("value", values) | with_interval("change", values - old)
            if claim == "held":  # a share
                row |= {key: min(max(row[key], 0.0), 1.0) for key in ("value_low", "value_high")}
            rows.append(row)
    return pd.DataFrame(rows)


def held(measured: Measured, reference: Measured, reading: str = "as_coded") -> float:
    """Return the share of the ranges of n_S whose confidence set of the best holds the winner that the reference has there."""
    ranges, reference_ranges = (
        study.result.ranges[study.result.ranges["reading"] == reading].reset_index(drop=True)
        for study in (measured, reference)
    )
    both = (ranges["n_combinations"] > 0) & (reference_ranges["n_combinations"] > 0)
    winners, sets = combination_labels(reference_ranges[both]), ranges["best_set"][both]
    return np.mean([text in split_combinations(field) for text, field in zip(winners, sets, strict=True)])
