"""Compute all scores of one complex, to be averaged over many complexes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from sparsurf.pairs.complexes import areas, combinations, scores_of_pair
from sparsurf.pairs.interface import INTERFACE, interface
from sparsurf.pairs.matching import Recipe, blocks_of, contacts, descriptors_at
from sparsurf.pairs.nearest import nearest
from sparsurf.pairs.neighbourhoods import smooth
from sparsurf.pairs.partners import Partner
from sparsurf.pairs.ranking import bootstrap_auc
from sparsurf.sampling.samplers import get_samplers
from sparsurf.streams import stream
from sparsurf.study.prepared_surface import PreparedSurface

MAX_PATCHES = 1500  # of each surface
K_VALUES = (1, 10)  # numbers of nearest patches over which the distance is averaged
RECIPES = (Recipe(), Recipe(radius=12.0))
N_DRAWS = 200  # of the bootstrap of each surface
KEYS = ["descriptor", "score", "k", "kind", "map"]
MAIN = ("complementarity", 1, "plain")  # the propensity as published


def centres_of(partner: Partner, n: int, sampler: str = "farthest", seed: int = 0) -> np.ndarray:
    """Choose centres with a sampler.

    Parameters
    ----------
    partner : Partner
    n : int
    sampler : str
    seed : int

    Returns
    -------
    (n,) int, ascending; all dots if there are no more than n
    """
    if len(partner.surface) <= n:
        return np.arange(len(partner.surface))
    function = get_samplers([sampler], "complementarity.centres.sampler")[sampler]
    prepared = PreparedSurface(
        partner.surface, roughness_values=partner.roughness, seed=seed, name=partner.name
    )
    return np.sort(function(prepared, n, prepared.stream("centres", sampler)))


def name_of(recipe: Recipe) -> str:
    """Name a recipe by its descriptor and radius."""
    return f"{recipe.descriptor}, {recipe.radius:g} Å"


def score_complex(
    pair: tuple[Partner, Partner],
    others: Sequence[np.ndarray] | None = None,
    labels: Sequence[np.ndarray] | None = None,
    recipes: Sequence[Recipe] = RECIPES,
    k_values: Sequence[int] = K_VALUES,
    max_patches: int = MAX_PATCHES,
    seed: int = 0,
    threads: int = 1,
) -> tuple[pd.DataFrame, pd.DataFrame | None, tuple[np.ndarray, np.ndarray], tuple[float, float]]:
    """Compute the areas under the ROC curve of all scores on both sides of a complex.

    Parameters
    ----------
    pair : two `partners.Partner`
    others : two (n, 121), optional
        A control: 'up' descriptors of the first partner of another complex and 'down' descriptors of its second partner.
    labels : two (N,) bool, optional
        The interface, if it does not follow from the coordinates, as for unbound forms.
    recipes : sequence of matching.Recipe
        The first one gets intervals and the control.
    k_values : sequence of int
    max_patches, seed, threads : int

    Returns
    -------
    table : DataFrame, a row per side and score: side, descriptor, score, k, kind, map, auc, low and high (95 % by
        blocks of residues, for the published map and the baselines), patches, interface
    touching : DataFrame of `matching.contacts`, or None
    descriptors : two (n, 121), that can be `others` of the next complex
    correlation : two floats, between the smoothed map and that against `others`; NaN without `others`
    """
    centres = [centres_of(partner, max_patches, seed=seed) for partner in pair]
    if labels is None:
        labels = [interface(a.surface.points, b.surface.points, INTERFACE) for a, b in (pair, pair[::-1])]
    scores: tuple[dict[tuple, np.ndarray], dict[tuple, np.ndarray]] = ({}, {})
    descriptors: list[tuple[np.ndarray, np.ndarray]] = []  # of each recipe
    for recipe in recipes:
        up, down = (_descriptors(pair, centres, is_up, recipe, threads) for is_up in (True, False))
        descriptors.append((up[0], down[1]))
        of_recipe = scores_of_pair(pair, centres, up, down, k_values, name_of(recipe), threads)
        for side in (0, 1):
            scores[side].update(of_recipe[side])
    main = name_of(recipes[0])
    correlation = (np.nan, np.nan)
    if others is not None:
        correlation = _against_others(pair, centres, descriptors[0], others, scores, main, threads)
    tables = []
    for side in (0, 1):
        published = scores[side][main, *MAIN, "smoothed"]
        for name, score in combinations(pair[side], centres[side], published, threads).items():
            descriptor = main if name.startswith("propensity") else "-"
            scores[side][descriptor, name, 0, "-", "-"] = score
        rows = _rows(pair[side], centres[side], scores[side], labels[side], seed)
        tables.append(rows.assign(side=side + 1))
    touching = contacts(pair[0], pair[1], recipe=recipes[0], seed=seed, threads=threads)
    return pd.concat(tables), touching, descriptors[0], correlation


def _descriptors(
    pair: tuple[Partner, Partner], centres: Sequence[np.ndarray], up: bool, recipe: Recipe, threads: int
) -> list[np.ndarray]:
    """Describe the patches around the centres of both sides."""
    return [
        descriptors_at(partner, partner.surface.points[dots], up, recipe, threads)[0]
        for partner, dots in zip(pair, centres, strict=True)
    ]


def _against_others(
    pair: tuple[Partner, Partner],
    centres: Sequence[np.ndarray],
    descriptors: tuple[np.ndarray, np.ndarray],
    others: Sequence[np.ndarray],
    scores: tuple[dict[tuple, np.ndarray], dict[tuple, np.ndarray]],
    name: str,
    threads: int,
) -> tuple[float, float]:
    """Add the maps against the partner of another complex; return their correlations with the maps of this complex."""
    correlation = []
    first = nearest(descriptors[0], others[1], 1, threads)[0]
    second = nearest(others[0], descriptors[1], 1, threads)[1]
    for side, near in enumerate((first, second)):
        values = near.distance[:, 0]
        centre_points = pair[side].surface.points[centres[side]]
        smoothed = -smooth(centre_points, np.arange(len(values)), values)
        scores[side][name, "another protein", 1, "plain", "raw"] = -values
        scores[side][name, "another protein", 1, "plain", "smoothed"] = smoothed
        correlation.append(float(np.corrcoef(smoothed, scores[side][name, *MAIN, "smoothed"])[0, 1]))
    return correlation[0], correlation[1]


def _rows(
    partner: Partner, centres: np.ndarray, scores: dict[tuple, np.ndarray], labels: np.ndarray, seed: int
) -> pd.DataFrame:
    """Tabulate the areas of one side, with intervals for the published map and the baselines."""
    positive = labels[centres]
    table = pd.DataFrame(
        [(*key, area) for key, area in areas(scores, positive).items()], columns=[*KEYS, "auc"]
    )
    first = next(iter(scores))[0]
    with_interval: dict[Any, np.ndarray] = {
        key: score for key, score in scores.items() if key[:4] == (first, *MAIN) or key[2] == 0
    }
    drawn = bootstrap_auc(
        with_interval, positive, blocks_of(partner, centres), stream(seed, "complex", partner.name), N_DRAWS
    )
    at = [drawn.get(tuple(key), (np.nan,) * 3) for key in table[KEYS].itertuples(index=False)]
    table["low"], table["high"] = [area[1] for area in at], [area[2] for area in at]
    return table.assign(patches=len(centres), interface=int(positive.sum()))
