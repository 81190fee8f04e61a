"""The grid: every combination sampled, its subsets and uniform ones compared with the whole surface.

The same test dots serve all combinations unless asked otherwise, so that combinations differ by what they keep only.
Uniform subsets that are made surfaces of their own are measured at `ON_CURVE` n_S, with as many draws, and
interpolated at those of the combinations: Z_tR depends on nothing else.
"""

from dataclasses import dataclass, fields
from threading import Lock
from zipfile import BadZipFile

import numpy as np

from sparsurf import InputError
from sparsurf.patches import descriptors
from sparsurf.patches.readings import OF_GRID
from sparsurf.sampling import published
from sparsurf.sampling.combination import Combination
from sparsurf.threads import parallel_map

N_CURVE_SIZES = (
    32  # n_S of a curve; between them a straight line over ln n_S lies .0005 off, draws scatter by .01
)


@dataclass(frozen=True)
class Grid:
    """Raw distances of a grid; K combinations, D draws, T test dots.

    combinations : (K, 4) float64
    n_dots : int, N
    n_s : (K, D) int64
    n_s_expected : (K,) float64
    tests : (T,) int64 dots, or (K, T) where every combination has its own
    z_tot : (T, 121) float64, descriptors of the full surface at the (shared) test dots
    z_ts, z_tr : (readings, K, D, T) float32, |z_tot - z_S| and |z_tot - z_R|
    fragment : (readings, 2, K) float64, median number of dots in the evaluated patches of samplings and of
        uniform subsets
    readings : tuple of str
    """

    combinations: np.ndarray
    n_dots: int
    n_s: np.ndarray
    n_s_expected: np.ndarray
    tests: np.ndarray
    z_tot: np.ndarray
    z_ts: np.ndarray
    z_tr: np.ndarray
    fragment: np.ndarray
    readings: tuple


def evaluate_grid(
    evaluator,
    combinations,
    n_tests,
    draws=1,
    readings=OF_GRID,
    shared=True,
    progress=lambda done, of: None,
):
    """Evaluate every combination.

    Parameters
    ----------
    evaluator : Evaluator
    combinations : (K, 4) float64
    n_tests : int
        T.
    draws : int
        D, samplings and uniform subsets per combination.
    readings : tuple of str
        Those of `readings.OF_GRID` come in one pass; each other one costs a surface of its own per subset: per sampling,
        and along a curve where more than `ON_CURVE` combinations share their test dots, else per uniform subset too.
    shared : bool
        The same test dots for all combinations; False draws them anew for each, as published.
    progress : callable
        Told how many of how many samplings are done.

    Returns
    -------
    Grid
    """
    combinations = np.asarray(combinations, float)
    tests = evaluator.draw_tests(n_tests)
    if not shared:
        tests = np.array([evaluator.draw_tests(n_tests, *Combination(*c).keys()) for c in combinations])
    k, shape = len(combinations), (len(readings), len(combinations), draws, tests.shape[-1])
    out = Grid(
        combinations=combinations,
        n_dots=len(evaluator.points),
        n_s=np.empty((k, draws), np.int64),
        n_s_expected=published.expected_n_s(evaluator.cover, combinations),
        tests=tests,
        z_tot=np.empty((tests.shape[-1], descriptors.DESCRIPTORS[evaluator.descriptor].width)),
        z_ts=np.empty(shape, np.float32),
        z_tr=np.empty(shape, np.float32),
        fragment=np.empty((len(readings), 2, k)),
        readings=tuple(readings),
    )
    if shared:
        per = max(1, descriptors.BITS // (2 * draws))
        z_tot, along = None, k > N_CURVE_SIZES
        for a in range(0, k, per):
            z_tot = _fill(evaluator, out, range(a, min(a + per, k)), tests, z_tot, along)
            progress(draws * min(a + per, k), draws * k)
        out.z_tot[:] = z_tot
        if along:
            _fill_along_curves(evaluator, out, tests)
    else:  # combinations side by side, each with one thread
        alone, done = evaluator.changed(threads=1), []
        out.z_tot[:] = evaluator.describe(evaluator.draw_tests(n_tests))[0]

        def one(i, _):
            _fill(alone, out, [i], tests[i])
            done.append(i)
            progress(draws * len(done), draws * k)

        parallel_map(one, k, evaluator.threads, 1)
    return out


def _fill(evaluator, out, some, tests, z_tot=None, along=False):
    """Draw the subsets of `some` combinations and write what they give at the test dots into a Grid.

    `along`: the uniform subsets that are surfaces of their own are left to `_fill_along_curves`.

    Returns z_tot, which comes with the first subsets unless known: they share the patch of the whole surface.
    """
    draws = out.n_s.shape[1]
    jobs = np.array([(k, draw) for k in some for draw in range(draws)])
    sizes = np.zeros((len(out.readings), 2, len(jobs), len(tests)), np.int32)
    together = tuple(reading for reading in out.readings if reading in OF_GRID)
    for a in range(0, len(jobs), descriptors.BITS // 2):
        part = slice(a, a + descriptors.BITS // 2)
        k, draw = jobs[part].T
        words, subsets = _draw(evaluator, out, jobs[part])
        shape = (2, len(k), len(tests))
        if together:
            z_tot, z, size = evaluator.compare(words, 2 * len(k), tests, together, z_tot)
            z, size = (dict(zip(together, x.reshape(-1, *shape), strict=True)) for x in (z, size))
        else:
            z_tot, z, size = evaluator.describe(tests)[0] if z_tot is None else z_tot, {}, {}
        for r, reading in enumerate(out.readings):
            if reading not in z:
                own = subsets[: len(k)] if along else subsets
                z[reading], size[reading] = (
                    x.reshape(-1, *shape[1:])
                    for x in evaluator.distances(own, tests, z_tot, reading, many=True)
                )
            for half, values in enumerate((out.z_ts, out.z_tr)[: len(z[reading])]):
                values[r, k, draw], sizes[r, half, part] = z[reading][half], size[reading][half]
    out.fragment[:, :, some] = np.median(sizes.reshape(*sizes.shape[:2], len(some), -1), axis=3)
    return z_tot


def _fill_along_curves(evaluator, out, tests):
    """Write what uniform subsets that are surfaces of their own give, by interpolation over ln n_S, draw by draw.

    Each draw has a curve of its own, so that the scatter of the draws holds the error of the curves.
    """
    least, most = np.log(out.n_s.min()), np.log(out.n_s.max())
    sizes = np.unique(np.round(np.exp(np.linspace(least, most, N_CURVE_SIZES))).astype(int))
    places = np.interp(np.log(out.n_s), np.log(sizes), np.arange(len(sizes)))  # among the n_S of the curve
    below, share = places.astype(int), (places % 1)[..., None]
    above = np.ceil(places).astype(int)
    for r in [r for r, reading in enumerate(out.readings) if reading not in OF_GRID]:
        dots = np.empty(out.z_tr[r].shape)
        for draw in range(out.n_s.shape[1]):
            streams = (evaluator.stream("uniform", "curve", n, draw) for n in sizes)
            subsets = [
                published.uniform_subset(out.n_dots, n, rng) for n, rng in zip(sizes, streams, strict=True)
            ]
            curves = evaluator.distances(subsets, tests, out.z_tot, out.readings[r], many=True)
            for values, curve in zip((out.z_tr[r], dots), curves, strict=True):
                low, high = curve[below[:, draw]], curve[above[:, draw]]
                values[:, draw] = low + share[:, draw] * (high - low)
        out.fragment[r, 1] = np.median(dots.reshape(len(dots), -1), axis=1)


def _draw(evaluator, out, jobs):
    """Words of the sampled subsets of (combination, draw), then of the uniform ones; n_S goes into a Grid.

    The subsets themselves come along where a reading needs them.
    """
    words, lock = np.zeros(len(evaluator.points), np.uint64), Lock()
    keep = any(reading not in OF_GRID for reading in out.readings)
    subsets = [None] * (2 * len(jobs) if keep else 0)

    def one(i, _):
        k, draw = jobs[i]
        pair = evaluator.pair(out.combinations[k], draw)
        out.n_s[k, draw] = len(pair[0])
        with lock:  # bits at once: 64 subsets of a million dots would need more memory than all else
            for half, subset in enumerate(pair):
                descriptors.add(words, evaluator.index, subset, i + half * len(jobs))
        if keep:
            subsets[i], subsets[i + len(jobs)] = pair

    parallel_map(one, len(jobs), evaluator.threads, 1)
    return words, subsets


def write_grid(path, grid):
    """Write a Grid as npz (no pickles; the same bytes for the same grid)."""
    with open(path, "wb") as stream:
        np.savez(stream, **{f.name: np.asarray(getattr(grid, f.name)) for f in fields(Grid)})


def read_grid(path):
    """Read what `save` wrote; raises InputError where the file is damaged."""
    try:
        with np.load(path, allow_pickle=False) as data:
            values = {f.name: data[f.name] for f in fields(Grid)}
    except (KeyError, ValueError, OSError, EOFError, BadZipFile) as error:
        raise InputError(f"{path} is damaged ({error}): delete it, it is made again.") from None
    return Grid(**values | {"n_dots": int(values["n_dots"]), "readings": tuple(map(str, values["readings"]))})
