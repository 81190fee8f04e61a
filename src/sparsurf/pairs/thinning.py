"""What a map from few centres is worth: its correlation with the map from all dots, its AUC, its cost."""

import time
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from sparsurf.pairs.interface import INTERFACE, interface
from sparsurf.pairs.matching import RECIPE, descriptors_at
from sparsurf.pairs.nearest import nearest
from sparsurf.pairs.neighbourhoods import SMOOTHING, smooth
from sparsurf.pairs.partners import Partner
from sparsurf.pairs.ranking import auc
from sparsurf.patches.index import D_LINK, build_index
from sparsurf.recovery.readings import comparable_density
from sparsurf.recovery.recovering import recover
from sparsurf.sampling.samplers import get_samplers
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.surfaces.spacing import area_of
from sparsurf.surfaces.surface import Surface

PERCENTS = (1, 2.5, 5, 10, 20)
THINNERS = ("farthest", "poisson", "uniform", "paper")
STAGES = ("choosing", "recovering", "describing", "comparing", "smoothing")


@dataclass
class Clock:
    """CPU seconds of the stages of one map."""

    seconds: dict = field(default_factory=lambda: dict.fromkeys(STAGES, 0.0))

    @contextmanager
    def of(self, stage):
        """Add what happens inside to a stage."""
        begin = time.process_time()
        yield
        self.seconds[stage] += time.process_time() - begin


def thinned_maps(pair, centres, clock, recipe=RECIPE, smoothing=SMOOTHING, described=None, threads=1):
    """Smoothed propensity of all dots of both partners from some centres.

    Parameters
    ----------
    pair : two `partners.Partner`
    centres : two (n,) int, dots
    clock : Clock
    recipe : matching.Recipe
    smoothing : float, Å
    described : two Partner, optional
        Surfaces whose patches are cut instead, such as recovered ones; the centres stay dots of `pair`.
    threads : int

    Returns
    -------
    two (N,) float64
    """
    z, kept = [], []
    with clock.of("describing"):
        for mine, own, dots, up in zip(pair, described or pair, centres, (True, False), strict=True):
            vectors, sizes = descriptors_at(own, mine.surface.points[dots], up, recipe, threads)
            z.append(vectors[sizes > 1])
            kept.append(dots[sizes > 1])
    with clock.of("comparing"):
        found = nearest(*z, threads=threads)
    with clock.of("smoothing"):
        return [
            smooth(mine.surface.points, dots, near.distance[:, 0], smoothing, threads)
            for mine, dots, near in zip(pair, kept, found, strict=True)
        ]


def recovered(partner, dots, d_link=D_LINK):
    """A partner whose surface is recovered from some of its dots (n,) and their normals alone, without atoms."""
    whole = partner.surface
    density = comparable_density(len(whole) / area_of(whole)[0], d_link)
    surface = Surface(*recover(whole.points[dots], whole.normals[dots], density))
    return Partner(partner.name, surface, build_index(surface.points, surface.normals, d_link), None)


def thinning(
    first,
    second,
    percents=PERCENTS,
    samplers=THINNERS,
    draws=1,
    with_recovered=False,
    recipe=RECIPE,
    smoothing=SMOOTHING,
    within=INTERFACE,
    seed=0,
    threads=1,
    rules=None,
):
    """Maps from fewer and fewer centres on both sides, against the map from all dots.

    Parameters
    ----------
    first, second : partners.Partner
    percents : sequence of float
        Centres, % of the dots.
    samplers : sequence of str, see `samplers.SAMPLERS`
    draws : int
        Of each random sampler and size.
    with_recovered : bool
        Describe the surface recovered from the centres alone too.
    recipe : matching.Recipe
    smoothing, within : float, Å
    seed, threads : int
    rules : dict, optional
        What a PreparedSurface goes by beside: r_patch, d_link, distance_from_moved_centre,
        chance_in_every_patch; the published ones without.

    Returns
    -------
    DataFrame, one row per sampler, requested percent, `surface` ('full' where the patches are cut from all dots,
    'recovered' where from the centres alone), draw and side (1, 2): n_S, n_S_percent of the dots, correlation
    (Pearson) with the smoothed map of all dots, auc (NaN where the partners do not touch), CPU seconds in all and by
    stage, for both sides together. The map of all dots has the sampler 'all'.
    """
    pair = (first, second)
    labels = [
        interface(a.surface.points, b.surface.points, within) for a, b in ((first, second), (second, first))
    ]
    evaluators = [
        PreparedSurface(each.surface, roughness_values=each.roughness, seed=seed, name=each.name, **rules or {})
        for each in pair
    ]
    d_link = evaluators[0].d_link
    samplers = get_samplers(samplers, "complementarity.thinning.samplers")
    _warm_up(pair, evaluators[0], samplers, with_recovered)
    everything = [np.arange(len(each.surface)) for each in pair]
    clock = Clock()
    full = thinned_maps(pair, everything, clock, recipe, smoothing, threads=threads)
    rows = _rows(("all", 100.0, "full", 0), everything, full, full, labels, clock)
    for name, sampler in samplers.items():
        for draw in range(draws):
            for percent in percents:
                clock = Clock()
                with clock.of("choosing"):
                    centres = [_choose(sampler, name, each, percent, draw) for each in evaluators]
                known = (name, percent, "full", draw)
                thin = thinned_maps(pair, centres, clock, recipe, smoothing, threads=threads)
                rows += _rows(known, centres, thin, full, labels, clock)
                if not with_recovered:
                    continue
                clock = Clock(clock.seconds | {"describing": 0.0, "comparing": 0.0, "smoothing": 0.0})
                with clock.of("recovering"):
                    own = [recovered(each, dots, d_link) for each, dots in zip(pair, centres, strict=True)]
                thin = thinned_maps(pair, centres, clock, recipe, smoothing, own, threads)
                rows += _rows((name, percent, "recovered", draw), centres, thin, full, labels, clock)
    return pd.DataFrame(rows)


def _warm_up(pair, evaluator, samplers, with_recovered):
    """Compile or load every kernel, so that no map pays for it."""
    few = [np.arange(min(100, len(each.surface))) for each in pair]
    for name, sampler in samplers.items():
        _choose(sampler, name, evaluator, 1, 0)
    d_link = evaluator.d_link
    own = (
        [recovered(each, dots, d_link) for each, dots in zip(pair, few, strict=True)]
        if with_recovered
        else None
    )
    thinned_maps(pair, few, Clock(), described=own)


def _choose(sampler, name, evaluator, percent, draw):
    """Centres of one surface, ascending; a nested sampler takes the beginning of the same choice at every size."""
    keys = ("thinning", name, draw) if sampler.nested else ("thinning", name, draw, str(percent))
    n = max(1, round(percent / 100 * len(evaluator.points)))
    return np.sort(sampler(evaluator, n, evaluator.stream(*keys)))


def _rows(known, centres, thin, full, labels, clock):
    rows = []
    for side in (0, 1):
        rows.append(
            {
                **dict(zip(("sampler", "percent", "surface", "draw"), known, strict=True)),
                "side": side + 1,
                "n_S": len(centres[side]),
                "n_S_percent": 100 * len(centres[side]) / len(full[side]),
                "correlation": float(np.corrcoef(thin[side], full[side])[0, 1]),
                "auc": auc(-thin[side], labels[side]),
                "seconds": sum(clock.seconds.values()),
                **clock.seconds,
            }
        )
    return rows
