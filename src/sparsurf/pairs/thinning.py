"""Evaluate maps from few centres: correlation with the map from all dots, AUC and cost."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from sparsurf.pairs.interface import INTERFACE, interface
from sparsurf.pairs.matching import RECIPE, Recipe, descriptors_at
from sparsurf.pairs.nearest import nearest
from sparsurf.pairs.neighbourhoods import SMOOTHING, smooth
from sparsurf.pairs.partners import Partner
from sparsurf.pairs.ranking import auc
from sparsurf.patches.index import D_LINK, build_index
from sparsurf.recovery.readings import comparable_density
from sparsurf.recovery.recovering import recover
from sparsurf.sampling.samplers import Sampler, get_samplers
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.surfaces.spacing import area_of
from sparsurf.surfaces.surface import Surface

PERCENTS = (1, 2.5, 5, 10, 20)
THINNERS = ("farthest", "poisson", "uniform", "paper")
STAGES = ("choosing", "recovering", "describing", "comparing", "smoothing")


@dataclass
class Clock:
    """CPU seconds of the stages of one map."""

    seconds: dict[str, float] = field(default_factory=lambda: dict.fromkeys(STAGES, 0.0))

    @contextmanager
    def of(self, stage: str) -> Iterator[None]:
        """Add the CPU time of the block to a stage."""
        begin = time.process_time()
        yield
        self.seconds[stage] += time.process_time() - begin


def thinned_maps(
    pair: Sequence[Partner],
    centres: Sequence[np.ndarray],
    clock: Clock,
    recipe: Recipe = RECIPE,
    smoothing: float = SMOOTHING,
    described: Sequence[Partner] | None = None,
    threads: int = 1,
) -> list[np.ndarray]:
    """Compute the smoothed propensity at all dots of both partners from some centres.

    Parameters
    ----------
    pair : two `partners.Partner`
    centres : two (n,) int, dots
    clock : Clock
    recipe : matching.Recipe
    smoothing : float, Å
    described : two Partner, optional
        Surfaces from which the patches are cut, such as recovered ones; `pair` by default. The centres are dots of `pair`.
    threads : int

    Returns
    -------
    two (N,) float64
    """
    z, kept = [], []
    with clock.of("describing"):
        sides = zip(pair, described or pair, centres, (True, False), strict=True)
        for partner, cut_from, dots, up in sides:
            vectors, sizes = descriptors_at(cut_from, partner.surface.points[dots], up, recipe, threads)
            z.append(vectors[sizes > 1])
            kept.append(dots[sizes > 1])
    with clock.of("comparing"):
        both = nearest(z[0], z[1], threads=threads)
    with clock.of("smoothing"):
        return [
            smooth(partner.surface.points, dots, near.distance[:, 0], smoothing, threads)
            for partner, dots, near in zip(pair, kept, both, strict=True)
        ]


def recovered(partner: Partner, dots: np.ndarray, d_link: float = D_LINK) -> Partner:
    """Recover the surface of a partner from some of its dots and their normals.

    Parameters
    ----------
    partner : Partner
    dots : (n,) int
    d_link : float, Å

    Returns
    -------
    Partner without atoms, with NaN as roughness
    """
    whole = partner.surface
    density = comparable_density(len(whole) / area_of(whole)[0], d_link)
    surface = Surface(*recover(whole.points[dots], whole.normals[dots], density))
    unknown = np.full(len(surface), np.nan)
    return Partner(partner.name, surface, build_index(surface.points, surface.normals, d_link), unknown)


def thinning(
    first: Partner,
    second: Partner,
    percents: Sequence[float] = PERCENTS,
    samplers: Sequence[str] = THINNERS,
    draws: int = 1,
    with_recovered: bool = False,
    recipe: Recipe = RECIPE,
    smoothing: float = SMOOTHING,
    within: float = INTERFACE,
    seed: int = 0,
    threads: int = 1,
    rules: dict[str, Any] | None = None,
) -> pd.DataFrame:
    """Compare maps from fewer and fewer centres on both sides with the map from all dots.

    Parameters
    ----------
    first, second : partners.Partner
    percents : sequence of float
        Centres, % of the dots.
    samplers : sequence of str, see `samplers.SAMPLERS`
    draws : int
        Number of draws of each sampler and size.
    with_recovered : bool
        Also evaluate the surface recovered from the centres.
    recipe : matching.Recipe
    smoothing, within : float, Å
    seed, threads : int
    rules : dict, optional
        Further arguments of PreparedSurface; by default the published ones.

    Returns
    -------
    DataFrame, one row per sampler, requested percent, `surface`, draw and side (1, 2). `surface` is 'full' if the patches
    are cut from all dots, 'recovered' if from the surface recovered from the centres. Columns: n_S, n_S_percent of the
    dots, correlation (Pearson) with the smoothed map of all dots, auc (NaN if the partners do not touch), CPU seconds in
    total and by stage, for both sides together. The map of all dots has the sampler 'all'.
    """
    pair = (first, second)
    labels = [
        interface(a.surface.points, b.surface.points, within) for a, b in ((first, second), (second, first))
    ]
    prepared_surfaces = [
        PreparedSurface(
            partner.surface, roughness_values=partner.roughness, seed=seed, name=partner.name, **rules or {}
        )
        for partner in pair
    ]
    d_link = prepared_surfaces[0].d_link
    chosen = get_samplers(samplers, "complementarity.thinning.samplers")
    _warm_up(pair, prepared_surfaces[0], chosen, with_recovered)
    everything = [np.arange(len(partner.surface)) for partner in pair]
    clock = Clock()
    full = thinned_maps(pair, everything, clock, recipe, smoothing, threads=threads)
    rows = _rows(("all", 100.0, "full", 0), everything, full, full, labels, clock)
    for name, sampler in chosen.items():
        for draw in range(draws):
            for percent in percents:
                clock = Clock()
                with clock.of("choosing"):
                    centres = [
                        _choose(sampler, name, prepared, percent, draw) for prepared in prepared_surfaces
                    ]
                thin = thinned_maps(pair, centres, clock, recipe, smoothing, threads=threads)
                rows += _rows((name, percent, "full", draw), centres, thin, full, labels, clock)
                if not with_recovered:
                    continue
                clock = Clock(clock.seconds | {"describing": 0.0, "comparing": 0.0, "smoothing": 0.0})
                with clock.of("recovering"):
                    partners = [recovered(*side, d_link) for side in zip(pair, centres, strict=True)]
                thin = thinned_maps(pair, centres, clock, recipe, smoothing, partners, threads)
                rows += _rows((name, percent, "recovered", draw), centres, thin, full, labels, clock)
    return pd.DataFrame(rows)


def _warm_up(
    pair: Sequence[Partner], prepared: PreparedSurface, samplers: dict[str, Sampler], with_recovered: bool
) -> None:
    """Compile or load every kernel before the first map is timed."""
    few = [np.arange(min(100, len(partner.surface))) for partner in pair]
    for name, sampler in samplers.items():
        _choose(sampler, name, prepared, 1, 0)
    partners = None
    if with_recovered:
        partners = [recovered(*side, prepared.d_link) for side in zip(pair, few, strict=True)]
    thinned_maps(pair, few, Clock(), described=partners)


def _choose(sampler: Sampler, name: str, prepared: PreparedSurface, percent: float, draw: int) -> np.ndarray:
    """Choose the centres of one surface, ascending; with a nested sampler, smaller sets are contained in larger ones."""
    keys: tuple = ("thinning", name, draw) if sampler.nested else ("thinning", name, draw, str(percent))
    n = max(1, round(percent / 100 * len(prepared.points)))
    return np.sort(sampler(prepared, n, prepared.stream(*keys)))


def _rows(
    known: tuple,
    centres: Sequence[np.ndarray],
    thin: Sequence[np.ndarray],
    full: Sequence[np.ndarray],
    labels: Sequence[np.ndarray],
    clock: Clock,
) -> list[dict[str, Any]]:
    """Return a row for each side; `known` holds sampler, percent, surface and draw."""
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
