"""Subsets of one sampler, the Z of the kept dots, and the error of the surface reconstructed from them."""

from functools import cached_property
from typing import NamedTuple

import numpy as np

from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.patches.readings import FULL_READING
from sparsurf.recovery.errors import DENSITY_FOR_ERRORS, distance_to_recovered, kept_out
from sparsurf.sampling.combination import PUBLISHED_CHOICES, Choices
from sparsurf.sampling.samplers import SamplerLike, get_samplers, nearest_kept

MIN_DOTS = 12  # no surface can be recovered from fewer


class MeasuredError(NamedTuple):
    """Mean error of the surface reconstructed from a subset, Å, and the standard error of its logarithm."""

    mean: float
    log_error: float


class Trials:
    """Subsets of one sampler on one surface, from the random stream of the minimal subset, and what was measured of them."""

    def __init__(
        self,
        prepared: PreparedSurface,
        sampler: SamplerLike,
        n_tests: int,
        choices: Choices = PUBLISHED_CHOICES,
    ) -> None:
        self.prepared = prepared
        self.tests, self.n_dots = prepared.draw_tests(n_tests), len(prepared.points)
        ((self.sampler, self._sampler),) = get_samplers([sampler], "minimal.sampler", choices).items()
        self._z: dict[int, float] = {}  # requested n_S -> Z
        self._errors: dict[int, MeasuredError] = {}

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

    def _measure_error(self, dots: np.ndarray) -> MeasuredError:
        """Measure the error of the surface reconstructed from a subset."""
        if len(dots) == self.n_dots:
            return MeasuredError(0.0, 0.0)
        surface, threads = self.prepared.surface, self.prepared.threads
        kept = surface.take(dots)
        distance = distance_to_recovered(
            surface.points, kept.points, kept.normals, threads, DENSITY_FOR_ERRORS
        )
        errors = kept_out(distance, dots)
        mean = float(errors.mean())
        cell = kept_out(nearest_kept(surface.points, dots, threads)[0], dots)
        deviations = np.bincount(cell, weights=errors - mean)
        return MeasuredError(mean, float(np.sqrt(np.sum(deviations**2)) / (len(errors) * mean)))
