"""How well subsets describe a surface: z_tot, z_S, z_R, their distances and intervals.

Source: paper, 'Optimization of the sampling parameters'. The same test dots serve all
combinations unless asked otherwise, so that combinations differ by what they keep only.
"""

from dataclasses import dataclass, fields

import numpy as np
from threadpoolctl import threadpool_limits

from sparsurf import descriptors, sampling
from sparsurf.parallel import over_slices, stream
from sparsurf.patches import D_LINK, R_PATCH, R_ZERNIKE, build_index
from sparsurf.roughness import roughness

READINGS = ("kept", "surface")
AS_PUBLISHED_SHARE = 200  # the authors test N / 200 dots
TABLE_1 = (  # Table I of the paper: lower limits of the ranges of n_S in %, and alpha, beta, gamma, delta
    (2.63, 12.34, 22.05, 31.76, 41.47, 51.18, 60.89, 70.60, 80.30, 90.01),
    (
        (0.4, 0.2, 10, 10),
        (1.0, 0.4, 10, 6),
        (1.0, 0.2, 6, 10),
        (1.0, 0.0, 6, 4),
        (1.0, 0.0, 6, 0),
        (1.0, 0.0, 2, 4),
        (1.0, 0.2, 0, 4),
        (1.0, 0.0, 2, 0),
        (1.0, 0.0, 0, 2),
        (1.0, 0.2, 0, 0),
    ),
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
    fragment : (readings, K) float64, median number of dots in the evaluated patches of the samplings
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


class Evaluator:
    """A surface made ready for many evaluations: index, roughness and cover, computed once.

    Parameters
    ----------
    surface : object with `points` and `normals`, (N, 3) float64
    r_patch, r_zernike, d_link : float
        Å.
    roughness_values : (N,) float64, optional
        R_i where already known.
    seed : int
    name : str
        Conformation, names the random streams.
    threads : int
    moved_centre, every_patch : bool
        The two defects of the published sampling, see `sampling.build_cover`.
    """

    def __init__(
        self,
        surface,
        r_patch=R_PATCH,
        r_zernike=R_ZERNIKE,
        d_link=D_LINK,
        roughness_values=None,
        seed=0,
        name="",
        threads=1,
        moved_centre=True,
        every_patch=True,
    ):
        self.points, self.r_zernike, self.threads = surface.points, r_zernike, threads
        self.seed, self.name = seed, name
        self.index = build_index(surface.points, surface.normals, d_link)
        self.roughness = (
            roughness(self.index, r_patch, threads) if roughness_values is None else roughness_values
        )
        self.cover = sampling.build_cover(self.index, self.roughness, r_patch, moved_centre, every_patch)

    def choices_of_paper(self, n_s):
        """Combinations of Table I for the range that holds `n_s` dots and for the ranges above it."""
        limits, rows = TABLE_1
        return rows[int(np.clip(np.searchsorted(limits, 100 * n_s / len(self.points)), 1, len(rows))) - 1 :]

    def stream(self, *keys):
        """Random stream of this conformation for one purpose."""
        return stream(self.seed, self.name, *keys)

    def draw_tests(self, n_tests, *keys):
        """`n_tests` test dots (all where the surface has fewer), ascending."""
        n = len(self.points)
        return sampling.uniform(n, min(n_tests, n), self.stream("tests", *keys))

    def pair(self, combination, draw):
        """The sampled subset of one draw and a uniform one of the same size."""
        keys = [round(1e6 * p) for p in combination]  # by value: streams do not depend on the grid's order
        sampled = sampling.sample(self.cover, combination, self.stream("sampled", *keys, draw))
        return sampled, sampling.uniform(len(self.points), len(sampled), self.stream("uniform", *keys, draw))

    def describe(self, tests, up=True):
        """Descriptors of the full surface at test dots, (T, 121), and the patch sizes, (T,)."""
        return descriptors.describe(self.index, self.points[tests], self.r_zernike, up, self.threads)

    def distances(self, subsets, tests, z_tot, reading, weights=None):
        """|z_tot - z| of up to 64 subsets at the test dots: (B, T) float64, and patch sizes, (B, T)."""
        words = descriptors.pack(self.index, subsets)
        z, sizes = descriptors.evaluate(
            self.index,
            self.points[tests],
            words,
            len(subsets),
            reading,
            z_tot,
            weights,
            radius=self.r_zernike,
            threads=self.threads,
        )
        return z.T, sizes.T

    def grid(
        self, combinations, n_tests, draws=1, readings=READINGS, shared=True, progress=lambda done, of: None
    ):
        """Evaluate every combination.

        Parameters
        ----------
        combinations : (K, 4) float64
        n_tests : int
            T.
        draws : int
            D, samplings and uniform subsets per combination.
        readings : tuple of {'kept', 'surface'}
        shared : bool
            The same test dots for all combinations; False draws them anew for each, as published.
        progress : callable
            Told how many of how many samplings are done.

        Returns
        -------
        Grid
        """
        k = len(combinations)
        expected = sampling.expected_n_s(self.cover, combinations)
        tests = self.draw_tests(n_tests)
        shape = (len(readings), k, draws, len(tests))
        z_ts, z_tr = np.empty(shape, np.float32), np.empty(shape, np.float32)
        fragment, n_s = np.empty(shape[:2]), np.empty((k, draws), np.int64)
        with threadpool_limits(1, "blas"):
            z_tot, _ = self.describe(tests)
            if shared:
                self._shared(combinations, tests, z_tot, readings, z_ts, z_tr, n_s, fragment, progress)
            else:
                tests = np.array(
                    [self.draw_tests(n_tests, *[round(1e6 * p) for p in c]) for c in combinations]
                )
                self._fresh(combinations, tests, readings, z_ts, z_tr, n_s, fragment, progress)
        return Grid(
            np.asarray(combinations, float),
            len(self.points),
            n_s,
            expected,
            tests,
            z_tot,
            z_ts,
            z_tr,
            fragment,
            tuple(readings),
        )

    def _shared(self, combinations, tests, z_tot, readings, z_ts, z_tr, n_s, fragment, progress):
        """All subsets against the same test dots, 64 at a time."""
        draws = n_s.shape[1]
        jobs = [(k, draw) for k in range(len(combinations)) for draw in range(draws)]
        sizes = np.empty((len(readings), len(jobs), len(tests)), np.int32)
        for a in range(0, len(jobs), descriptors.BITS):
            batch = jobs[a : a + descriptors.BITS]
            pairs = over_slices(
                lambda i, _, b=batch: self.pair(combinations[b[i][0]], b[i][1]), len(batch), self.threads, 1
            )
            k, draw = np.array(batch).T
            n_s[k, draw] = [len(sampled) for sampled, _ in pairs]
            for r, reading in enumerate(readings):
                z, size = self.distances([s for s, _ in pairs], tests, z_tot, reading)
                z_ts[r, k, draw], sizes[r, a : a + len(batch)] = z, size
                z_tr[r, k, draw] = self.distances([u for _, u in pairs], tests, z_tot, reading)[0]
            progress(a + len(batch), len(jobs))
        fragment[:] = np.median(sizes.reshape(len(readings), len(combinations), -1), axis=2)

    def _fresh(self, combinations, tests, readings, z_ts, z_tr, n_s, fragment, progress):
        """Each combination against test dots of its own; combinations side by side."""

        def one(k, _):
            alone = self._alone()
            z_tot, _ = alone.describe(tests[k])
            pairs = [self.pair(combinations[k], draw) for draw in range(n_s.shape[1])]
            n_s[k] = [len(sampled) for sampled, _ in pairs]
            subsets = [s for s, _ in pairs] + [u for _, u in pairs]
            for r, reading in enumerate(readings):
                z, size = alone.distances(subsets, tests[k], z_tot, reading)
                z_ts[r, k], z_tr[r, k] = z[: len(pairs)], z[len(pairs) :]
                fragment[r, k] = np.median(size[: len(pairs)])
            progress(k + 1, len(combinations))

        over_slices(one, len(combinations), self.threads, 1)

    def _alone(self):
        """This evaluator with one thread, for work that is itself one of several side by side."""
        import copy

        alone = copy.copy(self)
        alone.threads = 1
        return alone


def number_of_tests(wished, n_dots):
    """Number of test dots: as wished, or N / 200 for 'published'; never more than there are, at least 2."""
    return max(2, min(n_dots // AS_PUBLISHED_SHARE if wished == "published" else wished, n_dots))


def mean_and_error(x):
    """Mean over draws and test dots, and its standard error.

    Test dots and draws both count as drawn at random (two-way random effects): the variance of
    the mean is (MS_tests + MS_draws - MS_rest) / (D T), at least MS_rest / (D T). With one draw
    only the test dots' scatter can be seen.

    Parameters
    ----------
    x : (..., D, T)

    Returns
    -------
    mean, error : (...) float64; the error is NaN for a single test dot.
    """
    x = np.asarray(x, np.float64)
    d, t = x.shape[-2:]
    mean = x.mean(axis=(-2, -1))
    if t < 2:
        return mean, np.full_like(mean, np.nan)
    by_test, by_draw = x.mean(axis=-2), x.mean(axis=-1)
    tests = d * by_test.var(axis=-1, ddof=1)
    if d == 1:
        return mean, np.sqrt(tests / t)
    draws = t * by_draw.var(axis=-1, ddof=1)
    rest = x - by_test[..., None, :] - by_draw[..., :, None] + mean[..., None, None]
    rest = (rest**2).sum(axis=(-2, -1)) / ((d - 1) * (t - 1))
    return mean, np.sqrt(np.maximum(tests + draws - rest, rest) / (d * t))


def halves(x):
    """Means over two halves that share neither test dots nor (with two draws or more) draws.

    Selecting on one and reporting on the other frees a reported value of selection bias.

    Parameters
    ----------
    x : (..., D, T)

    Returns
    -------
    (2, ...) float64
    """
    cut = x.shape[-2] // 2
    first, second = (x[..., :cut, ::2], x[..., cut:, 1::2]) if cut else (x[..., ::2], x[..., 1::2])
    return np.stack([np.mean(h, axis=(-2, -1), dtype=np.float64) for h in (first, second)])


def yardsticks(z_tot):
    """What every table of Z needs beside it, from the descriptors of the full surface.

    Parameters
    ----------
    z_tot : (T, 121)

    Returns
    -------
    dict: `empty_patch`, mean |z_tot|, what a patch of one dot costs; `null_model`, Z when every
    patch is given the mean descriptor; `two_patches`, mean distance of two different patches.
    """
    from scipy.spatial.distance import pdist

    return {
        "empty_patch": float(np.linalg.norm(z_tot, axis=1).mean()),
        "null_model": float(np.linalg.norm(z_tot - z_tot.mean(axis=0), axis=1).mean()),
        "two_patches": float(pdist(z_tot).mean()) if len(z_tot) > 1 else float("nan"),
    }


def save_grid(path, grid):
    """Write a Grid as npz (no pickles; the same bytes for the same grid)."""
    with open(path, "wb") as stream:
        np.savez(stream, **{f.name: np.asarray(getattr(grid, f.name)) for f in fields(Grid)})


def load_grid(path):
    """Read what `save_grid` wrote."""
    with np.load(path, allow_pickle=False) as data:
        values = {f.name: data[f.name] for f in fields(Grid)}
    return Grid(**values | {"n_dots": int(values["n_dots"]), "readings": tuple(map(str, values["readings"]))})
