"""Subsets of one sampler, the Z of the kept dots, and the error of the surface reconstructed from them."""

from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from sparsurf.arguments import Model
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.patches.readings import FULL_READING
from sparsurf.recovery.errors import TAIL_QUANTILE, distance_to_surface, kept_out
from sparsurf.recovery.readings import comparable_density
from sparsurf.recovery.reconstructing import (
    DENSITY_FOR_EXACT_ERRORS,
    DENSITY_FOR_SPHERES,
    INTERPOLANT,
    Reconstructed,
    distance_to_reconstructed,
    reconstruct_twice,
)
from sparsurf.sampling.combination import PUBLISHED_CHOICES, Choices
from sparsurf.sampling.cover import AtomCover
from sparsurf.sampling.samplers import SamplerLike, get_samplers, nearest_kept
from sparsurf.settings import BY_BACK, BY_FORTH, BY_MEAN
from sparsurf.surfaces.exact_distance import distance_of_dots
from sparsurf.surfaces.molecular_surface import RolledFrame, rolled_atoms
from sparsurf.surfaces.surface import Surface, SurfaceOrigin

MIN_RECONSTRUCTED_DOTS = 12  # no surface can be recovered from fewer
BACK_EVERY = 4  # n-th dot of a reconstructed surface whose distance from the true one is measured: at least 2.5 per Å^2
TEST_DENSITY = 8.0  # dots per Å^2 of the surface, on which errors are measured; other dots than those that are chosen from


class MeasuredError(NamedTuple):
    """Errors of the surface reconstructed from a subset, Å: mean, standard error of its logarithm, 99 % forth, 99 % back.

    The 99 % error back, of the reconstructed surface from the true one, is 0 where it is not measured.
    """

    mean: float
    log_error: float
    high_99: float = 0.0
    back_99: float = 0.0

    def over(self, error: float, error_99: float | None) -> float:
        """Return the largest ratio of the mean and the 99 % errors to what is requested; at most 1 where all are met."""
        return max(self._ratios(error, error_99).values())

    def decided_by(self, error: float, error_99: float | None) -> str:
        """Return the error with the largest of these ratios, as a key of `DECISIONS`."""
        ratios = self._ratios(error, error_99)
        return max(ratios, key=lambda name: ratios[name])

    def _ratios(self, error: float, error_99: float | None) -> dict[str, float]:
        """Return the ratio of each error to what is requested, by key of `DECISIONS`."""
        ratios = {BY_MEAN: self.mean / error}
        if error_99 is not None:
            ratios |= {BY_FORTH: self.high_99 / error_99, BY_BACK: self.back_99 / error_99}
        return ratios


class Trials:
    """Subsets of one sampler on one surface, from the random stream of the minimal subset, and what was measured of them."""

    def __init__(
        self,
        prepared: PreparedSurface,
        sampler: SamplerLike,
        n_tests: int,
        choices: Choices = PUBLISHED_CHOICES,
        model: Model = INTERPOLANT,
        atoms: SurfaceOrigin | None = None,
    ) -> None:
        self.prepared, self.model, self.atoms = prepared, model, atoms
        self.tests, self.n_dots = prepared.draw_tests(n_tests), len(prepared.points)
        ((self.sampler, self._sampler),) = get_samplers([sampler], "minimal.sampler", choices).items()
        self._z: dict[int, float] = {}  # requested n_S -> Z
        self._errors: dict[int, MeasuredError] = {}
        self._reconstructed: tuple[np.ndarray, Reconstructed] | None = None

    @cached_property
    def _z_tot(self) -> np.ndarray:
        """Descriptors of the full surface at the test dots."""
        return self.prepared.describe(self.tests)[0]

    @cached_property
    def _all_dots(self) -> np.ndarray:
        """All dots in the order of choice, for a nested sampler."""
        return self._draw(self.n_dots)

    def _draw(self, n: int) -> np.ndarray:
        """Call the sampler with its random stream."""
        return self._sampler(self.prepared, n, self.prepared.stream("minimal", self.sampler))

    def draw(self, n: int) -> np.ndarray:
        """Return (n,) int64 dots in the order of choice; the paper's samplers keep about n."""
        return self._all_dots[:n] if self._sampler.nested else self._draw(n)

    def distances(self, subset: np.ndarray) -> np.ndarray:
        """Compute |z_tot - z| of the kept dots as they are, under `full`, at the test dots, (T,)."""
        return self.prepared.distances([subset], self.tests, self._z_tot, FULL_READING)[0][0]

    def z(self, n: int) -> float:
        """Return Z of `n` dots under `full`."""
        if n not in self._z:
            self._z[n] = float(self.distances(self.draw(n)).mean())
        return self._z[n]

    def error(self, n: int) -> MeasuredError:
        """Measure the error of the surface reconstructed from `n` dots.

        Its standard error is over the cells of the kept dots: the errors around one dot vary together.
        """
        if n not in self._errors:
            self._errors[n] = self._measure_error(self.draw(n))
        return self._errors[n]

    @cached_property
    def cover(self) -> AtomCover:
        """The choice of dots that determine their atoms, of a surface whose atoms are known."""
        assert self.atoms is not None and self.rolled is not None
        return AtomCover(self.prepared.surface, self.atoms, self.rolled, self.prepared.threads)

    @cached_property
    def rolled(self) -> RolledFrame | None:
        """The atoms with the probe rolled over them, by the rules of their dots; None where the atoms are not known."""
        return None if self.atoms is None else rolled_atoms(self.atoms)

    @cached_property
    def test_surface(self) -> Surface | None:
        """Independent dots of the whole surface; None where the atoms of the dots are not known."""
        return None if self.rolled is None else self.rolled.surface(TEST_DENSITY)

    def distances_to_true(self, dots: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Measure the surface reconstructed from a subset: positions on the true surface (M, 3), and their distances (M,), Å.

        The positions are independent dots of the whole surface. Where its atoms are not known, they are the dots that were not
        kept, of which those near kept dots lie nearer to the reconstructed surface.
        """
        surface, threads, test = self.prepared.surface, self.prepared.threads, self.test_surface
        points = kept_out(surface.points, dots) if test is None else test.points
        return points, distance_to_reconstructed(points, self.few(dots), self.model, threads)

    def distances_back(self, dense: Surface) -> np.ndarray:
        """Measure the distances, Å, of each `BACK_EVERY`-th dot of a reconstructed surface from the true one.

        They are exact where the atoms are known, and else those from the planes of all dots.
        """
        points, normals, threads = (
            dense.points[::BACK_EVERY],
            dense.normals[::BACK_EVERY],
            self.prepared.threads,
        )
        if self.rolled is None or not self.rolled.exact:
            test = self.test_surface or self.prepared.surface
            return distance_to_surface(points, test.points, test.normals, threads)
        return distance_of_dots(points, normals, self.rolled, threads)

    def reconstructed(self, dots: np.ndarray) -> Reconstructed:
        """Reconstruct the surface from a subset: densely, and at a density at which it is compared with the whole surface.

        That of the last subset is kept.
        """
        if self._reconstructed is None or not np.array_equal(self._reconstructed[0], dots):
            prepared, is_exact = self.prepared, self.rolled is not None and self.rolled.exact
            density = comparable_density(prepared.density, prepared.patches.d_link)
            of_spheres = DENSITY_FOR_EXACT_ERRORS if is_exact else DENSITY_FOR_SPHERES
            found = reconstruct_twice(self.few(dots), density, self.model, prepared.threads, of_spheres)
            self._reconstructed = dots, found
        return self._reconstructed[1]

    def error_of(self, dots: np.ndarray) -> MeasuredError:
        """Measure the errors, in both directions, of the surface reconstructed from a subset."""
        found, threads = self.reconstructed(dots), self.prepared.threads
        points = (
            kept_out(self.prepared.points, dots) if self.test_surface is None else self.test_surface.points
        )
        errors = found.distances(points, threads, self.rolled)
        back = self.distances_back(found.dense)
        high_99, back_99 = (float(np.quantile(distances, TAIL_QUANTILE)) for distances in (errors, back))
        return MeasuredError(float(errors.mean()), 0.0, high_99, back_99)

    def errors_around(self, dots: np.ndarray) -> np.ndarray:
        """Measure how far each dot, or the surface reconstructed next to it, lies from the other surface, (N,) float64, Å."""
        from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

        found, points, threads = self.reconstructed(dots), self.prepared.points, self.prepared.threads
        errors = found.distances(points, threads)
        nearest = cKDTree(points).query(found.dense.points[::BACK_EVERY], workers=threads)[1]
        np.maximum.at(errors, nearest, self.distances_back(found.dense))
        return errors

    def few(self, dots: np.ndarray) -> Surface:
        """Return the surface of some dots, with what is known of their spheres."""
        few = self.prepared.surface.take(dots)
        return few if self.atoms is None else replace(few, reconstruction=self.atoms.reconstruction("auto"))

    def _measure_error(self, dots: np.ndarray) -> MeasuredError:
        """Measure the error of the surface reconstructed from a subset."""
        if len(dots) == self.n_dots:
            return MeasuredError(0.0, 0.0)
        points, errors = self.distances_to_true(dots)
        mean = float(errors.mean())
        cell = nearest_kept(
            np.concatenate([self.prepared.points[dots], points]), np.arange(len(dots)), self.prepared.threads
        )[0][len(dots) :]
        deviations = np.bincount(cell, weights=errors - mean)
        log_error = float(np.sqrt(np.sum(deviations**2)) / (len(errors) * mean))
        return MeasuredError(mean, log_error, float(np.quantile(errors, TAIL_QUANTILE)))
