"""How much a descriptor changes when only the position or the dots change, not the surface."""

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from sparsurf.patches.descriptors import DESCRIPTORS, describe
from sparsurf.patches.index import build_index
from sparsurf.patches.zernike.polynomials import indices
from sparsurf.sampling.combination import PUBLISHED_ROWS
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.study import grid
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.study.relation import with_interval
from sparsurf.surfaces.molecular_surface import DENSITY, molecular_surface

CHANGES = ("turned", "fresh dots", "turned, fresh dots")
TURNS, DRAWS = 5, 3


def poses(
    xyz: np.ndarray,
    radii: np.ndarray,
    tests: np.ndarray,
    density: float,
    rng: np.random.Generator,
    turns: int = TURNS,
) -> Iterator[tuple[str, np.ndarray, np.ndarray, np.ndarray]]:
    """Yield (change, points, normals, places of the tests) of one surface: as it is first, then changed.

    Fresh dots are those that the surface of the turned molecule gets, turned back.

    Parameters
    ----------
    xyz, radii : (A, 3) and (A,), Å
    tests : (T, 3), Å
    density : dots per Å^2
    rng : numpy.random.Generator
    """
    surface = molecular_surface(xyz, radii, density=density)
    yield "", surface.points, surface.normals, tests
    for turn in Rotation.random(turns, rng).as_matrix():
        other = molecular_surface(xyz @ turn.T, radii, density=density)
        yield CHANGES[0], surface.points @ turn.T, surface.normals @ turn.T, tests @ turn.T
        yield CHANGES[1], other.points @ turn, other.normals @ turn, tests
        yield CHANGES[2], other.points, other.normals, tests @ turn.T


def steadiness(
    xyz: np.ndarray,
    radii: np.ndarray,
    tests: np.ndarray,
    rng: np.random.Generator,
    density: float = DENSITY,
    d_link: float = 0.5,
    threads: int = 1,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Measure the change of each descriptor relative to the difference of two patches, in total and by order n.

    Returns
    -------
    changes : DataFrame with density, descriptor, change, Z, sd of Z over the turns, Z_two_patches and ratio
    orders : DataFrame with density, descriptor, n and ratio: the variance of the coefficients of this order when the
        molecule is turned and gets fresh dots, over that between patches
    """
    descriptors = {}
    for change, points, normals, places in poses(xyz, radii, tests, density, rng):
        index = build_index(points, normals, d_link)
        for name in DESCRIPTORS:
            z, _ = describe(index, places, threads=threads, descriptor=name)
            descriptors.setdefault((name, change), []).append(z)
    changes, orders = [], []
    for name in DESCRIPTORS:
        z = descriptors[name, ""][0]
        apart = np.linalg.norm(z - np.roll(z, 1, axis=0), axis=1).mean()  # tests stand in random order
        for change in CHANGES:
            moved = [np.linalg.norm(z - w, axis=1).mean() for w in descriptors[name, change]]
            changes.append(
                (density, name, change, np.mean(moved), np.std(moved, ddof=1), apart, np.mean(moved) / apart)
            )
        within = np.mean([(z - w) ** 2 for w in descriptors[name, CHANGES[2]]], axis=(0, 1)) / 2
        for n in range(21):
            of_n = [k for k, (order, _) in enumerate(indices()) if order == n]
            orders.append((density, name, n, within[of_n].sum() / z.var(axis=0)[of_n].sum()))
    columns = ["density", "descriptor", "change", "Z", "sd", "Z_two_patches", "ratio"]
    return pd.DataFrame(changes, columns=columns), pd.DataFrame(
        orders, columns=["density", "descriptor", "n", "ratio"]
    )


def rows_of_paper(prepared: PreparedSurface, n_tests: int) -> pd.DataFrame:
    """Return the ten published combinations under both descriptors and readings: mean Z_tS, d and its standard error."""
    out = []
    for name in DESCRIPTORS:
        result = grid.evaluate_grid(prepared.changed(descriptor=name), PUBLISHED_ROWS, n_tests, DRAWS)
        gain = (result.z_tr - result.z_ts).mean(axis=2)  # over the draws
        for r, reading in enumerate(result.readings):
            for k in range(len(PUBLISHED_ROWS)):
                error = gain[r, k].std(ddof=1) / np.sqrt(n_tests)
                percent = 100 * result.n_s[k].mean() / result.n_dots
                out.append(
                    (name, reading, k + 1, percent, result.z_ts[r, k].mean(), gain[r, k].mean(), error)
                )
    return pd.DataFrame(out, columns=["descriptor", "reading", "row", "n_S_percent", "Z_tS", "d", "error"])


def whole_grid(prepared: PreparedSurface, combinations: np.ndarray, n_tests: int) -> pd.DataFrame:
    """Return the share of a grid's combinations with d > 0, the best d, and the correlation of d between the descriptors."""
    d = {}
    for name in DESCRIPTORS:
        result = grid.evaluate_grid(prepared.changed(descriptor=name), combinations, n_tests, 1)
        for r, reading in enumerate(result.readings):
            d[name, reading] = (result.z_tr[r] - result.z_ts[r]).mean(axis=(1, 2))
    first = next(iter(DESCRIPTORS))
    out = [
        (name, reading, 100 * (gain > 0).mean(), gain.max(), *combinations[gain.argmax()],
         np.corrcoef(gain, d[first, reading])[0, 1])
        for (name, reading), gain in d.items()
    ]  # fmt: skip
    columns = [
        "descriptor",
        "reading",
        "percent_above_0",
        "best_d",
        "alpha",
        "beta",
        "gamma",
        "delta",
        "correlation",
    ]
    return pd.DataFrame(out, columns=columns)


def of_samplers(prepared: PreparedSurface, n_tests: int, percents: Sequence[float]) -> pd.DataFrame:
    """Return Z of every sampler at equal n_S under `as_written`, by both descriptors; the error is that over test dots."""
    tests, out = prepared.draw_tests(n_tests), []
    z_tot = {name: prepared.changed(descriptor=name).describe(tests)[0] for name in DESCRIPTORS}
    for sampler, choose in SAMPLERS.items():
        for percent in percents:
            n = round(percent / 100 * len(prepared.points))
            rngs = [prepared.stream("steadiness", sampler, draw) for draw in range(DRAWS)]
            subsets = [choose(prepared, n, rng) for rng in rngs]
            kept = np.mean([len(subset) for subset in subsets])
            for name in DESCRIPTORS:
                z, _ = prepared.changed(descriptor=name).distances(subsets, tests, z_tot[name], "as_written")
                z = z.mean(axis=0)
                error = z.std(ddof=1) / np.sqrt(len(tests))
                out.append((name, sampler, percent, 100 * kept / len(prepared.points), z.mean(), error))
    return pd.DataFrame(out, columns=["descriptor", "sampler", "percent", "n_S_percent", "Z", "error"])


def means(table: pd.DataFrame, keys: list[str]) -> pd.DataFrame:
    """Return the ratio over the structures, with its 95 % interval: keys, structures, lowest and highest."""
    rows = []
    for group, part in table.groupby(keys, sort=False):
        row = (
            dict(zip(keys, group, strict=True))
            | {"structures": len(part)}
            | with_interval("ratio", part["ratio"])
        )
        rows.append(row | {"lowest": part["ratio"].min(), "highest": part["ratio"].max()})
    return pd.DataFrame(rows)


def grid_means(table: pd.DataFrame) -> pd.DataFrame:
    """Return results of the paper's grid with each descriptor over the structures: means, `_lowest` and `_highest`."""
    rows = []
    for group, part in table.groupby(["descriptor", "reading"], sort=False):
        row = dict(zip(("descriptor", "reading"), group, strict=True)) | {"structures": len(part)}
        for key in ("percent_above_0", "best_d", "correlation"):
            row |= {
                key: part[key].mean(),
                f"{key}_lowest": part[key].min(),
                f"{key}_highest": part[key].max(),
            }
        rows.append(row)
    return pd.DataFrame(rows)
