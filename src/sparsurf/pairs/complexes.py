"""Scores of the surfaces of complexes, by propensity and baselines, and their means over many complexes."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import rankdata

from sparsurf import InputError
from sparsurf.molecules.conformations import BACKBONE, determines_rotation, superpose
from sparsurf.molecules.molecule import Molecule
from sparsurf.pairs.interface import gaps
from sparsurf.pairs.nearest import Nearest, nearest
from sparsurf.pairs.neighbourhoods import SMOOTHING, smooth
from sparsurf.pairs.partners import Partner, baseline_scores
from sparsurf.pairs.ranking import auc
from sparsurf.study.statistics import mean_interval

N_BINS = 10  # of roughness, over which the expected distance of a patch is averaged
MIN_COMMON_RESIDUES = 10  # that two forms must share to be superposed


def superpose_onto(
    molecule: Molecule, reference: Molecule, min_common: int = MIN_COMMON_RESIDUES
) -> Molecule:
    """Superpose one form of a protein onto another by the C-alpha atoms of common residues.

    If these lie on a line, common atoms of the backbone are used, and then all common atoms.

    Parameters
    ----------
    molecule, reference : Molecule
    min_common : int, minimum number of common residues

    Returns
    -------
    Molecule, of one frame

    Raises
    ------
    InputError : the two share fewer residues than `min_common`, or all their atoms lie on a line
    """
    choices = [_common_atoms(molecule, reference, names) for names in (("CA",), BACKBONE, None)]
    if len(common := choices[0][0]) < min_common:
        raise InputError(
            f"the two forms share {len(common)} residues by chain and number, but need {min_common} to be "
            "superposed: use the same residue numbers in both."
        )
    first = molecule.frame(0)
    for moving, fixed in choices:
        if determines_rotation(first.xyz, moving, reference.xyz[0][fixed]):
            return replace(first, xyz=superpose(first.xyz, moving, reference.xyz[0][fixed]))
    raise InputError(
        "the atoms that the two forms share lie on a line, or one form is a mirror image, so that several "
        "superpositions fit equally well: use forms with more atoms in common."
    )


def _common_atoms(
    molecule: Molecule, reference: Molecule, names: Collection[str] | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return indices of the atoms that both molecules have, of some names or of all."""
    atoms = [
        {
            (m.chain[i], m.residue[i], m.name[i]): i
            for i in (range(m.n_atoms) if names is None else np.flatnonzero(np.isin(m.name, list(names))))
        }
        for m in (molecule, reference)
    ]
    common = [key for key in atoms[0] if key in atoms[1]]
    moving, fixed = (np.array([atom_of[key] for key in common], int) for atom_of in atoms)
    return moving, fixed


def carried_labels(points: np.ndarray, bound_points: np.ndarray, bound_labels: np.ndarray) -> np.ndarray:
    """Transfer the interface to another form: each dot takes the label of the nearest bound dot.

    Parameters
    ----------
    points, bound_points : (N, 3) and (M, 3) float64, Å
    bound_labels : (M,) bool

    Returns
    -------
    (N,) bool
    """
    return bound_labels[gaps(points, bound_points)[1]]


def relative(values: np.ndarray, roughness: np.ndarray, bins: int = N_BINS) -> np.ndarray:
    """Subtract the value expected from the roughness, which is the mean over patches of similar roughness.

    Parameters
    ----------
    values, roughness : (n,) float64
    bins : int, number of bins of roughness with equal numbers of patches

    Returns
    -------
    (n,) float64
    """
    rank = rankdata(roughness, method="ordinal").astype(int) - 1  # floats from newer versions of SciPy
    bin_of = rank * bins // len(rank)
    return values - (np.bincount(bin_of, values) / np.bincount(bin_of))[bin_of]


def mean_rank(*scores: np.ndarray) -> np.ndarray:
    """Average the ranks of several scores (n,), which weights them equally whatever their scales."""
    return np.mean([rankdata(score) for score in scores], axis=0)


def distance_scores(
    partner: Partner,
    centres: np.ndarray,
    near: Nearest,
    k_values: Sequence[int],
    smoothing: float = SMOOTHING,
) -> dict[tuple[int, str, str], np.ndarray]:
    """Score centres by the distances to the nearest patches: raw and smoothed, plain and relative to roughness.

    Parameters
    ----------
    partner : partners.Partner
    centres : (n,) int
    near : Nearest
    k_values : sequence of int, at most as many as `near` holds

    Returns
    -------
    dict, (k, 'plain' or 'relative', 'raw' or 'smoothed') -> (n,) float64; higher values indicate an interface
    """
    points, scores = partner.surface.points, {}
    for k in k_values:
        values = near.distance[:, :k].mean(axis=1)
        for kind, map_ in (("plain", values), ("relative", relative(values, partner.roughness[centres]))):
            smoothed = smooth(points[centres], np.arange(len(centres)), map_, smoothing)
            scores[k, kind, "raw"], scores[k, kind, "smoothed"] = -map_, -smoothed
    return scores


def scores_of_pair(
    pair: Sequence[Partner],
    centres: Sequence[np.ndarray],
    up: Sequence[np.ndarray],
    down: Sequence[np.ndarray],
    k_values: Sequence[int],
    name: str,
    threads: int = 1,
) -> tuple[dict[tuple, np.ndarray], dict[tuple, np.ndarray]]:
    """Compute every variant of the propensity on both sides of a pair.

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
    k = max(k_values)
    matches = {
        "complementarity": nearest(up[0], down[1], k, threads),
        "similarity": nearest(up[0], up[1], k, threads),
    }
    out: tuple[dict[tuple, np.ndarray], dict[tuple, np.ndarray]] = ({}, {})
    for what, sides in matches.items():
        for side in (0, 1):
            scores = distance_scores(pair[side], centres[side], sides[side], k_values)
            out[side].update({(name, what, *key): score for key, score in scores.items()})
    return out


def combinations(
    partner: Partner, centres: np.ndarray, propensity: np.ndarray, threads: int = 1
) -> dict[str, np.ndarray]:
    """Compute the baselines and their combinations with a propensity score.

    Parameters
    ----------
    partner : Partner
    centres : (n,) int
    propensity : (n,) float64
    threads : int

    Returns
    -------
    dict, name -> (n,) float64
    """
    scores = baseline_scores(partner, centres, threads)
    if {"hydropathy", "protrusion"} <= set(scores) and not np.isnan(scores["hydropathy"]).any():
        hydropathy, protrusion = scores["hydropathy"], scores["protrusion"]
        scores["hydropathy + protrusion"] = mean_rank(hydropathy, protrusion)
        scores["propensity + hydropathy"] = mean_rank(propensity, hydropathy)
        scores["propensity + protrusion"] = mean_rank(propensity, protrusion)
        all_three = mean_rank(propensity, hydropathy, protrusion)
        scores["propensity + hydropathy + protrusion"] = all_three
    return scores


def areas(scores: Mapping[Any, np.ndarray], labels: np.ndarray) -> dict[Any, float]:
    """Compute the area under the ROC curve of each score; NaN for a score with unknown values."""
    return {key: np.nan if np.isnan(score).any() else auc(score, labels) for key, score in scores.items()}


def mean_and_interval(values: np.ndarray | pd.Series) -> tuple[float, float, float, int]:
    """Compute the mean over complexes and its 95 % interval, (mean, low, high, n), without NaN."""
    known = np.asarray(values, np.float64)
    known = known[~np.isnan(known)]
    mean, low, high = mean_interval(known)
    return mean, low, high, len(known)


def means_over_complexes(table: pd.DataFrame, by: list[str], value: str = "auc") -> pd.DataFrame:
    """Average over complexes; the two sides of a complex are averaged first, since they share its interface.

    Parameters
    ----------
    table : DataFrame with `complex`, the columns `by` and `value`
    by : list of str
    value : str

    Returns
    -------
    DataFrame: `by` in the order of first appearance, mean, low, high (95 %), complexes
    """
    of_complex = table.groupby([*by, "complex"], sort=False, dropna=False)[value].mean().reset_index()
    rows = [
        (*(key if isinstance(key, tuple) else (key,)), *mean_and_interval(group[value]))
        for key, group in of_complex.groupby(by, sort=False, dropna=False)
    ]
    return pd.DataFrame(rows, columns=[*by, "mean", "low", "high", "complexes"])


def chosen_on_few(table: pd.DataFrame, by: list[str], few: Collection[str]) -> pd.DataFrame:
    """Rank variants on some complexes and evaluate them on the others.

    Parameters
    ----------
    table : DataFrame with `complex`, the columns `by` and `auc`
    by : list of str, columns that identify a variant
    few : collection of str, complexes on which variants are ranked

    Returns
    -------
    DataFrame, best first by the mean over `few`: `by`, chosen_on (its mean), then mean, low, high, complexes over
    all others
    """
    inside = table["complex"].isin(few)
    first = means_over_complexes(table[inside], by)[[*by, "mean"]].rename(columns={"mean": "chosen_on"})
    merged = first.merge(means_over_complexes(table[~inside], by), on=by)
    return merged.sort_values("chosen_on", ascending=False, kind="stable").reset_index(drop=True)
