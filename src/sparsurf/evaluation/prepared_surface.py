"""A surface prepared for many evaluations of its subsets.

Source: paper, 'Optimization of the sampling parameters'.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import cache, cached_property, partial
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from sparsurf.patches import descriptors
from sparsurf.patches.index import PatchIndex, build_index
from sparsurf.patches.readings import Reading, ReadingLike, reading_of
from sparsurf.patches.roughness import roughness_of_patches as local_roughness
from sparsurf.sampling import published
from sparsurf.sampling.combination import Combination
from sparsurf.settings import PatchesSettings, Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.spacing import area_of
from sparsurf.threads import parallel_map

DEFAULT_SETTINGS = Settings()
MIN_NESTED = 16  # subsets of one order; fewer are faster one by one
DOTS_PER_PUBLISHED_TEST = 200  # the authors test N / 200 dots


@dataclass(frozen=True, eq=False)
class Sampling:
    """What the published sampling needs of the dots: each value is computed at most once, for all copies that share it."""

    linked: Callable[[], PatchIndex]
    settings: Settings
    given_roughness: np.ndarray | None
    threads: int

    @cached_property
    def roughness(self) -> np.ndarray:
        """R_i of every dot."""
        if self.given_roughness is not None:
            return self.given_roughness
        patches = self.settings.patches
        return local_roughness(self.linked(), patches.r_patch, self.threads, patches.roughness)

    @cached_property
    def cover(self) -> published.Cover:
        """The patches of the published sampling, with the two rules of the settings."""
        rules = self.settings.sampling
        return self.cover_by(rules.distance_from_moved_centre, rules.chance_in_every_patch)

    @cached_property
    def corrected_cover(self) -> published.Cover:
        """The patches without the two defects of the published sampling."""
        return self.cover_by(False, False)

    def cover_by(self, *rules: bool) -> published.Cover:
        """Return the patches of the published sampling with two rules, see `published.build_cover`."""
        return published.build_cover(self.linked(), self.roughness, self.settings.patches.r_patch, *rules)


@dataclass(frozen=True, eq=False, init=False, repr=False)
class PreparedSurface:
    """A surface prepared for many evaluations: its index, roughness and cover are computed at most once.

    It cannot be changed. `with_dots`, `with_link`, `with_cover`, `with_descriptor`, `with_streams` and `with_threads` return a
    copy in which one thing differs, together with everything that follows from it.

    Parameters
    ----------
    surface : object with `points` and `normals`, (N, 3) float64
    settings : Settings
        Its `patches`, and the two rules of its `sampling`, see `published.build_cover`.
    roughness : (N,) float64, optional
        R_i, if already known.
    streams : Streams
        Of the conformation.
    threads : int
    """

    surface: Any
    settings: Settings
    stream: Streams
    threads: int
    linked: Callable[[], PatchIndex]  # the index of the dots, built when it is first needed
    sampling: Sampling
    given_cover: published.Cover | None

    def __init__(
        self,
        surface: Any,
        settings: Settings = DEFAULT_SETTINGS,
        roughness: np.ndarray | None = None,
        streams: Streams = Streams(),  # noqa: B008, frozen
        threads: int = 1,
    ) -> None:
        linked = _linked(surface, settings.patches.d_link)
        self._set(
            surface=surface,
            settings=settings,
            stream=streams,
            threads=threads,
            linked=linked,
            sampling=Sampling(linked, settings, roughness, threads),
            given_cover=None,
        )

    def __repr__(self) -> str:
        return f"PreparedSurface of {len(self):,} dots"

    def __len__(self) -> int:
        return len(self.points)

    @property
    def points(self) -> np.ndarray:
        """Positions of the dots, (N, 3), Å."""
        return self.surface.points

    @property
    def normals(self) -> np.ndarray:
        """Outward unit normals of the dots, (N, 3)."""
        return self.surface.normals

    @property
    def index(self) -> PatchIndex:
        """The index of the dots."""
        return self.linked()

    @property
    def patches(self) -> PatchesSettings:
        """Radii of the patches, the link, and how a patch is described."""
        return self.settings.patches

    @property
    def roughness(self) -> np.ndarray:
        """R_i of all dots, (N,) float64, computed when it is first read."""
        return self.sampling.roughness

    @property
    def cover(self) -> published.Cover:
        """The cover of the published sampling."""
        return self.sampling.cover if self.given_cover is None else self.given_cover

    @property
    def corrected_cover(self) -> published.Cover:
        """The cover without the two defects of the published sampling."""
        return self.sampling.corrected_cover

    @cached_property
    def area(self) -> float:
        """Area in Å^2, estimated if the surface has no areas."""
        return area_of(self.surface)[0]

    @property
    def density(self) -> float:
        """Dots per Å^2."""
        return len(self.points) / self.area

    @property
    def name(self) -> str:
        """Name of the conformation, for messages."""
        return self.stream.name

    @property
    def _kernel(self) -> dict[str, Any]:
        """How patches are described."""
        patches = self.patches
        return {"radius": patches.r_zernike, "descriptor": patches.descriptor, "threads": self.threads}

    def draw_tests(self, n_tests: int, *keys: Any) -> np.ndarray:
        """Draw `n_tests` test dots (all dots if there are fewer), ascending."""
        n = len(self.points)
        return published.uniform_subset(n, min(n_tests, n), self.stream("tests", *keys))

    def sampled(self, combination: Sequence[float], draw: int) -> np.ndarray:
        """Return the sampled subset of one draw, ascending, from random numbers of the combination's own, as published."""
        keys = Combination(*combination).keys()
        return published.sample_cover(self.cover, combination, self.stream("sampled", *keys, draw))

    def sampled_together(self, combinations: ArrayLike, draw: int) -> published.SubsetsOfDraw:
        """Return the sampled subsets of combinations (K, 4) in one draw, in which all combinations share their random numbers."""
        random = self.stream("pairs", draw).standard_exponential(self.cover.start[-1])
        return published.sample_together(self.cover, combinations, random)

    def uniform_order(self, draw: int) -> np.ndarray:
        """Return all dots in the random order of one draw: the first n are its random subset of n dots."""
        return self.stream("uniform", draw).permutation(len(self.points))

    def uniform(self, n_s: int, draw: int) -> np.ndarray:
        """Return the random subset of `n_s` dots of one draw, ascending."""
        return np.sort(self.uniform_order(draw)[:n_s])

    def pair(self, combination: Sequence[float], draw: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the sampled subset of one draw and the random subset of the same size."""
        sampled = self.sampled_together([tuple(combination)], draw).subset(0)
        return sampled, self.uniform(len(sampled), draw)

    def describe(self, tests: np.ndarray, up: bool = True) -> tuple[np.ndarray, np.ndarray]:
        """Compute descriptors of the full surface at test dots, (T, width), and the patch sizes, (T,)."""
        return descriptors.describe_patches(self.index, self.points[tests], up=up, **self._kernel)

    def distances(
        self,
        subsets: Sequence[np.ndarray],
        tests: np.ndarray,
        z_tot: np.ndarray,
        reading: ReadingLike,
        weights: np.ndarray | None = None,
        approximate: bool = False,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return distances and patch sizes of `compare` under one reading, (B, T) each."""
        _, z, sizes = self.compare(subsets, tests, (reading,), z_tot, weights, approximate)
        return z[0], sizes[0]

    def compare(
        self,
        subsets: Sequence[np.ndarray],
        tests: np.ndarray,
        readings: Sequence[ReadingLike],
        z_tot: np.ndarray | None = None,
        weights: np.ndarray | None = None,
        approximate: bool = False,
        packed: tuple[np.ndarray, int] | None = None,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Compute |z_tot - z| of B subsets at T test dots, (R, B, T), and the dots in their patches, (R, B, T); after z_tot.

        `z_tot` (T, width) is computed in the same pass unless given. `weights` (B, N), by position, are for readings of the full
        surface only. With `approximate`, readings in which a subset forms a surface of its own form it faster, with more error.
        Subsets that are `packed` into words, and their number, are needed again only by such readings.
        """
        together = tuple(reading for reading in readings if reading_of(reading).build_index is None)
        found: dict[ReadingLike, tuple[np.ndarray, np.ndarray]] = {}
        if together:
            z_tot, z, sizes = self._compare_together(subsets, tests, together, z_tot, weights, packed)
            found = dict(zip(together, zip(z, sizes, strict=True), strict=True))
        elif z_tot is None:
            z_tot = self.describe(tests)[0]
        for reading in readings:
            if reading not in found:
                found[reading] = self._compare_alone(subsets, tests, z_tot, reading_of(reading), approximate)
        z, sizes = (np.stack([found[reading][k] for reading in readings]) for k in (0, 1))
        return z_tot, z, sizes

    def _compare_together(
        self,
        subsets: Sequence[np.ndarray],
        tests: np.ndarray,
        readings: Sequence[ReadingLike],
        z_tot: np.ndarray | None,
        weights: np.ndarray | None,
        packed: tuple[np.ndarray, int] | None,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Compare any number of subsets in passes of `MAX_SUBSETS`, under readings of the one surface."""
        distances, sizes, step = [], [], descriptors.MAX_SUBSETS
        for a in range(0, len(subsets), step) if packed is None else (0,):
            part = subsets[a : a + step]
            bit_words, n = packed or (descriptors.pack_subsets(self.index, part), len(part))
            weight = None if weights is None else weights[a : a + step]
            patches = (self.index, self.points[tests], bit_words, n, readings, z_tot, weight)
            z_tot, z, size = descriptors.compare_descriptors(*patches, **self._kernel)
            distances.append(z.T.reshape(len(readings), n, len(tests)))
            sizes.append(size.T.reshape(len(readings), n, len(tests)))
        assert z_tot is not None  # there is a subset at least
        return z_tot, np.concatenate(distances, axis=1), np.concatenate(sizes, axis=1)

    def _compare_alone(
        self,
        subsets: Sequence[np.ndarray],
        tests: np.ndarray,
        z_tot: np.ndarray,
        reading: Reading,
        approximate: bool,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Compare subsets that each form a surface of their own."""
        single = self.with_threads(1)  # the subsets are what the threads share
        build = (approximate and reading.build_approximate_index) or reading.build_index
        assert build is not None

        def compare_one(k: int, _: int) -> tuple[np.ndarray, np.ndarray]:
            dots = subsets[k]
            area, d_link = self.area, self.patches.d_link
            index = build(self.points[dots], self.normals[dots], d_link, area, self.density)
            return single.distances_to_index(index, tests, z_tot)

        z, sizes = zip(*parallel_map(compare_one, len(subsets), self.threads, 1), strict=True)
        return np.array(z), np.array(sizes)

    def compare_words(
        self,
        bit_words: np.ndarray,
        n_subsets: int,
        tests: np.ndarray,
        readings: Sequence[ReadingLike],
        z_tot: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Compute distances and patch sizes, (R, B, T), of any number of subsets B as `SubsetsOfDraw.words`, by position."""
        patches = (self.index, self.points[tests], bit_words, n_subsets, readings, z_tot)
        return descriptors.compare_many(*patches, **self._kernel)

    def patch_sizes(
        self, subsets: Sequence[np.ndarray], tests: np.ndarray, readings: Sequence[ReadingLike]
    ) -> np.ndarray:
        """Count the dots in the patches of B subsets at T test dots, (R, B, T), under readings of the one surface."""
        sizes, step, patches = [], descriptors.MAX_SUBSETS, self.patches
        for a in range(0, len(subsets), step):
            part = subsets[a : a + step]
            packed = descriptors.pack_subsets(self.index, part), len(part), readings
            found = descriptors.patch_sizes(
                self.index, self.points[tests], *packed, patches.r_zernike, self.threads
            )
            sizes.append(found.T.reshape(len(readings), len(part), len(tests)))
        return np.concatenate(sizes, axis=1)

    def compare_uniform(
        self,
        draw: int,
        sizes: np.ndarray,
        tests: np.ndarray,
        readings: Sequence[ReadingLike],
        z_tot: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Compute distances and patch sizes, (R, S, T), of the random subsets of one draw with `sizes` dots, ascending."""
        order = self.uniform_order(draw)
        if len(sizes) < MIN_NESTED:
            return self.compare([order[:n] for n in sizes], tests, readings, z_tot)[1:]
        patches = (self.index, self.points[tests], order, sizes, readings, z_tot)
        return descriptors.compare_nested(*patches, **self._kernel)

    def distances_to_index(
        self, index: PatchIndex, tests: np.ndarray, z_tot: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Compute |z_tot - z| and patch sizes, (T,), of another surface, given its PatchIndex, at test dots of this one."""
        # Every dot of the other surface is kept, and its patches are cut by its own links
        all_dots = np.ones(len(index.dot), np.uint64)
        patches = (index, self.points[tests], all_dots, 1, ("kept",), z_tot)
        _, z, sizes = descriptors.compare_descriptors(*patches, **self._kernel)
        return z[:, 0], sizes[:, 0]

    def with_dots(self, surface: Any) -> Self:
        """Return other dots prepared in the same way; their index, roughness, cover and area are computed from them."""
        return type(self)(surface, self.settings, None, self.stream, self.threads)

    def with_link(self, d_link: float) -> Self:
        """Return a copy whose islands are linked below another distance, Å; it is sampled as before, from the same cover."""
        return self._with(settings=self._settings_with(d_link=d_link), linked=_linked(self.surface, d_link))

    def with_cover(self, cover: published.Cover) -> Self:
        """Return a copy that is sampled from another cover of the same dots."""
        return self._with(given_cover=cover)

    def with_descriptor(self, name: str) -> Self:
        """Return a copy whose patches are described by another descriptor."""
        return self._with(settings=self._settings_with(descriptor=name))

    def with_streams(self, streams: Streams) -> Self:
        """Return a copy with other random streams."""
        return self._with(stream=streams)

    def with_threads(self, threads: int) -> Self:
        """Return a copy that is evaluated by another number of threads."""
        return self._with(threads=threads)

    def _settings_with(self, **of_patches: Any) -> Settings:
        """Return the settings with some keys of the patches replaced."""
        patches = self.patches.model_copy(update=of_patches)
        return self.settings.model_copy(update={"patches": patches})

    def _with(self, **changes: Any) -> Self:
        """Return a copy with some fields replaced, without what was computed from the former ones."""
        other = object.__new__(type(self))
        other._set(**{field.name: getattr(self, field.name) for field in fields(self)} | changes)
        return other

    def _set(self, **values: Any) -> None:
        """Set the fields of a new object, which is frozen from then on."""
        vars(self).update(values)


def _linked(surface: Any, d_link: float) -> Callable[[], PatchIndex]:
    """Return a function that builds the index of dots at its first call."""
    return cache(partial(build_index, surface.points, surface.normals, d_link))


def number_of_tests(requested: int | str, n_dots: int) -> int:
    """Return the number of test dots: the request, or N / 200 for 'published'; at least 2 and at most N."""
    n_tests = n_dots // DOTS_PER_PUBLISHED_TEST if isinstance(requested, str) else requested
    return max(2, min(n_tests, n_dots))
