"""The study with one of its rules changed at a time: which claim rests on which rule."""

from dataclasses import replace

import numpy as np
import pandas as pd

from sparsurf.patches.descriptors import DESCRIPTORS, Descriptor
from sparsurf.patches.zernike import polynomials, published
from sparsurf.recovery.readings import RECOVERED
from sparsurf.sampling.combination import split, texts_of
from sparsurf.study.floors import FRESH
from sparsurf.study.over_proteins import needed, with_interval
from sparsurf.study.protein_scores import FEW_TESTS, Counts, Rules

DEFAULT = "as it is"
HYDROGENS = "hydrogens kept"
SHORT = "published, n <= 10"  # a descriptor of lower order, for this study only
COUNTS = Counts(draws=3, tests=FEW_TESTS, draws_by_n_s=1, samplers=("uniform", "farthest"))
VARIANTS = {
    DEFAULT: {},
    "R_patch 3 Å": {"R_patch": 3.0},
    "R_patch 6 Å": {"R_patch": 6.0},
    "R_zernike 4 Å": {"R_zernike": 4.0},
    "R_zernike 9 Å": {"R_zernike": 9.0},
    "D_link 0.7 Å": {"D_link": 0.7},
    "D_link 1 Å": {"D_link": 1.0},
    "10 dots per Å^2": {"density": 10.0},
    "probe 1.2 Å": {"probe_radius": 1.2},
    "probe 1.8 Å": {"probe_radius": 1.8},
    "dots as DMS places them": {"reentrant": "dms"},
    SHORT: {"descriptor": SHORT},
    "steady": {"descriptor": "steady"},
    HYDROGENS: {},
}


def rules_of(variant):
    """`Rules` of a variant."""
    return replace(Rules(), **VARIANTS[variant])


def enter_short_descriptor():
    """Make the published descriptor up to order 10 known under the name `SHORT`."""
    columns = np.flatnonzero([polynomials.indices()[place][0] <= 10 for place in published.order()])
    order = np.argsort(np.argsort(published.order()[columns]))

    def describe(*given):
        return np.ascontiguousarray(published.describe(*given)[:, columns])

    DESCRIPTORS[SHORT] = Descriptor(len(columns), lambda: order, describe)


def claims(measured):
    """The numbers that the claims of the study rest on, of one protein under one variant.

    Parameters
    ----------
    measured : Result, floors, table by n_S, single values; see `protein_files.load`

    Returns
    -------
    dict: d_kept, d_surface, d held out of the best (mean of the ranges of n_S); over_floor, Z of the surface recovered from
    10 % farthest-point dots over that of fresh dots; factor, times fewer farthest-point dots, recovered, than uniform ones
    as they are at 25 %
    """
    result, floors, by_n_s = measured[:3]
    out = {
        f"d_{reading}": part["d_held_out"].mean()
        for reading, part in result.ranges.groupby("islands", sort=False)
    }
    line = by_n_s[(by_n_s["sampler"] == "farthest") & (by_n_s["islands"] == RECOVERED)].set_index("percent")
    out["over_floor"] = line.loc[10.0, "Z"] / floors.set_index("floor").loc[FRESH, "Z"]
    rows = needed(by_n_s.assign(protein=result.protein)).set_index(["target", "sampler", "islands"])
    return out | {"factor": rows.loc[(25.0, "farthest", RECOVERED), "factor"]}


def table(measured):
    """Claims by variant over the proteins, with what changed against the unvaried rules, protein by protein.

    Parameters
    ----------
    measured : dict of variant to list of what `protein_files.load` returns

    Returns
    -------
    DataFrame: variant, claim, n, value and change (`value` less that of `DEFAULT` on the same proteins) with their 95 %
    intervals over proteins; claim `held`: share of the ranges of n_S under `kept` in whose confidence set of the best the
    unvaried rules' winner lies
    """
    known = {each[0].protein: each for each in measured[DEFAULT]}
    rows = []
    for variant, some in measured.items():
        pairs = [(each, known[each[0].protein]) for each in some if each[0].protein in known]
        found = [claims(each) | {"held": held(each, old)} for each, old in pairs]
        before = [claims(old) | {"held": held(old, old)} for _, old in pairs]
        for claim in found[0] if found else ():
            values, old = (np.array([one[claim] for one in each]) for each in (found, before))
            row = {"variant": variant, "claim": claim, "n": len(values)}
            row |= with_interval("value", values) | with_interval("change", values - old)
            if claim == "held":  # a share
                row |= {key: min(max(row[key], 0.0), 1.0) for key in ("value_low", "value_high")}
            rows.append(row)
    return pd.DataFrame(rows)


def held(measured, reference, reading="kept"):
    """Share of the ranges of n_S whose confidence set of the best holds the winner that the reference has there."""
    mine, theirs = (
        each[0].ranges[each[0].ranges["islands"] == reading].reset_index(drop=True)
        for each in (measured, reference)
    )
    both = (mine["n_combinations"] > 0) & (theirs["n_combinations"] > 0)
    winners, sets = texts_of(theirs[both]), mine["best_set"][both]
    return np.mean([text in split(field) for text, field in zip(winners, sets, strict=True)])
