"""What propensity and references are worth over many complexes: scores of each surface, means with intervals."""

from dataclasses import replace

import numpy as np
import pandas as pd
from scipy.stats import rankdata

from sparsurf import InputError
from sparsurf.molecules.conformations import superpose
from sparsurf.pairs.interface import gaps
from sparsurf.pairs.nearest import nearest
from sparsurf.pairs.neighbourhoods import SMOOTHING, smooth
from sparsurf.pairs.partners import baseline_scores
from sparsurf.pairs.ranking import auc
from sparsurf.study.statistics import mean_interval

BINS = 10  # of roughness, in which a patch's expected distance is a mean
FEWEST_COMMON = 10  # residues that two forms must share to be laid on each other


def laid_on(molecule, reference, fewest=FEWEST_COMMON):
    """Another form of a protein, moved onto it by the C-alpha atoms of the residues that both have.

    Parameters
    ----------
    molecule, reference : molecules.Molecule
    fewest : int, residues that both must have

    Returns
    -------
    Molecule, of one frame

    Raises
    ------
    InputError : the two share hardly a residue
    """
    places = [
        {(m.chain[i], m.residue[i]): i for i in np.flatnonzero(m.name == "CA")} for m in (molecule, reference)
    ]
    common = [key for key in places[0] if key in places[1]]
    if len(common) < fewest:
        raise InputError(
            f"the two forms share {len(common)} residues by chain and number, but need {fewest} to be laid on "
            "each other: number their residues alike."
        )
    mine, theirs = ([each[key] for key in common] for each in places)
    first = molecule.frame(0)
    moved = superpose(first.xyz, np.array(mine), reference.xyz[0][theirs])
    return replace(first, xyz=moved)


def carried_labels(points, bound_points, bound_labels):
    """Interface of another form: each dot (N, 3) takes the label of the bound dot nearest to it, (N,) bool."""
    return bound_labels[gaps(points, bound_points)[1]]


def relative(values, roughness, bins=BINS):
    """Values less what is expected of patches that flat: the mean of their bin of roughness.

    Parameters
    ----------
    values, roughness : (n,) float64
    bins : int, of equally many patches

    Returns
    -------
    (n,) float64
    """
    rank = rankdata(roughness, method="ordinal").astype(int) - 1  # floats from newer versions of SciPy
    place = rank * bins // len(rank)
    return values - (np.bincount(place, values) / np.bincount(place))[place]


def together(*scores):
    """Mean of the ranks of several scores, (n,): what each says counts alike whatever its scale."""
    return np.mean([rankdata(score) for score in scores], axis=0)


def distance_scores(partner, centres, near, k_values, smoothing=SMOOTHING):
    """Scores from the distances to the nearest patches: raw and smoothed, plain and relative to flatness.

    Parameters
    ----------
    partner : partners.Partner
    centres : (n,) int
    near : complementarity.Nearest
    k_values : sequence of int, at most as many as `near` holds

    Returns
    -------
    dict, (k, 'plain' or 'relative', 'raw' or 'smoothed') -> (n,) float64, the higher the likelier interface
    """
    points, out = partner.surface.points, {}
    for k in k_values:
        values = near.distance[:, :k].mean(axis=1)
        for kind, map_ in (("plain", values), ("relative", relative(values, partner.roughness[centres]))):
            out[k, kind, "raw"] = -map_
            out[k, kind, "smoothed"] = -smooth(points[centres], np.arange(len(centres)), map_, smoothing)
    return out


def scores_of_pair(pair, centres, up, down, k_values, name, threads=1):
    """Every variant of the propensity on both sides of a pair.

    Parameters
    ----------
    pair : two `partners.Partner`
    centres : two (n,) int
    up, down : two (n, M) float64 each, descriptors at the centres
    k_values : sequence of int
    name : str, of the descriptor, such as 'published, 6 Å'

    Returns
    -------
    two dicts, (name, 'complementarity' or 'similarity', k, kind, smoothing) -> score (n,)
    """
    most = max(k_values)
    found = {
        "complementarity": nearest(up[0], down[1], most, threads),
        "similarity": nearest(up[0], up[1], most, threads),
    }
    out = ({}, {})
    for what, sides in found.items():
        for side in (0, 1):
            scores = distance_scores(pair[side], centres[side], sides[side], k_values)
            out[side].update({(name, what, *key): score for key, score in scores.items()})
    return out


def combinations(partner, centres, propensity, threads=1):
    """Reference values and their combinations with a propensity score (n,): dict, name -> (n,) float64."""
    plain = baseline_scores(partner, centres, threads)
    out = dict(plain)
    if {"hydropathy", "protrusion"} <= set(plain) and not np.isnan(plain["hydropathy"]).any():
        water, out_of = plain["hydropathy"], plain["protrusion"]
        out["hydropathy + protrusion"] = together(water, out_of)
        out["propensity + hydropathy"] = together(propensity, water)
        out["propensity + protrusion"] = together(propensity, out_of)
        out["propensity + hydropathy + protrusion"] = together(propensity, water, out_of)
    return out


def areas(scores, labels):
    """Area under the ROC curve of each score: dict, key -> float; NaN where a score is not known everywhere."""
    return {key: np.nan if np.isnan(score).any() else auc(score, labels) for key, score in scores.items()}


def mean_and_interval(values):
    """Mean of some complexes with its 95 % interval by Student's t: (mean, low, high, n); NaN do not count."""
    values = np.asarray(values, np.float64)
    values = values[~np.isnan(values)]
    return *mean_interval(values), len(values)


def means_over_complexes(table, by, value="auc"):
    """Means over complexes; the two sides of one are averaged first, since they share its interface.

    Parameters
    ----------
    table : DataFrame with `complex`, the columns `by` and `value`
    by : list of str

    Returns
    -------
    DataFrame: `by` in the order of first appearance, mean, low, high (95 %), complexes
    """
    each = table.groupby([*by, "complex"], sort=False, dropna=False)[value].mean().reset_index()
    rows = [
        (*(key if isinstance(key, tuple) else (key,)), *mean_and_interval(group[value]))
        for key, group in each.groupby(by, sort=False, dropna=False)
    ]
    return pd.DataFrame(rows, columns=[*by, "mean", "low", "high", "complexes"])


def chosen_on_few(table, by, few):
    """Variants chosen on some complexes and reported on the others.

    Parameters
    ----------
    table : DataFrame with `complex`, the columns `by` and `auc`
    by : list of str, what makes a variant
    few : collection of str, complexes to choose on

    Returns
    -------
    DataFrame, best first by the mean over `few`: `by`, chosen_on (its mean), then mean, low, high, complexes over
    all others
    """
    inside = table["complex"].isin(few)
    first = means_over_complexes(table[inside], by)[[*by, "mean"]].rename(columns={"mean": "chosen_on"})
    merged = first.merge(means_over_complexes(table[~inside], by), on=by)
    return merged.sort_values("chosen_on", ascending=False, kind="stable").reset_index(drop=True)
