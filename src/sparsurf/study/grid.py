"""The grid: every combination sampled, its subsets and uniform ones compared with the whole surface.

The same test dots serve all combinations unless asked otherwise, so that combinations differ by what they keep only.
"""

from dataclasses import dataclass, fields
from threading import Lock
from zipfile import BadZipFile

import numpy as np

from sparsurf import InputError
from sparsurf.patches import descriptors
from sparsurf.patches.readings import OF_GRID
from sparsurf.sampling import law
from sparsurf.sampling.combination import Combination
from sparsurf.threads import over_slices


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


def run(
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
        Those of `readings.OF_GRID` come in one pass; each other one costs a surface of its own per subset.
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
        n_s_expected=law.expected_n_s(evaluator.cover, combinations),
        tests=tests,
        z_tot=np.empty((tests.shape[-1], descriptors.DESCRIPTORS[evaluator.descriptor].width)),
        z_ts=np.empty(shape, np.float32),
        z_tr=np.empty(shape, np.float32),
        fragment=np.empty((len(readings), 2, k)),
        readings=tuple(readings),
    )
    if shared:
        per = max(1, descriptors.BITS // (2 * draws))
        z_tot = None
        for a in range(0, k, per):
            z_tot = _fill(evaluator, out, range(a, min(a + per, k)), tests, z_tot)
            progress(draws * min(a + per, k), draws * k)
        out.z_tot[:] = z_tot
    else:  # combinations side by side, each with one thread
        alone, done = evaluator.changed(threads=1), []
        out.z_tot[:] = evaluator.describe(evaluator.draw_tests(n_tests))[0]

        def one(i, _):
            _fill(alone, out, [i], tests[i])
            done.append(i)
            progress(draws * len(done), draws * k)

        over_slices(one, k, evaluator.threads, 1)
    return out


def _fill(evaluator, out, some, tests, z_tot=None):
    """Draw the subsets of `some` combinations and write what they give at the test dots into a Grid.

    Returns z_tot, which comes with the first subsets unless known: they share the patch of the whole surface.
    """
    draws = out.n_s.shape[1]
    jobs = np.array([(k, draw) for k in some for draw in range(draws)])
    sizes = np.empty((len(out.readings), 2, len(jobs), len(tests)), np.int32)
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
                z[reading], size[reading] = (
                    x.reshape(shape) for x in evaluator.distances(subsets, tests, z_tot, reading)
                )
            out.z_ts[r, k, draw], out.z_tr[r, k, draw] = z[reading]
            sizes[r, :, part] = size[reading]
    out.fragment[:, :, some] = np.median(sizes.reshape(*sizes.shape[:2], len(some), -1), axis=3)
    return z_tot


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

    over_slices(one, len(jobs), evaluator.threads, 1)
    return words, subsets


def save(path, grid):
    """Write a Grid as npz (no pickles; the same bytes for the same grid)."""
    with open(path, "wb") as stream:
        np.savez(stream, **{f.name: np.asarray(getattr(grid, f.name)) for f in fields(Grid)})


def load(path):
    """Read what `save` wrote; raises InputError where the file is damaged."""
    try:
        with np.load(path, allow_pickle=False) as data:
            values = {f.name: data[f.name] for f in fields(Grid)}
    except (KeyError, ValueError, OSError, EOFError, BadZipFile) as error:
        raise InputError(f"{path} is damaged ({error}): delete it, it is made again.") from None
    return Grid(**values | {"n_dots": int(values["n_dots"]), "readings": tuple(map(str, values["readings"]))})
