"""All scores of one complex, ready for the means over many."""

import numpy as np
import pandas as pd

from sparsurf.pairs.complexes import areas, combinations, scores_of_pair
from sparsurf.pairs.interface import INTERFACE, interface
from sparsurf.pairs.matching import Recipe, blocks_of, contacts, descriptors_at
from sparsurf.pairs.nearest import nearest
from sparsurf.pairs.neighbourhoods import smooth
from sparsurf.pairs.ranking import bootstrap_auc
from sparsurf.sampling.samplers import get_samplers
from sparsurf.streams import stream
from sparsurf.study.prepared_surface import PreparedSurface

MOST = 1500  # patches of each surface
K_VALUES = (1, 10)  # nearest patches whose mean distance is taken
RECIPES = (Recipe(), Recipe(radius=12.0))
DRAWS = 200  # of the bootstrap of each surface
KEYS = ["descriptor", "score", "k", "kind", "map"]
MAIN = ("complementarity", 1, "plain")  # the propensity as published


def centres_of(partner, n, sampler="farthest", seed=0):
    """Centres by a sampler, ascending, (n,) int; all dots where there are no more than n."""
    if len(partner.surface) <= n:
        return np.arange(len(partner.surface))
    function = get_samplers([sampler], "complementarity.centres.sampler")[sampler]
    view = PreparedSurface(partner.surface, roughness_values=partner.roughness, seed=seed, name=partner.name)
    return np.sort(function(view, n, view.stream("centres", sampler)))


def name_of(recipe):
    """A recipe in words."""
    return f"{recipe.descriptor}, {recipe.radius:g} Å"


def score_complex(
    pair, others=None, labels=None, recipes=RECIPES, k_values=K_VALUES, most=MOST, seed=0, threads=1
):
    """Areas of all scores on both sides of a complex.

    Parameters
    ----------
    pair : two `partners.Partner`
    others : two (n, 121), optional
        'up' descriptors of another complex's first partner and 'down' ones of its second: a control.
    labels : two (N,) bool, optional
        The interface where it is not that of the files, as for unbound forms.
    recipes : sequence of matching.Recipe
        The first is that of the intervals and of the control.
    k_values : sequence of int
    most, seed, threads : int

    Returns
    -------
    table : DataFrame, a row per side and score: side, descriptor, score, k, kind, map, auc, low and high (95 % by
        blocks of residues, for the published map and the references), patches, interface
    touching : DataFrame of `matching.contacts`
    own : two (n, 121), to serve as `others` of the next complex
    same : two floats, correlation of the smoothed map with that against `others`; NaN without
    """
    centres = [centres_of(each, most, seed=seed) for each in pair]
    if labels is None:
        labels = [interface(a.surface.points, b.surface.points, INTERFACE) for a, b in (pair, pair[::-1])]
    scores, own = ({}, {}), None
    for recipe in recipes:
        up, down = [
            [descriptors_at(each, each.surface.points[dots], turned, recipe, threads)[0]
             for each, dots in zip(pair, centres, strict=True)]
            for turned in (True, False)
        ]  # fmt: skip
        own = own or (up[0], down[1])
        found = scores_of_pair(pair, centres, up, down, k_values, name_of(recipe), threads)
        for side in (0, 1):
            scores[side].update(found[side])
    same = (np.nan, np.nan)
    if others is not None:
        same = _against_others(pair, centres, own, others, scores, name_of(recipes[0]), threads)
    tables = []
    for side in (0, 1):
        published = scores[side][name_of(recipes[0]), *MAIN, "smoothed"]
        beside = combinations(pair[side], centres[side], published, threads)
        for name, score in beside.items():
            of = name_of(recipes[0]) if name.startswith("propensity") else "-"
            scores[side][of, name, 0, "-", "-"] = score
        tables.append(
            _rows(pair[side], centres[side], scores[side], labels[side], seed).assign(side=side + 1)
        )
    return pd.concat(tables), contacts(*pair, recipe=recipes[0], seed=seed, threads=threads), own, same


def _against_others(pair, centres, own, others, scores, name, threads):
    """Add the maps against another complex's partner; correlation of each with the map against its own."""
    same = []
    found = (nearest(own[0], others[1], 1, threads)[0], nearest(others[0], own[1], 1, threads)[1])
    for side, near in enumerate(found):
        values = near.distance[:, 0]
        places = pair[side].surface.points[centres[side]]
        smoothed = -smooth(places, np.arange(len(values)), values)
        scores[side][name, "another protein", 1, "plain", "raw"] = -values
        scores[side][name, "another protein", 1, "plain", "smoothed"] = smoothed
        same.append(float(np.corrcoef(smoothed, scores[side][name, *MAIN, "smoothed"])[0, 1]))
    return tuple(same)


def _rows(partner, centres, scores, labels, seed):
    """Areas of one side, with intervals for the published map and what stands beside it."""
    positive = labels[centres]
    table = pd.DataFrame(
        [(*key, area) for key, area in areas(scores, positive).items()], columns=[*KEYS, "auc"]
    )
    first = next(iter(scores))[0]
    wanted = {key: score for key, score in scores.items() if key[:4] == (first, *MAIN) or key[2] == 0}
    drawn = bootstrap_auc(
        wanted, positive, blocks_of(partner, centres), stream(seed, "complex", partner.name), DRAWS
    )
    at = [drawn.get(tuple(key), (np.nan,) * 3) for key in table[KEYS].itertuples(index=False)]
    table["low"], table["high"] = [each[1] for each in at], [each[2] for each in at]
    return table.assign(patches=len(centres), interface=int(positive.sum()))
