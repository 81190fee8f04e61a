"""How well subsets describe a surface: z_tot, z_S, z_R, their distances and intervals.

Source: paper, 'Optimization of the sampling parameters'. The same test dots serve all
combinations unless asked otherwise, so that combinations differ by what they keep only.
"""

import copy
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from threading import Lock

import numpy as np
from threadpoolctl import threadpool_limits

from sparsurf import descriptors, sampling
from sparsurf.parallel import over_slices, stream
from sparsurf.patches import D_LINK, R_PATCH, R_ZERNIKE, build_index
from sparsurf.roughness import roughness

READINGS = ("kept", "surface")
SCALE = 1.6  # linking distance of the reading 'scaled', in mean spacings of the kept dots
AS_PUBLISHED_SHARE = 200  # the authors test N / 200 dots
# Table I of the paper: limits of the ranges of n_S in %, alpha, beta, gamma, delta, d and Z_tS
TABLE_1 = np.genfromtxt(Path(__file__).with_name("published_table1.csv"), delimiter=",", names=True)
PUBLISHED_ROWS = np.stack([TABLE_1[name] for name in ("alpha", "beta", "gamma", "delta")], axis=1)


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
        self.points, self.normals = surface.points, surface.normals
        self.r_patch, self.r_zernike, self.d_link, self.threads = r_patch, r_zernike, d_link, threads
        self.choices = (TABLE_1["n_S_low_percent"], PUBLISHED_ROWS)
        self.seed, self.name = seed, name
        self.index = build_index(surface.points, surface.normals, d_link)
        self.roughness = (
            roughness(self.index, r_patch, threads) if roughness_values is None else roughness_values
        )
        self.cover = sampling.build_cover(self.index, self.roughness, r_patch, moved_centre, every_patch)

    @classmethod
    def from_settings(cls, surface, settings, roughness_values, name, threads):
        """From the config's `patches`, `sampling` and `seed`."""
        patches, defects = settings["patches"], settings["sampling"]
        return cls(
            surface,
            patches["R_patch"],
            patches["R_zernike"],
            patches["D_link"],
            roughness_values,
            settings["seed"],
            name,
            threads,
            defects["moved_centre"],
            defects["every_patch"],
        )

    def choices_of_paper(self, n_s):
        """Combinations chosen by d for the range of n_S that holds `n_s` dots and for the ranges above it."""
        lowest, rows = self.choices
        place = np.searchsorted(lowest, 100 * n_s / len(self.points))
        return rows[int(np.clip(place, 1, len(rows))) - 1 :]

    @cached_property
    def corrected_cover(self):
        """The cover without the two defects of the published sampling."""
        return sampling.build_cover(self.index, self.roughness, self.r_patch, False, False)

    def stream(self, *keys):
        """Random stream of this conformation for one purpose."""
        return stream(self.seed, self.name, *keys)

    def draw_tests(self, n_tests, *keys):
        """`n_tests` test dots (all where the surface has fewer), ascending."""
        n = len(self.points)
        return sampling.uniform(n, min(n_tests, n), self.stream("tests", *keys))

    def pair(self, combination, draw):
        """The sampled subset of one draw and a uniform one of the same size."""
        keys = _exact(combination)  # by value: streams do not depend on the grid's order
        sampled = sampling.sample(self.cover, combination, self.stream("sampled", *keys, draw))
        return sampled, sampling.uniform(len(self.points), len(sampled), self.stream("uniform", *keys, draw))

    def describe(self, tests, up=True):
        """Descriptors of the full surface at test dots, (T, 121), and the patch sizes, (T,)."""
        return descriptors.describe(self.index, self.points[tests], self.r_zernike, up, self.threads)

    def distances(self, subsets, tests, z_tot, reading, weights=None):
        """|z_tot - z| of subsets at the test dots: (B, T) float64, and patch sizes, (B, T)."""
        z, sizes = [], []
        for a in range(0, len(subsets), descriptors.BITS):
            some = subsets[a : a + descriptors.BITS]
            words = descriptors.pack(self.index, some)
            weight = None if weights is None else weights[a : a + descriptors.BITS]
            _, result, size = self._compare(words, len(some), tests, (reading,), z_tot, weight)
            z.append(result)
            sizes.append(size)
        return np.concatenate(z), np.concatenate(sizes)

    def _compare(self, words, n_subsets, tests, readings, z_tot, weights=None):
        """z_tot, then (R B, T) distances and patch sizes of the subsets of packed words, by reading."""
        place, radius = self.points[tests], self.r_zernike
        z_tot, z, sizes = descriptors.compare(
            self.index, place, words, n_subsets, readings, z_tot, weights, radius, threads=self.threads
        )
        return z_tot, z.T, sizes.T

    def distances_scaled(self, subset, tests, z_tot, area):
        """|z_tot - z| of one subset as if its surface were not known, (T,), and patch sizes, (T,).

        Islands are removed among the kept dots, linked within `SCALE` times their mean spacing, 1 / sqrt(kept dots
        per Å^2), and at least D_link; `area` is that of the surface in Å^2.
        """
        link = max(self.d_link, SCALE * np.sqrt(area / len(subset)))
        alone = build_index(self.points[subset], self.normals[subset], link)
        everything = np.ones(len(subset), np.uint64)
        z, sizes = descriptors.evaluate(
            alone,
            self.points[tests],
            everything,
            1,
            "kept",
            z_tot,
            radius=self.r_zernike,
            threads=self.threads,
        )
        return z[:, 0], sizes[:, 0]

    def by_position(self, subset, values):
        """`values` (n,) of the dots of a subset as the (1, N) weights that `distances` takes."""
        out = np.zeros((1, len(self.points)))
        out[0, self.index.position[subset]] = values
        return out

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
        combinations = np.asarray(combinations, float)
        tests = self.draw_tests(n_tests)
        if not shared:
            tests = np.array([self.draw_tests(n_tests, *_exact(c)) for c in combinations])
        k, shape = len(combinations), (len(readings), len(combinations), draws, tests.shape[-1])
        with threadpool_limits(1, "blas"):
            out = Grid(
                combinations=combinations,
                n_dots=len(self.points),
                n_s=np.empty((k, draws), np.int64),
                n_s_expected=sampling.expected_n_s(self.cover, combinations),
                tests=tests,
                z_tot=np.empty((tests.shape[-1], descriptors.N_Z)),
                z_ts=np.empty(shape, np.float32),
                z_tr=np.empty(shape, np.float32),
                fragment=np.empty((len(readings), 2, k)),
                readings=tuple(readings),
            )
            if shared:
                per = max(1, descriptors.BITS // (2 * draws))
                z_tot = None
                for a in range(0, k, per):
                    z_tot = self._fill(out, range(a, min(a + per, k)), tests, z_tot)
                    progress(draws * min(a + per, k), draws * k)
                out.z_tot[:] = z_tot
            else:  # combinations side by side, each with one thread
                alone, done = self._with(threads=1), []
                out.z_tot[:] = self.describe(self.draw_tests(n_tests))[0]

                def one(i, _):
                    alone._fill(out, [i], tests[i])
                    done.append(i)
                    progress(draws * len(done), draws * k)

                over_slices(one, k, self.threads, 1)
        return out

    def _fill(self, out, some, tests, z_tot=None):
        """Draw the subsets of `some` combinations and write what they give at the test dots into a Grid.

        Returns z_tot, which comes with the first subsets unless known: they share the patch of the whole surface.
        """
        draws = out.n_s.shape[1]
        jobs = np.array([(k, draw) for k in some for draw in range(draws)])
        sizes = np.empty((len(out.readings), 2, len(jobs), len(tests)), np.int32)
        for a in range(0, len(jobs), descriptors.BITS // 2):
            part = slice(a, a + descriptors.BITS // 2)
            k, draw = jobs[part].T
            words = self._draw(out, jobs[part])
            z_tot, z, size = self._compare(words, 2 * len(k), tests, out.readings, z_tot)
            shape = (len(out.readings), 2, len(k), len(tests))
            out.z_ts[:, k, draw], out.z_tr[:, k, draw] = z.reshape(shape).swapaxes(0, 1)
            sizes[:, :, part] = size.reshape(shape)
        out.fragment[:, :, some] = np.median(sizes.reshape(*sizes.shape[:2], len(some), -1), axis=3)
        return z_tot

    def _draw(self, out, jobs):
        """Words of the sampled subsets of (combination, draw), then of the uniform ones; n_S goes into a Grid."""
        words, lock = np.zeros(len(self.points), np.uint64), Lock()

        def one(i, _):
            k, draw = jobs[i]
            pair = self.pair(out.combinations[k], draw)
            out.n_s[k, draw] = len(pair[0])
            with lock:  # bits at once: 64 subsets of a million dots would need more memory than all else
                for half, subset in enumerate(pair):
                    descriptors.add(words, self.index, subset, i + half * len(jobs))

        over_slices(one, len(jobs), self.threads, 1)
        return words

    def _with(self, **changes):
        """This evaluator with some attributes changed."""
        other = copy.copy(self)
        vars(other).update(changes)
        return other

    def renamed(self, name):
        """The same surface with random streams of another name."""
        return self._with(name=name)

    def relinked(self, d_link):
        """The same surface, samplings and roughness, islands linked at another distance (Å)."""
        return self._with(index=build_index(self.points, self.normals, d_link))


def _exact(combination):
    """The parameters in millionths, as keys of a random stream."""
    return [round(1e6 * p) for p in combination]


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
    rows = len(z_tot) - 1
    apart = sum(np.linalg.norm(z_tot[i + 1 :] - z_tot[i], axis=1).sum() for i in range(rows))
    return {
        "empty_patch": float(np.linalg.norm(z_tot, axis=1).mean()),
        "null_model": float(np.linalg.norm(z_tot - z_tot.mean(axis=0), axis=1).mean()),
        "two_patches": float(apart / (rows * (rows + 1) / 2)) if rows else float("nan"),
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
