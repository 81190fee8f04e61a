"""A surface prepared for many evaluations of its subsets.

Source: paper, 'Optimization of the sampling parameters'.
"""

import copy
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, Self

import numpy as np

from sparsurf.patches import descriptors
from sparsurf.patches.index import D_LINK, R_PATCH, R_ZERNIKE, PatchIndex, build_index
from sparsurf.patches.readings import GRID_READINGS
from sparsurf.patches.roughness import PUBLISHED, roughness
from sparsurf.recovery.readings import READINGS
from sparsurf.sampling import published
from sparsurf.sampling.combination import Combination
from sparsurf.streams import stream
from sparsurf.surfaces.spacing import area_of
from sparsurf.threads import parallel_map

DOTS_PER_PUBLISHED_TEST = 200  # the authors test N / 200 dots


class PreparedSurface:
    """A surface prepared for many evaluations: index, roughness and cover are computed once.

    Parameters
    ----------
    surface : object with `points` and `normals`, (N, 3) float64
    r_patch, r_zernike, d_link : float
        Å.
    roughness_values : (N,) float64, optional
        R_i, if already known.
    seed : int
    name : str
        Conformation; names the random streams.
    threads : int
    distance_from_moved_centre, chance_in_every_patch : bool
        The two defects of the published sampling, see `published.build_cover`.
    descriptor : str
        Name in `descriptors.DESCRIPTORS`.
    roughness_kind : str
        Kind of roughness if its values are not given, see `roughness.ROUGHNESS`.
    """

    def __init__(
        self,
        surface: Any,
        r_patch: float = R_PATCH,
        r_zernike: float = R_ZERNIKE,
        d_link: float = D_LINK,
        roughness_values: np.ndarray | None = None,
        seed: int = 0,
        name: str = "",
        threads: int = 1,
        distance_from_moved_centre: bool = True,
        chance_in_every_patch: bool = True,
        descriptor: str = descriptors.PUBLISHED,
        roughness_kind: str = PUBLISHED,
    ) -> None:
        self.points: np.ndarray = surface.points
        self.normals: np.ndarray = surface.normals
        self.surface = surface
        self.r_patch, self.r_zernike, self.d_link, self.threads = r_patch, r_zernike, d_link, threads
        self.seed, self.name, self.descriptor = seed, name, descriptor
        self.stream_name = name
        self.index: PatchIndex = build_index(surface.points, surface.normals, d_link)
        self.roughness: np.ndarray = (
            roughness(self.index, r_patch, threads, roughness_kind)
            if roughness_values is None
            else roughness_values
        )
        self.cover = published.build_cover(
            self.index, self.roughness, r_patch, distance_from_moved_centre, chance_in_every_patch
        )

    def __repr__(self) -> str:
        return f"PreparedSurface of {len(self):,} dots"

    def __len__(self) -> int:
        return len(self.points)

    @cached_property
    def corrected_cover(self) -> published.Cover:
        """The cover without the two defects of the published sampling."""
        return published.build_cover(self.index, self.roughness, self.r_patch, False, False)

    @cached_property
    def area(self) -> float:
        """Area in Å^2, estimated if the surface has no areas."""
        return area_of(self.surface)[0]

    @property
    def density(self) -> float:
        """Dots per Å^2."""
        return len(self.points) / self.area

    def stream(self, *keys: Any) -> np.random.Generator:
        """Return the random stream of this conformation for one purpose."""
        return stream(self.seed, self.stream_name, *keys)

    @property
    def with_shared_streams(self) -> Self:
        """The same surface with random streams that do not depend on its name, for the minimal subset."""
        return self.changed(stream_name="")

    def draw_tests(self, n_tests: int, *keys: Any) -> np.ndarray:
        """Draw `n_tests` test dots (all dots if there are fewer), ascending."""
        n = len(self.points)
        return published.uniform_subset(n, min(n_tests, n), self.stream("tests", *keys))

    def sampled(self, combination: Sequence[float], draw: int) -> np.ndarray:
        """Return the sampled subset of one draw, ascending."""
        keys = Combination(*combination).keys()
        return published.sample(self.cover, combination, self.stream("sampled", *keys, draw))

    def uniform_order(self, draw: int) -> np.ndarray:
        """Return all dots in the random order of one draw: the first n are its uniform subset of n dots."""
        return self.stream("uniform", draw).permutation(len(self.points))

    def uniform(self, n_s: int, draw: int) -> np.ndarray:
        """Return the uniform subset of `n_s` dots of one draw, ascending."""
        return np.sort(self.uniform_order(draw)[:n_s])

    def pair(self, combination: Sequence[float], draw: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the sampled subset of one draw and the uniform subset of the same size."""
        sampled = self.sampled(combination, draw)
        return sampled, self.uniform(len(sampled), draw)

    def describe(self, tests: np.ndarray, up: bool = True) -> tuple[np.ndarray, np.ndarray]:
        """Compute descriptors of the full surface at test dots, (T, 121), and the patch sizes, (T,)."""
        return descriptors.describe(
            self.index, self.points[tests], self.r_zernike, up, self.threads, self.descriptor
        )

    def distances(
        self,
        subsets: Sequence[np.ndarray],
        tests: np.ndarray,
        z_tot: np.ndarray,
        reading: str,
        weights: np.ndarray | None = None,
        many: bool = False,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Compute |z_tot - z| of B subsets at T test dots under one reading, (B, T), and the dots in their patches, (B, T).

        `z_tot` (T, 121) are descriptors of the full surface at the test dots; `weights` (B, N), by position, are for readings
        of the full surface only. `many` takes the faster variant of a reading, see `build_index_fast` of `readings.Reading`.
        """
        alone = (many and READINGS[reading].build_index_fast) or READINGS[reading].build_index
        if alone:
            single = self.changed(threads=1)
            results = parallel_map(
                lambda k, _: single.distances_alone(subsets[k], tests, z_tot, alone),
                len(subsets),
                self.threads,
                1,
            )
            z, sizes = (np.array(values) for values in zip(*results, strict=True))
            return z, sizes
        _, z, sizes = self._compare_in_passes(subsets, tests, (reading,), z_tot, weights)
        return z[0], sizes[0]

    def distances_under(
        self, readings: Sequence[str], subsets: Sequence[np.ndarray], tests: np.ndarray
    ) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Compute z_tot at the test dots, (T, 121), and |z_tot - z| of subsets: a dict of reading -> (B, T) float64."""
        together = tuple(reading for reading in readings if reading in GRID_READINGS)
        z_tot, z, _ = self._compare_in_passes(subsets, tests, together)
        by_reading = dict(zip(together, z, strict=True))
        for reading in readings:
            if reading not in by_reading:
                by_reading[reading] = self.distances(subsets, tests, z_tot, reading)[0]
        return z_tot, by_reading

    def _compare_in_passes(
        self,
        subsets: Sequence[np.ndarray],
        tests: np.ndarray,
        readings: Sequence[str],
        z_tot: np.ndarray | None = None,
        weights: np.ndarray | None = None,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Run `compare` on any number of subsets: z_tot, distances and patch sizes, (R, B, T)."""
        distances, sizes = [], []
        for a in range(0, len(subsets), descriptors.MAX_SUBSETS):
            part = subsets[a : a + descriptors.MAX_SUBSETS]
            words = descriptors.pack_subsets(self.index, part)
            weight = None if weights is None else weights[a : a + descriptors.MAX_SUBSETS]
            z_tot, z, size = self.compare(words, len(part), tests, readings, z_tot, weight)
            shape = (len(readings), len(part), len(tests))
            distances.append(z.reshape(shape))
            sizes.append(size.reshape(shape))
        assert z_tot is not None  # there is a subset at least
        return z_tot, np.concatenate(distances, axis=1), np.concatenate(sizes, axis=1)

    def compare(
        self,
        words: np.ndarray,
        n_subsets: int,
        tests: np.ndarray,
        readings: Sequence[str],
        z_tot: np.ndarray | None,
        weights: np.ndarray | None = None,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Compute z_tot, and distances and patch sizes, (R B, T), of packed subsets under some readings in one pass."""
        z_tot, z, sizes = descriptors.compare(
            self.index,
            self.points[tests],
            words,
            n_subsets,
            readings,
            z_tot,
            weights,
            self.r_zernike,
            threads=self.threads,
            descriptor=self.descriptor,
        )
        return z_tot, z.T, sizes.T

    def compare_uniform(
        self, draw: int, sizes: np.ndarray, tests: np.ndarray, readings: Sequence[str], z_tot: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Compute distances and patch sizes, (R, S, T), of the uniform subsets of one draw with `sizes` dots, ascending."""
        return descriptors.compare_nested(
            self.index,
            self.points[tests],
            self.uniform_order(draw),
            sizes,
            readings,
            z_tot,
            self.r_zernike,
            threads=self.threads,
            descriptor=self.descriptor,
        )

    def distances_alone(
        self, subset: np.ndarray, tests: np.ndarray, z_tot: np.ndarray, alone: Callable[..., PatchIndex]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Compute |z_tot - z| of one subset that forms its own surface, (T,), and patch sizes, (T,).

        `alone` is `build_index` of a `readings.Reading`.
        """
        index = alone(self.points[subset], self.normals[subset], self.d_link, self.area, self.density)
        return self.distances_to_index(index, tests, z_tot)

    def distances_to_index(
        self, index: PatchIndex, tests: np.ndarray, z_tot: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Compute |z_tot - z| and patch sizes, (T,), of another surface, given its PatchIndex, at test dots of this one."""
        all_dots = np.ones(len(index.dot), np.uint64)
        z, sizes = descriptors.evaluate(
            index,
            self.points[tests],
            all_dots,
            1,
            "kept",
            z_tot,
            radius=self.r_zernike,
            threads=self.threads,
            descriptor=self.descriptor,
        )
        return z[:, 0], sizes[:, 0]

    def changed(self, **changes: Any) -> Self:
        """Return a copy with some attributes changed."""
        other = copy.copy(self)
        vars(other).update(changes)
        return other


def number_of_tests(requested: int | str, n_dots: int) -> int:
    """Return the number of test dots: the request, or N / 200 for 'published'; at least 2 and at most N."""
    n_tests = n_dots // DOTS_PER_PUBLISHED_TEST if isinstance(requested, str) else requested
    return max(2, min(n_tests, n_dots))


def prepare_surface(
    surface: Any,
    patches: dict,
    roughness_values: np.ndarray | None,
    seed: int,
    name: str,
    threads: int = 1,
    distance_from_moved_centre: bool = True,
    chance_in_every_patch: bool = True,
) -> PreparedSurface:
    """Prepare a surface with the section `patches` of a config; without `roughness_values`, R_i is computed.

    `name`, of the conformation, names the random streams; for the last two arguments see `build_cover`.
    """
    return PreparedSurface(
        surface,
        r_patch=patches["R_patch"],
        r_zernike=patches["R_zernike"],
        d_link=patches["D_link"],
        roughness_values=roughness_values,
        seed=seed,
        name=name,
        threads=threads,
        distance_from_moved_centre=distance_from_moved_centre,
        chance_in_every_patch=chance_in_every_patch,
        descriptor=patches.get("descriptor", descriptors.PUBLISHED),
        roughness_kind=patches.get("roughness", PUBLISHED),
    )
