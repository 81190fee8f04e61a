"""Sites of several kinds searched on unrelated proteins: scores, the distribution of p, and how often it is right."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
import pandas as pd
from scipy.optimize import minimize
from scipy.spatial import cKDTree

from sparsurf.sites.describing import Sites
from sparsurf.sites.finding import MAX_PLACES, MIN_LEVEL, chance, find_site

COMPACT, POCKET, LOOSE, INTERFACE, WHOLE = KINDS = (
    "compact group",
    "pocket",
    "loose group",
    "interface",
    "whole protein",
)
SIZES = (8, 12, 25, 50, 100, 200, 400)  # places; each protein takes every second
LARGEST_SHARE = 0.5  # of a protein that a group may be
LARGEST_POCKET = 200  # places
LOOSENESS = 3  # a loose group is drawn from that many times as many nearest places
ABOVE, ROOM, REACH = (
    3.0,
    2.2,
    10.0,
)  # Å: height of a point above a place, distance to all others, and around it
DEEPEST = 0.02  # share of the places that may be the bottom of a pocket
LEVELS = (0.01, 0.05, 0.1, 0.5)
RANGES = ((8, 40), (40, 400), (400, np.inf))  # places


def groups(site: Sites, rng: np.random.Generator) -> Iterator[tuple[str, Sites]]:
    """Yield the whole protein, and compact groups, pockets and loose groups of every second of SIZES."""
    yield WHOLE, site
    for n in SIZES[int(rng.integers(2)) :: 2]:
        if n > LARGEST_SHARE * len(site):
            continue
        yield COMPACT, site.take(_nearest(site, site.points[rng.integers(len(site))], n))
        if n <= LARGEST_POCKET:
            yield POCKET, site.take(_nearest(site, _bottom(site, rng), n))
        around = _nearest(site, site.points[rng.integers(len(site))], LOOSENESS * n)
        yield LOOSE, site.take(np.sort(rng.choice(around, min(n, len(around)), replace=False)))


def parts(site: Sites, rng: np.random.Generator) -> Iterator[tuple[str, Sites]]:
    """Yield an interface, and compact parts of it of the SIZES."""
    yield INTERFACE, site
    for n in SIZES:
        if n < len(site):
            yield INTERFACE, site.take(_nearest(site, site.points[rng.integers(len(site))], n))


def _nearest(site: Sites, point: np.ndarray, n: int) -> np.ndarray:
    """Return the n places nearest to a point."""
    return np.argsort(np.linalg.norm(site.points - point, axis=1), kind="stable")[:n]


def _bottom(site: Sites, rng: np.random.Generator) -> np.ndarray:
    """Return a point above one of the deepest places: those with most of the surface around, but room above them."""
    above, tree = site.points + ABOVE * site.normals, cKDTree(site.points)
    depth = tree.query_ball_point(above, REACH, return_length=True) * (tree.query(above)[0] >= ROOM)
    return above[rng.choice(np.argsort(-depth)[: max(1, int(DEEPEST * len(site)))])]


def search(queries: Iterable[tuple[str, Sites]], targets: Sequence[Sites]) -> pd.DataFrame:
    """Search each query on each target by itself: kind, places, target, target_places, score, mirrored."""
    rows = []
    for kind, query in queries:
        for target in targets:
            hits = find_site(query, [target], 1)
            score = hits.table["score"][0]
            rows.append((kind, len(query), target.name, len(target), score, hits.mirrored[0]))
    columns = ["kind", "places", "target", "target_places", "score", "mirrored"]
    return pd.DataFrame(rows, columns=columns)


def fit(table: pd.DataFrame) -> np.ndarray:
    """Return constants (3,) of `finding.chance` by maximum likelihood, from searches that found anything."""
    found = table[table["score"] > 0]
    gap = (found["score"] - found["mirrored"]).to_numpy()
    few = np.log(found["places"].to_numpy() / MAX_PLACES)
    level = np.log(np.maximum(found["mirrored"].to_numpy(), MIN_LEVEL))

    def loss(constants: np.ndarray) -> float:
        log_width = constants[0] + constants[1] * few + constants[2] * level
        z = np.abs(gap) / np.exp(log_width)
        return (log_width + z + 2 * np.log1p(np.exp(-z))).sum()

    return minimize(loss, [-2.0, 0.0, 0.0], method="BFGS").x


def held_out(table: pd.DataFrame) -> tuple[pd.DataFrame, dict[int, np.ndarray]]:
    """Add p of each search by the constants of the other half's unrelated proteins; searches that found nothing have none.

    Returns
    -------
    table with p; the constants by the half that they are fitted on
    """
    constants = {half: fit(part) for half, part in table[~table["same"]].groupby("half")}
    tested = table[table["score"] > 0].copy()
    for half, part in tested.groupby("half"):
        other = constants[3 - half]
        for n, rows in part.groupby("places"):
            values = (rows[key].to_numpy() for key in ("score", "mirrored"))
            tested.loc[rows.index, "p"] = chance(*values, n, other)
    return tested, constants


def _span(low: float, high: float) -> str:
    """Return the numbers of places in words."""
    return f"{low:g} places and more" if np.isinf(high) else f"{low:g} to {high - 1:g} places"


def shares(tested: pd.DataFrame) -> pd.DataFrame:
    """Return the shares of searches with p below LEVELS, by kind and RANGES of places: of unrelated proteins and of the same."""
    rows = []
    for same, part in tested.groupby("same"):
        sets = [(kind, part[part["kind"] == kind]) for kind in KINDS]
        if not same:
            sets += [
                (f"all of {_span(low, high)}", part[part["places"].between(low, high - 1)])
                for low, high in RANGES
            ]
        for name, chosen in [*sets, *([] if same else [("all", part)])]:
            if len(chosen):
                row = {"target": "the same" if same else "unrelated", "query": name, "searches": len(chosen)}
                row |= {f"below_{100 * level:g}": (chosen["p"] < level).mean() for level in LEVELS}
                rows.append(row)
    return pd.DataFrame(rows)
