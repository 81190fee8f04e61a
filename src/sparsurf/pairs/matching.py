"""Two partners matched: distance maps, where they agree with the interface, tables per dot, residue and pair of patches."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd

from sparsurf.pairs.interface import INTERFACE, gaps, native_pairs
from sparsurf.pairs.nearest import Nearest, nearest
from sparsurf.pairs.neighbourhoods import SMOOTHING, smooth
from sparsurf.pairs.partners import baseline_scores
from sparsurf.pairs.ranking import blocks_of_residues, bootstrap_auc
from sparsurf.patches.descriptors import PUBLISHED, describe
from sparsurf.patches.index import R_ZERNIKE
from sparsurf.streams import stream

AREAS = ["partner", "score", "auc", "low", "high", "dots", "interface", "blocks"]  # columns of `agreement`
CONTACTS = ["against", "auc", "low", "high", "pairs"]  # columns of `contacts`
MOST_PAIRS = 100  # rows of the table of best-matching patches
APART = 6.0  # Å, between two rows of that table on one side at least
MOST_CONTACTS = 500  # native pairs that are compared


class Recipe(NamedTuple):
    """How patches become numbers.

    descriptor : str, of `patches.descriptors`
    radius : float, R_zernike in Å
    """

    descriptor: str = PUBLISHED
    radius: float = R_ZERNIKE


RECIPE = Recipe()  # as published


@dataclass(frozen=True, eq=False)
class Match:
    """Nearest patches of two partners at their centres.

    partners : the two `partners.Partner`
    centres : two (n,) int, dots at which there are descriptors
    complementary, similar : two `Nearest` each, first 'up' against second 'down', and both 'up'
    """

    partners: tuple
    centres: tuple
    complementary: tuple[Nearest, Nearest]
    similar: tuple[Nearest, Nearest]


def descriptors_at(partner, places, up, recipe=RECIPE, threads=1):
    """Descriptors of the patches around some places (n, 3) in Å, (n, M), and the number of dots in each patch."""
    return describe(partner.index, places, recipe.radius, up, threads, recipe.descriptor)


def match(first, second, centres=(None, None), k=1, recipe=RECIPE, threads=1):
    """Compare all patches of two partners, first 'up' with second 'down' and both 'up'.

    Parameters
    ----------
    first, second : partners.Partner
    centres : two (n,) int or None for all dots
    k : int
        How many nearest patches are kept of each.
    recipe : Recipe
    threads : int

    Returns
    -------
    Match; a centre whose patch has one dot is left out, since its empty descriptor matches any other empty one.
    """
    both = (first, second)
    centres = [
        np.arange(len(each.surface)) if dots is None else np.sort(dots)
        for each, dots in zip(both, centres, strict=True)
    ]
    found = [
        descriptors_at(each, each.surface.points[dots], True, recipe, threads)
        for each, dots in zip(both, centres, strict=True)
    ]
    centres = tuple(dots[sizes > 1] for dots, (_, sizes) in zip(centres, found, strict=True))
    up = [z[sizes > 1] for z, sizes in found]
    down, _ = descriptors_at(second, second.surface.points[centres[1]], False, recipe, threads)
    return Match(both, centres, nearest(up[0], down, k, threads), nearest(up[0], up[1], k, threads))


def maps(match_, side, smoothing=SMOOTHING, threads=1):
    """Distance maps of one side on all its dots.

    Parameters
    ----------
    match_ : Match
    side : 0 or 1
    smoothing : float, Å

    Returns
    -------
    DataFrame, a row per dot: `propensity` and `similarity`, the distance to the nearest patch of the partner, and
    `propensity_k`, the mean of the k nearest (NaN where no patch was cut); the same with `_smoothed`; `match`, the
    partner's dot with the nearest patch (-1).
    """
    points, centres = match_.partners[side].surface.points, match_.centres[side]
    near = match_.complementary[side]
    at_centres = {
        "propensity": near.distance[:, 0],
        "propensity_k": near.mean(),
        "similarity": match_.similar[side].distance[:, 0],
    }
    table = pd.DataFrame(index=np.arange(len(points)))
    for name, values in at_centres.items():
        table[name] = _at(centres, values, len(points), np.nan)
        table[f"{name}_smoothed"] = smooth(points, centres, values, smoothing, threads)
    table["match"] = _at(centres, match_.centres[1 - side][near.partner[:, 0]], len(points), -1)
    return table


def _at(dots, values, n, missing):
    """Values of some dots among n, `missing` elsewhere."""
    out = np.full(n, missing, np.result_type(values, type(missing)))
    out[dots] = values
    return out


def by_dot(match_, side, table, within=INTERFACE):
    """Rows of propensity.csv: place, residue, maps, distance to the partner and whether the dot is interface.

    Parameters
    ----------
    match_ : Match
    side : 0 or 1
    table : DataFrame of `maps`
    within : float, Å

    Returns
    -------
    DataFrame, a row per dot. The partners' places tell the distance only where both come from one complex.
    """
    mine, other = match_.partners[side], match_.partners[1 - side]
    out = pd.DataFrame({"dot": np.arange(len(mine.surface))})
    out[["x", "y", "z"]] = mine.surface.points
    if mine.residues is not None:
        rows = mine.residues.iloc[mine.residue].reset_index(drop=True)
        out[list(rows.columns)] = rows
    out = pd.concat([out, table], axis=1)
    out["gap"] = gaps(mine.surface.points, other.surface.points)[0]
    out["interface"] = (out["gap"] < within).astype(int)
    return out


def by_residue(dots):
    """Mean of each map over the dots of a residue.

    Parameters
    ----------
    dots : DataFrame of `by_dot`

    Returns
    -------
    DataFrame: chain, residue, residue_name, dots, the smoothed maps and `interface`, the share of its dots that are;
    residues without dots are not on the surface and have no row. None where no atoms are known.
    """
    keys = ["chain", "residue", "residue_name"]
    if not set(keys) <= set(dots.columns):
        return None
    names = ["propensity_smoothed", "propensity_k_smoothed", "similarity_smoothed", "interface"]
    grouped = dots.groupby(keys, sort=False, dropna=False)
    table = grouped[names].mean()
    table.insert(0, "dots", grouped.size())
    return table.reset_index()


def on_atoms(molecule, residues, name, buried=np.nan):
    """A column of `by_residue` on the atoms of a molecule, (A,) float64; `buried` in residues that have no row."""
    values = dict(zip(zip(residues["chain"], residues["residue"], strict=True), residues[name], strict=True))
    keys = zip(molecule.chain, molecule.residue, strict=True)
    return np.array([values.get(key, buried) for key in keys], np.float64)


def best_pairs(match_, most=MOST_PAIRS, apart=APART):
    """The best-matching patches, each pair telling something new.

    Parameters
    ----------
    match_ : Match
    most : int
    apart : float
        Å; a pair is left out where a better one lies nearer than this on both sides.

    Returns
    -------
    DataFrame: rank, dot_1, dot_2, their residues where known, distance of the descriptors, `gap`, distance in Å
    between the two dots as they lie in the files.
    """
    sides = [
        np.column_stack([match_.centres[0], match_.centres[1][match_.complementary[0].partner[:, 0]]]),
        np.column_stack([match_.centres[0][match_.complementary[1].partner[:, 0]], match_.centres[1]]),
    ]
    pairs = np.concatenate(sides)
    distance = np.concatenate([near.distance[:, 0] for near in match_.complementary])
    places = [match_.partners[side].surface.points[pairs[:, side]] for side in (0, 1)]
    kept = []
    for i in np.lexsort((pairs[:, 1], pairs[:, 0], distance)):
        near = [np.linalg.norm(place[kept] - place[i], axis=1) < apart for place in places]
        if not (near[0] & near[1]).any():
            kept.append(int(i))
        if len(kept) == most:
            break
    table = pd.DataFrame({"rank": np.arange(1, len(kept) + 1)})
    for side in (0, 1):
        partner = match_.partners[side]
        table[f"dot_{side + 1}"] = pairs[kept, side]
        if partner.residues is not None:
            rows = partner.residues.iloc[partner.residue[pairs[kept, side]]]
            table[f"residue_{side + 1}"] = (
                rows["chain"] + ":" + rows["residue_name"] + rows["residue"]
            ).to_numpy()
    table["distance"] = distance[kept]
    table["gap"] = np.linalg.norm(places[0][kept] - places[1][kept], axis=1)
    return table


def agreement(match_, side, table, within=INTERFACE, labels=None, seed=0, threads=1):
    """Areas under the ROC curve of the maps and of the references, at the centres of one side.

    Parameters
    ----------
    match_ : Match
    side : 0 or 1
    table : DataFrame of `maps`
    within : float, Å
    labels : (N,) bool, optional
        The interface where it is known otherwise, as for unbound forms.
    seed : int
    threads : int

    Returns
    -------
    DataFrame: score, auc, low, high (95 %, drawing blocks of residues), dots, interface (how many of them are),
    blocks; None where the partners do not touch, or touch everywhere.
    """
    partner, centres = match_.partners[side], match_.centres[side]
    points = partner.surface.points
    if labels is None:
        labels = gaps(points, match_.partners[1 - side].surface.points)[0] < within
    positive = labels[centres]
    if positive.all() or not positive.any():
        return None
    at = table.iloc[centres]
    scores = {name: -at[name].to_numpy() for name in table.columns if name != "match"}
    scores |= baseline_scores(partner, centres, threads)
    scores = {name: score for name, score in scores.items() if not np.isnan(score).all()}
    block = blocks_of(partner, centres)
    areas = bootstrap_auc(scores, positive, block, stream(seed, "agreement", partner.name))
    out = pd.DataFrame([(name, *area) for name, area in areas.items()], columns=AREAS[1:5])
    return out.assign(dots=len(centres), interface=int(positive.sum()), blocks=int(block.max()) + 1)


def blocks_of(partner, dots):
    """Blocks of residues at some dots (n,); of the dots themselves where no residues are known."""
    units = np.arange(len(dots)) if partner.residue is None else partner.residue[dots]
    return blocks_of_residues(partner.surface.points[dots], units)


def contacts(first, second, within=INTERFACE, recipe=RECIPE, seed=0, threads=1):
    """Whether patches that lie on each other match better than others.

    Dots of the first partner's interface keep their own patch; the true partner, the dot on it, is compared with a
    random dot of the second surface, and with the true partner of another of them. Only the latter holds all else
    alike: the nearest dot is more often one that sticks out, and such patches lie far from all others.

    Returns
    -------
    DataFrame: against ('any pair', 'exchanged'), auc (the chance that the native pair is nearer), low, high
    (95 %, drawing blocks of the first's residues), pairs. None where the partners do not touch.
    """
    pairs = native_pairs(first.surface.points, second.surface.points, within)
    if len(pairs) < 2:
        return None
    rng = stream(seed, "contacts", first.name, second.name)
    pairs = pairs[np.sort(rng.permutation(len(pairs))[:MOST_CONTACTS])]
    others = {
        "any pair": rng.integers(len(second.surface), size=len(pairs)),
        "exchanged": rng.permutation(pairs[:, 1]),
    }
    up, _ = descriptors_at(first, first.surface.points[pairs[:, 0]], True, recipe, threads)

    def distance_to(dots):
        down, _ = descriptors_at(second, second.surface.points[dots], False, recipe, threads)
        return np.linalg.norm(up - down, axis=1)

    native = distance_to(pairs[:, 1])
    block = blocks_of(first, pairs[:, 0])
    rows = []
    for name, dots in others.items():
        random = distance_to(dots)
        positive = np.repeat([True, False], len(pairs))
        score = {name: -np.concatenate([native, random])}
        area = bootstrap_auc(score, positive, np.tile(block, 2), stream(seed, "contacts", name, first.name))
        rows.append((name, *area[name], len(pairs)))
    return pd.DataFrame(rows, columns=CONTACTS)
