"""A surface made ready for many evaluations: what one subset or many keep of its patches.

Source: paper, 'Optimization of the sampling parameters'.
"""

import copy
from functools import cached_property

import numpy as np

from sparsurf.patches import descriptors
from sparsurf.patches.index import D_LINK, R_PATCH, R_ZERNIKE, build_index
from sparsurf.patches.readings import OF_GRID
from sparsurf.patches.roughness import PUBLISHED, roughness
from sparsurf.recovery.readings import READINGS
from sparsurf.sampling import published
from sparsurf.sampling.combination import Combination
from sparsurf.streams import stream
from sparsurf.surfaces.spacing import area_of
from sparsurf.threads import parallel_map

AS_PUBLISHED_SHARE = 200  # the authors test N / 200 dots


class PreparedSurface:
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
    distance_from_moved_centre, chance_in_every_patch : bool
        The two defects of the published sampling, see `law.build_cover`.
    descriptor : str
        Name in `descriptors.DESCRIPTORS`.
    kind : str
        Of roughness where its values are not given, see `roughness.ROUGHNESS`.
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
        distance_from_moved_centre=True,
        chance_in_every_patch=True,
        descriptor=descriptors.PUBLISHED,
        kind=PUBLISHED,
    ):
        self.points, self.normals, self.surface = surface.points, surface.normals, surface
        self.r_patch, self.r_zernike, self.d_link, self.threads = r_patch, r_zernike, d_link, threads
        self.seed, self.name, self.descriptor = seed, name, descriptor
        self.stream_name = name
        self.index = build_index(surface.points, surface.normals, d_link)
        self.roughness = (
            roughness(self.index, r_patch, threads, kind) if roughness_values is None else roughness_values
        )
        self.cover = published.build_cover(
            self.index, self.roughness, r_patch, distance_from_moved_centre, chance_in_every_patch
        )

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
            defects["distance_from_moved_centre"],
            defects["chance_in_every_patch"],
            patches.get("descriptor", descriptors.PUBLISHED),
            patches.get("roughness", PUBLISHED),
        )

    @cached_property
    def corrected_cover(self):
        """The cover without the two defects of the published sampling."""
        return published.build_cover(self.index, self.roughness, self.r_patch, False, False)

    @cached_property
    def area(self):
        """Area in Å^2, estimated where the surface comes without areas."""
        return area_of(self.surface)[0]

    @property
    def density(self):
        """Dots per Å^2."""
        return len(self.points) / self.area

    def stream(self, *keys):
        """Random stream of this conformation for one purpose."""
        return stream(self.seed, self.stream_name, *keys)

    @property
    def nameless(self):
        """The same with random streams that do not depend on the name, as the subset that is handed out wants them."""
        return self.changed(stream_name="")

    def draw_tests(self, n_tests, *keys):
        """`n_tests` test dots (all where the surface has fewer), ascending."""
        n = len(self.points)
        return published.uniform_subset(n, min(n_tests, n), self.stream("tests", *keys))

    def pair(self, combination, draw):
        """The sampled subset of one draw and a uniform one of the same size."""
        keys = Combination(*combination).keys()
        sampled = published.sample(self.cover, combination, self.stream("sampled", *keys, draw))
        return sampled, published.uniform_subset(
            len(self.points), len(sampled), self.stream("uniform", *keys, draw)
        )

    def describe(self, tests, up=True):
        """Descriptors of the full surface at test dots, (T, 121), and the patch sizes, (T,)."""
        return descriptors.describe(
            self.index, self.points[tests], self.r_zernike, up, self.threads, self.descriptor
        )

    def distances(self, subsets, tests, z_tot, reading, weights=None, many=False):
        """|z_tot - z| of subsets at the test dots under a reading: (B, T) float64, and patch sizes, (B, T).

        `weights` (B, N), by position, count each kept dot; for readings of the one surface only. `many`: see `of_many` of
        a `readings.Reading`.
        """
        alone = (many and READINGS[reading].of_many) or READINGS[reading].alone
        if alone:
            one = self.changed(threads=1)
            found = parallel_map(
                lambda k, _: one.distances_alone(subsets[k], tests, z_tot, alone),
                len(subsets),
                self.threads,
                1,
            )
            return tuple(np.array(values) for values in zip(*found, strict=True))
        _, z, sizes = self._in_passes(subsets, tests, (reading,), z_tot, weights)
        return z[0], sizes[0]

    def distances_under(self, readings, subsets, tests):
        """z_tot at the test dots, (T, 121), and |z_tot - z| of subsets there: a dict of reading -> (B, T) float64."""
        together = tuple(reading for reading in readings if reading in OF_GRID)
        z_tot, z, _ = self._in_passes(subsets, tests, together)
        found = dict(zip(together, z, strict=True))
        others = [reading for reading in readings if reading not in found]
        return z_tot, found | {r: self.distances(subsets, tests, z_tot, r)[0] for r in others}

    def _in_passes(self, subsets, tests, readings, z_tot=None, weights=None):
        """As `compare`, of any number of subsets: z_tot, distances and patch sizes, (R, B, T)."""
        parts = []
        for a in range(0, len(subsets), descriptors.BITS):
            some = subsets[a : a + descriptors.BITS]
            words = descriptors.pack(self.index, some)
            weight = None if weights is None else weights[a : a + descriptors.BITS]
            z_tot, *found = self.compare(words, len(some), tests, readings, z_tot, weight)
            parts.append([each.reshape(len(readings), len(some), len(tests)) for each in found])
        return z_tot, *(np.concatenate(each, axis=1) for each in zip(*parts, strict=True))

    def compare(self, words, n_subsets, tests, readings, z_tot, weights=None):
        """z_tot, then (R B, T) distances and patch sizes of the subsets of packed words, by reading, in one pass."""
        place, radius = self.points[tests], self.r_zernike
        z_tot, z, sizes = descriptors.compare(
            self.index, place, words, n_subsets, readings, z_tot, weights, radius,
            threads=self.threads, descriptor=self.descriptor,
        )  # fmt: skip
        return z_tot, z.T, sizes.T

    def distances_alone(self, subset, tests, z_tot, alone):
        """|z_tot - z| of one subset that makes a surface of its own, (T,), and patch sizes, (T,).

        `alone` is that of a `readings.Reading`.
        """
        index = alone(self.points[subset], self.normals[subset], self.d_link, self.area, self.density)
        return self.distances_to_index(index, tests, z_tot)

    def distances_to_index(self, index, tests, z_tot):
        """|z_tot - z| of another surface (its Index) at the places of test dots of this one, and patch sizes, (T,)."""
        everything = np.ones(len(index.dot), np.uint64)
        z, sizes = descriptors.evaluate(
            index,
            self.points[tests],
            everything,
            1,
            "as_coded",
            z_tot,
            radius=self.r_zernike,
            threads=self.threads,
            descriptor=self.descriptor,
        )
        return z[:, 0], sizes[:, 0]

    def changed(self, **changes):
        """This evaluator with some attributes changed."""
        other = copy.copy(self)
        vars(other).update(changes)
        return other


def number_of_tests(requested, n_dots):
    """Number of test dots: as requested, or N / 200 for 'published'; never more than there are, at least 2."""
    return max(2, min(n_dots // AS_PUBLISHED_SHARE if requested == "published" else requested, n_dots))
